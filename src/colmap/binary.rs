//! How a field is written in binary: little-endian, lists after their count, names up to a zero byte.

use super::Why;
use super::source::{Fault, Listed, Source};
use crate::camera::Model;
use crate::scene::{ImageId, Point3DId, SensorKind};

/// A binary file, read from its start to its end.
pub struct Binary<'a> {
    bytes: &'a [u8],
    /// The byte to read next.
    at: usize,
    mark: usize,
    /// How many records are still to come, once the file has said so.
    records_left: Option<usize>,
}

impl<'a> Binary<'a> {
    /// Binary data from these bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, mark: 0, records_left: None }
    }

    fn left(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn take<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], Fault> {
        self.mark = self.at;
        let Some(&taken) = self.left().first_chunk() else {
            return Err(self.fault(Why::Truncated(field)));
        };
        self.at += N;
        Ok(taken)
    }
}

impl Source for Binary<'_> {
    fn next_record(&mut self, listed: &Listed) -> Result<bool, Fault> {
        let left = match self.records_left {
            Some(left) => left,
            None => self.list(listed)?,
        };
        self.records_left = Some(left.saturating_sub(1));
        if left == 0 && !self.left().is_empty() {
            return Err(Fault::new(self.at, Why::TrailingBytes(self.left().len())));
        }
        Ok(left > 0)
    }

    fn mark(&self) -> usize {
        self.mark
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
        Model::with_colmap_id(id).map_err(|error| self.fault(Why::Camera(error)))
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
        let Some(length) = self.left().iter().position(|&byte| byte == 0) else {
            return Err(self.fault(Why::Unterminated(field)));
        };
        let name = &self.left()[..length];
        self.at += length + 1;
        std::str::from_utf8(name)
            .map_err(|error| Fault::new(self.mark + error.valid_up_to(), Why::NotUtf8(field)))
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

    fn list(&mut self, listed: &Listed) -> Result<usize, Fault> {
        let count = self.u64(listed.count)?;
        let room = self.left().len() / listed.min_bytes;
        match usize::try_from(count) {
            Ok(count) if count <= room => Ok(count),
            _ => {
                let (items, left) = (listed.name, self.left().len());
                Err(self.fault(Why::CountTooLarge { items, count, left }))
            }
        }
    }

    fn end_record(&mut self) -> Result<(), Fault> {
        Ok(())
    }
}
