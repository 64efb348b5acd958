//! One reconstruction as plain data: cameras, images, points, rigs, frames.
//!
//! Knows nothing of files. What a scene refers to exists in it: whoever builds one checks that once, at the door.

mod compact;
mod estimates;
mod id;
mod keypoints;
mod plausible;
mod points;
mod pose;
mod subset;

use std::collections::BTreeMap;

pub use estimates::Estimates;
pub use id::{CameraId, FrameId, ImageId, Point3DId, RigId};
pub use keypoints::{Keypoint, Keypoints};
pub use points::{Point3D, Points3D, Track, TrackElement};

use crate::camera::Intrinsics;

/// One reconstruction, or the cameras of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Every camera, used by an image or not.
    pub cameras: BTreeMap<CameraId, Camera>,
    /// What the cameras saw; none when the scene is a lone list of cameras.
    pub geometry: Option<Geometry>,
}

/// A camera: its model with parameters, and its image size in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Model and parameters.
    pub intrinsics: Intrinsics,
    /// Width of its images, in px, above 0.
    pub width: u64,
    /// Height of its images, in px, above 0.
    pub height: u64,
}

/// Images, the points they see, and how the cameras are mounted.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// The registered images.
    pub images: BTreeMap<ImageId, Image>,
    /// The triangulated points.
    pub points: Points3D,
    /// Rigs and frames; none in models older than COLMAP 3.12.
    pub mounting: Option<Mounting>,
}

/// Rigs, and the frames in which they were exposed.
///
/// With a mounting, an image's pose is sensor_from_rig times rig_from_world, and the one that the image carries does not count.
#[derive(Debug, Clone, PartialEq)]
pub struct Mounting {
    /// Sensors fixed to each other.
    pub rigs: BTreeMap<RigId, Rig>,
    /// One exposure of a rig.
    pub frames: BTreeMap<FrameId, Frame>,
}

/// A registered image.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Its path below the image folder.
    pub name: String,
    /// The camera that took it.
    pub camera: CameraId,
    /// From world to camera coordinates.
    pub cam_from_world: Pose,
    /// What was detected in it.
    pub keypoints: Keypoints,
}

/// A rigid transform, as the file has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Rotation as w, x, y, z; kept as read, so not always of unit length.
    pub quaternion: [f64; 4],
    /// Translation.
    pub translation: [f64; 3],
}

/// Sensors fixed to each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// The sensor in whose coordinates the rig's are; none in a rig without sensors.
    pub reference: Option<SensorId>,
    /// The other sensors, with their sensor_from_rig where it is known.
    pub sensors: BTreeMap<SensorId, Option<Pose>>,
}

/// One exposure of a rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// The rig exposed.
    pub rig: RigId,
    /// From world to rig coordinates.
    pub rig_from_world: Pose,
    /// What its sensors recorded: for a camera, an image id.
    pub data: Vec<(SensorId, u64)>,
}

/// A sensor of a rig. A camera's id is its `CameraId`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct SensorId {
    /// What it is.
    pub kind: SensorKind,
    /// Its id among sensors of its kind.
    pub id: u32,
}

/// What a sensor of a rig is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SensorKind {
    /// A camera.
    Camera,
    /// An inertial measurement unit.
    Imu,
}
