//! images.txt and images.bin: id, pose, camera, name; then the keypoints.

use std::collections::BTreeMap;

use super::Why;
use super::source::{Fault, Listed, Records, Source};
use crate::scene::{Camera, CameraId, Image, ImageId, Keypoint, Keypoints, Point3DId};

/// The records of an images file.
pub struct Images<'a, Check> {
    /// The cameras that may have taken them.
    pub cameras: &'a BTreeMap<CameraId, Camera>,
    /// Asked about every keypoint that names a point: what is wrong with it, if anything.
    pub check: Check,
}

/// An image with the empty name and no keypoint takes 73 bytes.
const IMAGES: Listed =
    Listed { name: "images", count: "count of images", fields: 1, min_bytes: 73 };
const KEYPOINTS: Listed =
    Listed { name: "keypoints", count: "count of keypoints", fields: 3, min_bytes: 24 };

impl<Check: Fn(ImageId, usize, Point3DId) -> Result<(), Why>> Records for Images<'_, Check> {
    type Read = BTreeMap<ImageId, Image>;

    fn read(self, source: &mut impl Source) -> Result<Self::Read, Fault> {
        let mut images = BTreeMap::new();
        while source.next_record(&IMAGES)? {
            let field = "image id";
            let id = ImageId(source.id(field)?);
            if images.contains_key(&id) {
                return Err(source.fault(Why::Duplicate { field, id: id.0.into() }));
            }
            let cam_from_world = source.pose()?;
            let camera = CameraId(source.id("camera id")?);
            if !self.cameras.contains_key(&camera) {
                return Err(source.fault(Why::UnknownCamera(camera)));
            }
            let name = source.name("image name")?.to_owned();
            source.second_line(id)?;
            let check = |index, point| (self.check)(id, index, point);
            let keypoints = keypoints(source, check)?;
            images.insert(id, Image { name, camera, cam_from_world, keypoints });
        }
        Ok(images)
    }
}

fn keypoints(
    source: &mut impl Source,
    check: impl Fn(usize, Point3DId) -> Result<(), Why>,
) -> Result<Keypoints, Fault> {
    let count = source.list(&KEYPOINTS)?;
    let mut keypoints = Keypoints::with_capacity(count);
    for index in 0..count {
        let xy = [source.f64("keypoint x")?, source.f64("keypoint y")?];
        let point = source.point("point id")?;
        if let Some(point) = point {
            check(index, point).map_err(|why| source.fault(why))?;
        }
        keypoints.push(Keypoint { xy, point });
    }
    Ok(keypoints)
}
