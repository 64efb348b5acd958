//! How a field is written in text: fields apart by blanks, a record a line, doubles with 17 digits.

use std::io::{self, Write};

use super::number::push_17_digits;
use super::sink::{Head, Sink};
use crate::camera::Model;
use crate::scene::{Point3DId, SensorKind};

/// A text file, written from its start to its end.
pub struct Text<'a> {
    out: &'a mut dyn Write,
    line: Vec<u8>,
    /// Whether the line's last blank stays, as COLMAP leaves it after keypoints and before an empty track.
    keeps_blank: bool,
}

impl<'a> Text<'a> {
    /// Text to there.
    pub fn new(out: &'a mut dyn Write) -> Self {
        Self { out, line: Vec::new(), keeps_blank: false }
    }

    /// Each field brings its blank along; what is one too many at the line's end goes there.
    fn field(&mut self, text: &[u8]) {
        self.line.extend_from_slice(text);
        self.line.push(b' ');
    }

    fn whole(&mut self, value: u64) {
        self.field(value.to_string().as_bytes());
    }

    fn end_line(&mut self) -> io::Result<()> {
        self.line.push(b'\n');
        self.out.write_all(&self.line)?;
        self.line.clear();
        Ok(())
    }
}

impl Sink for Text<'_> {
    fn head(&mut self, head: &Head, count: usize, items: usize) -> io::Result<()> {
        for comment in head.comment {
            writeln!(self.out, "# {comment}")?;
        }
        write!(self.line, "# Number of {}: {count}", head.records)?;
        if let Some(mean) = head.mean {
            write!(self.line, ", mean {mean}: ")?;
            push_17_digits(&mut self.line, items as f64 / count.max(1) as f64)?;
        }
        self.end_line()
    }

    fn u8(&mut self, value: u8) {
        self.whole(value.into());
    }

    fn u32(&mut self, value: u32) {
        self.whole(value.into());
    }

    fn u64(&mut self, value: u64) {
        self.whole(value);
    }

    fn f64(&mut self, value: f64) -> io::Result<()> {
        push_17_digits(&mut self.line, value)?;
        self.line.push(b' ');
        Ok(())
    }

    fn model(&mut self, model: &Model) -> io::Result<()> {
        self.field(model.name.as_bytes());
        Ok(())
    }

    fn sensor_kind(&mut self, kind: SensorKind) {
        self.field(match kind {
            SensorKind::Camera => b"CAMERA",
            SensorKind::Imu => b"IMU",
        });
    }

    fn name(&mut self, name: &str) {
        self.field(name.as_bytes());
    }

    fn point(&mut self, point: Option<Point3DId>) {
        match point {
            Some(id) => self.whole(id.0),
            None => self.field(b"-1"),
        }
    }

    fn second_line(&mut self, _: usize) -> io::Result<()> {
        self.end_record()?;
        self.keeps_blank = true;
        Ok(())
    }

    fn list(&mut self, count: usize) {
        self.keeps_blank = count == 0;
    }

    fn end_record(&mut self) -> io::Result<()> {
        if !self.keeps_blank {
            self.line.pop();
        }
        self.keeps_blank = false;
        self.end_line()
    }

    fn finish(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
