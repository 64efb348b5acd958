//! Estimates as a reconstruction has them before its last adjustment: off by a known amount.

use nalgebra::UnitQuaternion;

use super::Estimate;
use super::random::Random;
use super::world::placed;
use crate::camera::ParamClass;
use crate::scene::Camera;

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
            for pose in &mut poses {
                let turn = UnitQuaternion::from_scaled_axis(off * RADIANS * random.normals());
                let centre = pose.inverse().translation.vector + off * random.normals();
                *pose = placed(turn * pose.rotation, centre);
            }
            points.iter_mut().for_each(|point| *point += off * random.normals());
        }
        Self { cameras, poses, points }
    }
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
