//! How a field is written in binary: little-endian, lists after their count, names up to a zero byte.

use std::io::{self, Write};

use super::sink::{Head, Sink};
use crate::camera::Model;
use crate::scene::{Point3DId, SensorKind};

/// A binary file, written from its start to its end.
pub struct Binary<'a> {
    out: &'a mut dyn Write,
    record: Vec<u8>,
}

impl<'a> Binary<'a> {
    /// Binary data to there.
    pub fn new(out: &'a mut dyn Write) -> Self {
        Self { out, record: Vec::new() }
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.record.extend_from_slice(bytes);
    }
}

impl Sink for Binary<'_> {
    fn head(&mut self, _: &Head, count: usize, _: usize) -> io::Result<()> {
        self.list(count);
        self.end_record()
    }

    fn u8(&mut self, value: u8) {
        self.bytes(&[value]);
    }

    fn u32(&mut self, value: u32) {
        self.bytes(&value.to_le_bytes());
    }

    fn u64(&mut self, value: u64) {
        self.bytes(&value.to_le_bytes());
    }

    fn f64(&mut self, value: f64) -> io::Result<()> {
        self.bytes(&value.to_le_bytes());
        Ok(())
    }

    fn model(&mut self, model: &Model) -> io::Result<()> {
        // Such a scene is refused before any file is made.
        let no_id = || io::Error::other(format!("{} has no number in binary", model.name));
        self.bytes(&model.colmap_id.ok_or_else(no_id)?.to_le_bytes());
        Ok(())
    }

    fn sensor_kind(&mut self, kind: SensorKind) {
        let number: i32 = match kind {
            SensorKind::Camera => 0,
            SensorKind::Imu => 1,
        };
        self.bytes(&number.to_le_bytes());
    }

    fn name(&mut self, name: &str) {
        self.bytes(name.as_bytes());
        self.bytes(&[0]);
    }

    fn point(&mut self, point: Option<Point3DId>) {
        self.u64(point.map_or(u64::MAX, |id| id.0));
    }

    fn second_line(&mut self, count: usize) -> io::Result<()> {
        self.list(count);
        Ok(())
    }

    fn list(&mut self, count: usize) {
        self.u64(count as u64);
    }

    fn end_record(&mut self) -> io::Result<()> {
        self.out.write_all(&self.record)?;
        self.record.clear();
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
