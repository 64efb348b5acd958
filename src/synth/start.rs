//! Estimates as a reconstruction has them before its last adjustment: off by a known amount.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::Estimate;
use super::random::{Purpose, Random};
use super::world::placed;
use crate::camera::ParamClass;
use crate::scene::{Camera, ImageId, Point3D, Points3D, Scene};

/// By this many radians rotations are off when all else is off by 1: 10 m away, what a camera's place does by 1 m.
const RADIANS: f64 = 0.1;

impl Estimate {
    /// The same, off by this: see [`super::Options::start_off`].
    pub fn off_by(&self, off: f64, random: &mut Random) -> Self {
        let cameras =
            self.cameras.iter().map(|camera| camera_off_by(camera, off, random)).collect();
        let mut poses = self.poses.clone();
        let mut points = self.points.clone();
        // Nothing is recomputed when nothing is off, so that the truth stays the same to the last bit.
        if off > 0.0 {
            poses.iter_mut().for_each(|pose| *pose = pose_off_by(pose, off * RADIANS, off, random));
            points.iter_mut().for_each(|point| *point += off * random.normals());
        }
        Self { cameras, poses, points }
    }
}

/// A scene that a last adjustment would bring back: focal lengths and distortion off by this share of themselves (std), rotations
/// about each axis by a tenth of that in rad, camera centres and points by a tenth of it of the median distance between
/// cameras and what they see. Every image has a pose of its own then, rigs are dissolved; images without a pose stay. Each run
/// of a seed is off in its own way.
pub fn with_start_off(mut scene: Scene, off: f64, seed: u64, run: u64) -> Scene {
    let mut random = Random::new(seed, run, Purpose::Start);
    for camera in scene.cameras.values_mut() {
        *camera = camera_off_by(camera, off, &mut random);
    }
    let Some(geometry) = &mut scene.geometry else { return scene };
    let poses = geometry.poses();
    let distance = median_distance(geometry.images.keys().copied().zip(&poses), &geometry.points);
    for (image, pose) in geometry.images.values_mut().zip(poses) {
        let Some(pose) = pose else { continue };
        let off = off * RADIANS;
        image.cam_from_world = pose_off_by(&pose, off, off * distance, &mut random).into();
    }
    geometry.mounting = None;
    let mut points = Points3D::default();
    for point in geometry.points.iter() {
        let xyz = Vector3::from(point.xyz) + off * RADIANS * distance * random.normals();
        points.push(Point3D { xyz: xyz.into(), ..point });
    }
    geometry.points = points;
    scene
}

/// From each point to the first camera that sees it; zero without any.
fn median_distance<'a>(
    poses: impl Iterator<Item = (ImageId, &'a Option<Isometry3<f64>>)>,
    points: &Points3D,
) -> f64 {
    let poses: std::collections::BTreeMap<_, _> = poses.collect();
    let distance = |point: Point3D<crate::scene::Track<'_>>| {
        let first = point.track.clone().next()?;
        let pose = poses.get(&first.image).copied()?.as_ref()?;
        Some(pose.transform_point(&point.xyz.into()).coords.norm())
    };
    let mut distances: Vec<f64> = points.iter().filter_map(distance).collect();
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or(0.0)
}

/// Turned by so many rad about each axis, its centre moved by so much along each.
fn pose_off_by(
    pose: &Isometry3<f64>,
    turned: f64,
    moved: f64,
    random: &mut Random,
) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(turned * random.normals());
    let centre = pose.inverse().translation.vector + moved * random.normals();
    placed(turn * pose.rotation, centre)
}

fn camera_off_by(camera: &Camera, off: f64, random: &mut Random) -> Camera {
    let model = camera.intrinsics.model();
    let values = model.params.iter().zip(camera.intrinsics.params());
    let params: Vec<f64> = values
        .map(|(param, &value)| match param.class {
            ParamClass::Focal | ParamClass::Extra => value * (1.0 + off * random.normal()),
            ParamClass::PrincipalPoint | ParamClass::Metadata => value,
        })
        .collect();
    // As many and as finite as they were, unless `off` is beyond all measure: then the start is the truth.
    let intrinsics = model.with_params(&params).unwrap_or(camera.intrinsics);
    Camera { intrinsics, ..*camera }
}
