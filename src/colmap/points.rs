//! points3D.txt and points3D.bin: id, position, colour, error; then the track.

use super::Why;
use super::source::{Fault, Layout, Listed, Records, Source};
use crate::scene::{ImageId, Point3D, Point3DId, TrackElement};

/// The records of a points3D file.
pub struct Points<'a, Take> {
    /// Where they go.
    pub take: &'a mut Take,
}

/// A point whose track is still where it was read to.
pub type ReadPoint<'a> = Point3D<&'a [TrackElement]>;

/// What is done with points as they are read.
pub trait TakePoints {
    /// Whether no point had this id.
    fn is_new(&mut self, _: Point3DId) -> bool {
        true
    }

    /// What is wrong with this sighting in the point's track.
    fn check(&mut self, _: Point3DId, _: TrackElement) -> Result<(), Why> {
        Ok(())
    }

    /// A point that is read.
    fn take(&mut self, point: ReadPoint);
}

/// A point with an empty track takes 51 bytes.
pub const POINTS: Layout = Layout {
    records: Listed { name: "points", count: "count of points", fields: 1, min_bytes: 51 },
    lines: 1,
    bytes_before_name: 43,
    has_name: false,
    items: TRACK,
};
const TRACK: Listed =
    Listed { name: "track elements", count: "count of track elements", fields: 2, min_bytes: 8 };

impl<Take: TakePoints> Records for Points<'_, Take> {
    type Read = ();

    fn read(self, source: &mut impl Source) -> Result<(), Fault> {
        let mut track = Vec::new();
        while source.next_record(&POINTS.records)? {
            let id = id(source, self.take)?;
            let xyz = [source.f64("x")?, source.f64("y")?, source.f64("z")?];
            let rgb = [source.u8("red")?, source.u8("green")?, source.u8("blue")?];
            let error_px = source.f64("error")?;
            track.clear();
            source.items(&TRACK, |source, _| {
                track.push(sighting(source, id, self.take)?);
                Ok(())
            })?;
            self.take.take(Point3D { id, xyz, rgb, error_px, track: &track });
        }
        Ok(())
    }
}

fn id(source: &mut impl Source, take: &mut impl TakePoints) -> Result<Point3DId, Fault> {
    let field = "point id";
    match source.u64(field)? {
        value @ u64::MAX => Err(source.fault(Why::Reserved { field, value })),
        id if take.is_new(Point3DId(id)) => Ok(Point3DId(id)),
        id => Err(source.fault(Why::Duplicate { field, id })),
    }
}

fn sighting(
    source: &mut impl Source,
    point: Point3DId,
    take: &mut impl TakePoints,
) -> Result<TrackElement, Fault> {
    let image = ImageId(source.u32("image id")?);
    let image_at = source.mark();
    let element = TrackElement { image, keypoint: source.u32("keypoint")? };
    match take.check(point, element) {
        Ok(()) => Ok(element),
        Err(why @ Why::UnknownImage(_)) => Err(Fault::new(image_at, why)),
        Err(why) => Err(source.fault(why)),
    }
}

/// One point after the other, unchecked against each other.
impl<Visit: FnMut(ReadPoint)> TakePoints for Visit {
    fn take(&mut self, point: ReadPoint) {
        self(point);
    }
}
