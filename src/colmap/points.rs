//! points3D.txt and points3D.bin: id, position, colour, error; then the track.

use std::collections::HashSet;

use super::Why;
use super::sightings::Sightings;
use super::source::{Fault, Listed, Records, Source};
use crate::scene::{ImageId, Point3D, Point3DId, Points3D, TrackElement};

/// The records of a points3D file.
pub struct Points<'a, 'images> {
    /// What the images saw, to be claimed by the tracks.
    pub sightings: &'a mut Sightings<'images>,
}

/// A point with an empty track takes 51 bytes.
const POINTS: Listed =
    Listed { name: "points", count: "count of points", fields: 1, min_bytes: 51 };
const TRACK: Listed =
    Listed { name: "track elements", count: "count of track elements", fields: 2, min_bytes: 8 };

impl Records for Points<'_, '_> {
    type Read = Points3D;

    fn read(self, source: &mut impl Source) -> Result<Self::Read, Fault> {
        let mut points = Points3D::default();
        let mut ids = HashSet::new();
        let mut track = Vec::new();
        while source.next_record(&POINTS)? {
            let id = new_id(source, &mut ids)?;
            let xyz = [source.f64("x")?, source.f64("y")?, source.f64("z")?];
            let rgb = [source.u8("red")?, source.u8("green")?, source.u8("blue")?];
            let error_px = source.f64("error")?;
            track.clear();
            for _ in 0..source.list(&TRACK)? {
                track.push(sighting(source, id, self.sightings)?);
            }
            points.push(Point3D { id, xyz, rgb, error_px, track: &track });
        }
        Ok(points)
    }
}

fn new_id(source: &mut impl Source, ids: &mut HashSet<Point3DId>) -> Result<Point3DId, Fault> {
    let field = "point id";
    match source.u64(field)? {
        value @ u64::MAX => Err(source.fault(Why::Reserved { field, value })),
        id if ids.insert(Point3DId(id)) => Ok(Point3DId(id)),
        id => Err(source.fault(Why::Duplicate { field, id })),
    }
}

fn sighting(
    source: &mut impl Source,
    point: Point3DId,
    sightings: &mut Sightings,
) -> Result<TrackElement, Fault> {
    let image = ImageId(source.u32("image id")?);
    let image_at = source.mark();
    let element = TrackElement { image, keypoint: source.u32("keypoint")? };
    match sightings.claim(element, point) {
        Ok(()) => Ok(element),
        Err(why @ Why::UnknownImage(_)) => Err(Fault::new(image_at, why)),
        Err(why) => Err(source.fault(why)),
    }
}
