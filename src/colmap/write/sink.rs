//! What the writers of records ask of a file, whether it is text or binary.

use std::io;

use crate::camera::Model;
use crate::scene::{Point3DId, Pose, SensorKind};

/// What stands above a file's records.
pub struct Head {
    /// What COLMAP calls the file, less the ending.
    pub kind: &'static str,
    /// COLMAP's comment, a line each.
    pub comment: &'static [&'static str],
    /// The records, in the plural.
    pub records: &'static str,
    /// What COLMAP says of their mean, if anything.
    pub mean: Option<&'static str>,
}

/// A file that takes the fields of its records, one after the other.
pub trait Sink {
    /// Begins the file's one list: `count` records, which hold `items` more in all.
    fn head(&mut self, head: &Head, count: usize, items: usize) -> io::Result<()>;
    /// A number from 0 to 255.
    fn u8(&mut self, value: u8);
    /// A number from 0 to 2^32 - 1.
    fn u32(&mut self, value: u32);
    /// A number from 0 to 2^64 - 1.
    fn u64(&mut self, value: u64);
    /// A finite number.
    fn f64(&mut self, value: f64) -> io::Result<()>;
    /// A camera model.
    fn model(&mut self, model: &Model) -> io::Result<()>;
    /// A sensor's kind.
    fn sensor_kind(&mut self, kind: SensorKind);
    /// A name that ends its line.
    fn name(&mut self, name: &str);
    /// The point that a keypoint is seen as, if any.
    fn point(&mut self, point: Option<Point3DId>);
    /// An image's keypoints follow, so many: in text, on the next line.
    fn second_line(&mut self, count: usize) -> io::Result<()>;
    /// So many items follow: in text, up to the end of the line.
    fn list(&mut self, count: usize);
    /// Ends a record.
    fn end_record(&mut self) -> io::Result<()>;
    /// Ends the file.
    fn finish(&mut self) -> io::Result<()>;

    /// A count of four bytes.
    fn short_count(&mut self, count: usize) -> io::Result<()> {
        self.u32(u32::try_from(count).map_err(io::Error::other)?);
        Ok(())
    }

    /// Several numbers.
    fn f64s(&mut self, values: &[f64]) -> io::Result<()> {
        values.iter().try_for_each(|&value| self.f64(value))
    }

    /// Rotation and translation.
    fn pose(&mut self, pose: &Pose) -> io::Result<()> {
        self.f64s(&pose.quaternion)?;
        self.f64s(&pose.translation)
    }
}
