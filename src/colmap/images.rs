//! images.txt and images.bin: id, pose, camera, name; then the keypoints.

use std::collections::{BTreeMap, HashSet};

use super::Why;
use super::excerpt::clipped;
use super::source::{Fault, Layout, Listed, Records, Source};
use crate::scene::{Camera, CameraId, Image, ImageId, Keypoint, Keypoints, Point3DId};

/// The records of an images file.
pub struct Images<'a, Take> {
    /// The cameras that may have taken them.
    pub cameras: &'a BTreeMap<CameraId, Camera>,
    /// Where they go.
    pub take: &'a mut Take,
}

/// What is done with images as they are read.
pub trait TakeImages {
    /// Whether no image had this id.
    fn is_new(&mut self, _: ImageId) -> bool {
        true
    }

    /// Whether no image had this name.
    fn is_new_name(&mut self, _: &str) -> bool {
        true
    }

    /// What is wrong with the keypoint of this index, which names this point.
    fn check(&mut self, _: ImageId, _index: usize, _: Point3DId) -> Result<(), Why> {
        Ok(())
    }

    /// An image that is read.
    fn take(&mut self, id: ImageId, image: Image);
}

/// An image with the empty name and no keypoint takes 73 bytes.
pub const IMAGES: Layout = Layout {
    records: Listed { name: "images", count: "count of images", fields: 1, min_bytes: 73 },
    lines: 2,
    bytes_before_name: 64,
    has_name: true,
    items: KEYPOINTS,
};
const KEYPOINTS: Listed =
    Listed { name: "keypoints", count: "count of keypoints", fields: 3, min_bytes: 24 };

impl<Take: TakeImages> Records for Images<'_, Take> {
    type Read = ();

    fn read(self, source: &mut impl Source) -> Result<(), Fault> {
        let mut keypoints = Keypoints::default();
        while source.next_record(&IMAGES.records)? {
            let field = "image id";
            let id = ImageId(source.id(field)?);
            if !self.take.is_new(id) {
                return Err(source.fault(Why::Duplicate { field, id: id.0.into() }));
            }
            let cam_from_world = source.pose()?;
            let camera = CameraId(source.id("camera id")?);
            if !self.cameras.contains_key(&camera) {
                return Err(source.fault(Why::UnknownCamera(camera)));
            }
            let name = source.name("image name")?.to_owned();
            if !self.take.is_new_name(&name) {
                return Err(source.fault(Why::DuplicateName(clipped(name.as_bytes()))));
            }
            source.second_line(id)?;
            let check = |index, point| self.take.check(id, index, point);
            read_keypoints(source, &mut keypoints, check)?;
            // The clone takes no more room than it needs.
            let keypoints = keypoints.clone();
            self.take.take(id, Image { name, camera, cam_from_world, keypoints });
        }
        Ok(())
    }
}

fn read_keypoints(
    source: &mut impl Source,
    keypoints: &mut Keypoints,
    mut check: impl FnMut(usize, Point3DId) -> Result<(), Why>,
) -> Result<(), Fault> {
    keypoints.clear();
    source.items(&KEYPOINTS, |source, index| {
        let xy = [source.f64("keypoint x")?, source.f64("keypoint y")?];
        let point = source.point("point id")?;
        if let Some(point) = point {
            check(index, point).map_err(|why| source.fault(why))?;
        }
        keypoints.push(Keypoint { xy, point });
        Ok(())
    })
}

/// One image after the other, unchecked against each other.
impl<Visit: FnMut(ImageId, Image)> TakeImages for Visit {
    fn take(&mut self, id: ImageId, image: Image) {
        self(id, image);
    }
}

/// Images in the order of the file, no id and no name twice.
#[derive(Default)]
pub struct Distinct {
    pub images: BTreeMap<ImageId, Image>,
    names: HashSet<String>,
}

impl TakeImages for Distinct {
    fn is_new(&mut self, id: ImageId) -> bool {
        !self.images.contains_key(&id)
    }

    fn is_new_name(&mut self, name: &str) -> bool {
        self.names.insert(name.to_owned())
    }

    fn take(&mut self, id: ImageId, image: Image) {
        self.images.insert(id, image);
    }
}
