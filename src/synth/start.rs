//! Estimates as a reconstruction has them before its last adjustment: off by a known amount.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::Estimate;
use super::random::{Purpose, Random};
use super::world::placed;
use crate::camera::ParamClass;
use crate::scene::{Camera, Estimates, ImageId, Point3D, Points3D, Scene};

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

/// Starts from which a last adjustment would bring a scene back.
#[derive(Debug, Clone)]
pub struct Starts {
    estimates: Estimates,
    /// The median from points to the first camera that sees them.
    distance: f64,
}

impl Starts {
    /// Starts around the scene as it is.
    pub fn around(scene: &Scene) -> Self {
        let estimates = scene.estimates();
        let distance = scene.geometry.as_ref().map_or(0.0, |geometry| {
            median_distance(geometry.images.keys().copied().zip(&estimates.poses), &geometry.points)
        });
        Self { estimates, distance }
    }

    /// One of them: focal lengths and distortion off by this share of themselves (std), rotations about each axis by a tenth of
    /// that in rad, camera centres and points by a tenth of it of the median distance between cameras and what they see. Each run
    /// of a seed is off in its own way.
    pub fn off_by(&self, off: f64, seed: u64, run: u64) -> Estimates {
        let mut random = Random::new(seed, run, Purpose::Start);
        let Estimates { mut cameras, mut poses, mut points } = self.estimates.clone();
        for camera in cameras.values_mut() {
            *camera = camera_off_by(camera, off, &mut random);
        }
        let turned = off * RADIANS;
        let moved = turned * self.distance;
        for pose in poses.iter_mut().flatten() {
            *pose = pose_off_by(pose, turned, moved, &mut random);
        }
        for point in &mut points {
            *point = (Vector3::from(*point) + moved * random.normals()).into();
        }
        Estimates { cameras, poses, points }
    }
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
