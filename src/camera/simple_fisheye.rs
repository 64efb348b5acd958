//! `SIMPLE_FISHEYE`: equidistant fisheye, one focal length.
//!
//! theta = angle from the axis, (u, v) = theta (x, y) / |(x, y)|, r2 = theta^2
//! px = f u + cx, py = f v + cy

use std::f64::consts::PI;

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{focal, principal_point};
use super::{CameraModel, Linearized, Param, SimpleFisheye};

impl CameraModel<3> for SimpleFisheye {
    const NAME: &str = "SIMPLE_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(14);
    const PARAMS: [Param; 3] = [focal("f"), principal_point("cx"), principal_point("cy")];
    const EXAMPLES: &[[f64; 3]] = &[[427.761, 512.0, 512.0], [300.0, 320.0, 240.0]];

    #[inline(always)]
    fn linearize(params: &[f64; 3], point: &Vector3<f64>) -> Option<Linearized<3>> {
        let [f, cx, cy] = *params;
        let seen = lens::equidistant(point)?;
        Some(lens::one_focal([f, cx, cy], seen, lens::straight(seen.at)))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 3], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [f, cx, cy] = *params;
        lens::undo_equidistant(lens::undo_one_focal([f, cx, cy], pixel))
    }

    fn largest_angle(_: &[f64; 3]) -> f64 {
        PI
    }
}
