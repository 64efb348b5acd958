//! What the readers of records ask of a file, whether it is text or binary.

use super::Why;
use crate::camera::Model;
use crate::scene::{ImageId, Point3DId, Pose, SensorKind};

/// A reason not to go on, and the byte of the file where it showed.
#[derive(Debug)]
pub struct Fault {
    /// Bytes from the start of the file.
    pub at: usize,
    /// The reason; boxed, since a result of this type comes back from every field.
    pub why: Box<Why>,
}

impl Fault {
    /// This reason at this byte.
    #[cold]
    pub fn new(at: usize, why: Why) -> Self {
        Self { at, why: Box::new(why) }
    }
}

/// Something that a file lists.
pub struct Listed {
    /// The items, in the plural.
    pub name: &'static str,
    /// What their count is called.
    pub count: &'static str,
    /// How many fields an item has in text, where every item has as many.
    pub fields: usize,
    /// The fewest bytes an item takes in binary: no count is believed beyond the bytes that are left.
    pub min_bytes: usize,
}

/// What must be known of a file's records to find where one ends.
pub struct Layout {
    /// The records.
    pub records: Listed,
    /// How many lines a record has in text.
    pub lines: usize,
    /// How many bytes a record starts with in binary, before its name or its list.
    pub bytes_before_name: usize,
    /// Whether a name comes then.
    pub has_name: bool,
    /// What the list at the record's end holds; in binary an item takes its `min_bytes` and no more.
    pub items: Listed,
}

/// A part of a file that hands out the fields of its records, one after the other.
pub trait Source {
    /// Goes to the next record of the file's one list; false after the last of this part.
    fn next_record(&mut self, listed: &Listed) -> Result<bool, Fault>;
    /// Goes past the next record without reading it; false when it does not end in this part, or there is none.
    fn skip_record(&mut self, layout: &Layout) -> bool;
    /// In binary, how many records are still to come.
    fn records_left(&self) -> Option<usize>;
    /// The byte to read next, counted from the start of this part.
    fn at(&self) -> usize;
    /// Where the field handed out last starts, in bytes from the start of the file.
    fn mark(&self) -> usize;
    /// A number from 0 to 255.
    fn u8(&mut self, field: &'static str) -> Result<u8, Fault>;
    /// A number from 0 to 2^32 - 1.
    fn u32(&mut self, field: &'static str) -> Result<u32, Fault>;
    /// A number from 0 to 2^64 - 1.
    fn u64(&mut self, field: &'static str) -> Result<u64, Fault>;
    /// A finite number.
    fn f64(&mut self, field: &'static str) -> Result<f64, Fault>;
    /// A camera model.
    fn model(&mut self) -> Result<&'static Model, Fault>;
    /// How many parameters follow for a camera of this model.
    fn param_count(&mut self, model: &Model) -> usize;
    /// A sensor's kind.
    fn sensor_kind(&mut self) -> Result<SensorKind, Fault>;
    /// A name: in text, all that is left of the line.
    fn name(&mut self, field: &'static str) -> Result<&str, Fault>;
    /// The point that a keypoint is seen as, if any.
    fn point(&mut self, field: &'static str) -> Result<Option<Point3DId>, Fault>;
    /// Goes to where an image's keypoints are: in text, the next line, even an empty one.
    fn second_line(&mut self, image: ImageId) -> Result<(), Fault>;
    /// Reads a list, in text what is left of the line, item by item; the reader is told the item's index.
    fn items(
        &mut self,
        listed: &Listed,
        read: impl FnMut(&mut Self, usize) -> Result<(), Fault>,
    ) -> Result<(), Fault>;
    /// Ends a record whose last list has its count in front; in text, nothing may be left of the line.
    fn end_record(&mut self) -> Result<(), Fault>;

    /// This reason, at the field handed out last.
    #[cold]
    fn fault(&self, why: Why) -> Fault {
        Fault::new(self.mark(), why)
    }

    /// An id of four bytes; COLMAP keeps the last one for none.
    fn id(&mut self, field: &'static str) -> Result<u32, Fault> {
        match self.u32(field)? {
            u32::MAX => Err(self.fault(Why::Reserved { field, value: u32::MAX.into() })),
            id => Ok(id),
        }
    }

    /// Width or height.
    fn size(&mut self, field: &'static str) -> Result<u64, Fault> {
        match self.u64(field)? {
            0 => Err(self.fault(Why::Zero(field))),
            size => Ok(size),
        }
    }

    /// A rotation that is one, and a translation.
    fn pose(&mut self) -> Result<Pose, Fault> {
        let w = self.f64("qw")?;
        let at = self.mark();
        let quaternion = [w, self.f64("qx")?, self.f64("qy")?, self.f64("qz")?];
        if quaternion.iter().all(|part| part.abs() <= 0.0) {
            return Err(Fault::new(at, Why::NoRotation));
        }
        let translation = [self.f64("tx")?, self.f64("ty")?, self.f64("tz")?];
        Ok(Pose { quaternion, translation })
    }
}

/// The records of one kind of file, with what they may refer to.
pub trait Records {
    /// What they are read to.
    type Read;
    /// Reads all of them.
    fn read(self, source: &mut impl Source) -> Result<Self::Read, Fault>;
}
