//! What is estimated of a scene: all but what was seen.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

use super::{Camera, CameraId, Scene};

/// Cameras, poses and points of a scene, without what was seen.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Estimates {
    /// All cameras.
    pub cameras: BTreeMap<CameraId, Camera>,
    /// From world to camera, in the order of the images; none where an image has none.
    pub poses: Vec<Option<Isometry3<f64>>>,
    /// In world coordinates, in the order of the points.
    pub points: Vec<[f64; 3]>,
}

impl Scene {
    /// What is estimated of it.
    pub fn estimates(&self) -> Estimates {
        let geometry = self.geometry.as_ref();
        Estimates {
            cameras: self.cameras.clone(),
            poses: geometry.map(|it| it.poses()).unwrap_or_default(),
            points: geometry.iter().flat_map(|it| it.points.iter()).map(|it| it.xyz).collect(),
        }
    }

    /// Where every keypoint is, in px, in the order of the images.
    pub fn pixels(&self) -> Vec<Vec<[f64; 2]>> {
        let images = self.geometry.iter().flat_map(|it| it.images.values());
        images.map(|image| image.keypoints.iter().map(|it| it.xy).collect()).collect()
    }
}
