//! How a field is written in binary: little-endian, lists after their count, names up to a zero byte.

use super::Why;
use super::block::Block;
use super::source::{Fault, Layout, Listed, Source};
use crate::camera::Model;
use crate::scene::{ImageId, Point3DId, SensorKind};

/// Whole records of a binary file, or the file's start or end.
pub struct Binary<'a> {
    block: &'a Block,
    /// The byte to read next, and the start of the field read last, counted from the start of the block.
    at: usize,
    mark: usize,
    /// How many records are still to come, once the file has said so.
    records_left: Option<usize>,
}

impl<'a> Binary<'a> {
    /// Binary data from this block.
    pub fn new(block: &'a Block) -> Self {
        Self { block, at: 0, mark: 0, records_left: block.records_left }
    }

    /// What is left of the block.
    fn rest(&self) -> &'a [u8] {
        &self.block.bytes[self.at..]
    }

    /// How many bytes are left of the file.
    fn left(&self) -> usize {
        self.block.file_length - self.block.offset - self.at
    }

    #[inline]
    fn take<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], Fault> {
        self.mark = self.at;
        let Some(&taken) = self.rest().first_chunk() else {
            return Err(self.fault(Why::Truncated(field)));
        };
        self.at += N;
        Ok(taken)
    }

    /// How many items follow.
    fn count(&mut self, listed: &Listed) -> Result<usize, Fault> {
        let count = self.u64(listed.count)?;
        let left = self.left();
        match usize::try_from(count) {
            Ok(count) if count <= left / listed.min_bytes => Ok(count),
            _ => Err(self.fault(Why::CountTooLarge { items: listed.name, count, left })),
        }
    }

    /// Counts the records down from what the file says.
    fn count_down(&mut self, listed: &Listed) -> Result<usize, Fault> {
        let left = match self.records_left {
            Some(left) => left,
            None => self.count(listed)?,
        };
        self.records_left = Some(left.saturating_sub(1));
        Ok(left)
    }

    /// Goes past a record's fields without looking at their values.
    fn pass(&mut self, layout: &Layout) -> Result<(), Fault> {
        self.at += layout.bytes_before_name;
        let beyond = |binary: &Self| binary.fault(Why::Truncated(layout.records.name));
        if layout.has_name {
            let rest = self.block.bytes.get(self.at..);
            let length = rest.and_then(|rest| memchr::memchr(0, rest));
            self.at += 1 + length.ok_or_else(|| beyond(self))?;
        }
        if self.at > self.block.bytes.len() {
            return Err(beyond(self));
        }
        self.at += self.count(&layout.items)? * layout.items.min_bytes;
        if self.at <= self.block.bytes.len() { Ok(()) } else { Err(beyond(self)) }
    }
}

impl Source for Binary<'_> {
    fn next_record(&mut self, listed: &Listed) -> Result<bool, Fault> {
        let is_after_last = self.rest().is_empty() && !self.block.is_last();
        if is_after_last && self.records_left.is_some() {
            return Ok(false);
        }
        let left = self.count_down(listed)?;
        if left == 0 && self.left() > 0 {
            return Err(Fault::new(self.block.offset + self.at, Why::TrailingBytes(self.left())));
        }
        Ok(left > 0)
    }

    fn skip_record(&mut self, layout: &Layout) -> bool {
        self.count_down(&layout.records).is_ok_and(|left| left > 0) && self.pass(layout).is_ok()
    }

    fn records_left(&self) -> Option<usize> {
        self.records_left
    }

    fn at(&self) -> usize {
        self.at
    }

    fn mark(&self) -> usize {
        self.block.offset + self.mark
    }

    fn u8(&mut self, field: &'static str) -> Result<u8, Fault> {
        self.take(field).map(u8::from_le_bytes)
    }

    fn u32(&mut self, field: &'static str) -> Result<u32, Fault> {
        self.take(field).map(u32::from_le_bytes)
    }

    fn u64(&mut self, field: &'static str) -> Result<u64, Fault> {
        self.take(field).map(u64::from_le_bytes)
    }

    fn f64(&mut self, field: &'static str) -> Result<f64, Fault> {
        let number = f64::from_le_bytes(self.take(field)?);
        if number.is_finite() {
            Ok(number)
        } else {
            Err(self.fault(Why::NotFinite { field, text: number.to_string() }))
        }
    }

    fn model(&mut self) -> Result<&'static Model, Fault> {
        let id = i32::from_le_bytes(self.take("camera model")?);
        Model::with_colmap_id(id).map_err(|error| self.fault(Why::Camera(error.into())))
    }

    fn param_count(&mut self, model: &Model) -> usize {
        model.params.len()
    }

    fn sensor_kind(&mut self) -> Result<SensorKind, Fault> {
        match i32::from_le_bytes(self.take("sensor type")?) {
            0 => Ok(SensorKind::Camera),
            1 => Ok(SensorKind::Imu),
            other => Err(self.fault(Why::SensorKind(other.to_string()))),
        }
    }

    fn name(&mut self, field: &'static str) -> Result<&str, Fault> {
        self.mark = self.at;
        let Some(length) = memchr::memchr(0, self.rest()) else {
            return Err(self.fault(Why::Unterminated(field)));
        };
        let name = &self.rest()[..length];
        self.at += length + 1;
        std::str::from_utf8(name)
            .map_err(|error| Fault::new(self.mark() + error.valid_up_to(), Why::NotUtf8(field)))
    }

    fn point(&mut self, field: &'static str) -> Result<Option<Point3DId>, Fault> {
        Ok(match self.u64(field)? {
            u64::MAX => None,
            id => Some(Point3DId(id)),
        })
    }

    fn second_line(&mut self, _: ImageId) -> Result<(), Fault> {
        Ok(())
    }

    fn items(
        &mut self,
        listed: &Listed,
        mut read: impl FnMut(&mut Self, usize) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let count = self.count(listed)?;
        (0..count).try_for_each(|index| read(self, index))
    }

    fn end_record(&mut self) -> Result<(), Fault> {
        Ok(())
    }
}
