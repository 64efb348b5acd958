//! `FISHEYE`: equidistant fisheye, two focal lengths.
//!
//! theta = angle from the axis, (u, v) = theta (x, y) / |(x, y)|, r2 = theta^2
//! px = fx u + cx, py = fy v + cy

use std::f64::consts::PI;

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{focal, principal_point};
use super::{CameraModel, Fisheye, Linearized, Param};

impl CameraModel<4> for Fisheye {
    const NAME: &str = "FISHEYE";
    const COLMAP_ID: Option<i32> = Some(15);
    const PARAMS: [Param; 4] =
        [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy")];
    const EXAMPLES: &[[f64; 4]] = &[[427.761, 425.0, 512.0, 512.0], [300.0, 310.0, 320.0, 240.0]];

    #[inline(always)]
    fn linearize(params: &[f64; 4], point: &Vector3<f64>) -> Option<Linearized<4>> {
        let [fx, fy, cx, cy] = *params;
        let seen = lens::equidistant(point)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen, lens::straight(seen.at)))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 4], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [fx, fy, cx, cy] = *params;
        lens::undo_equidistant(lens::undo_two_focals([fx, fy, cx, cy], pixel))
    }

    fn largest_angle(_: &[f64; 4]) -> f64 {
        PI
    }
}
