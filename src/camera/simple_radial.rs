//! `SIMPLE_RADIAL`: pinhole, one focal length, one radial term.
//!
//! u = x / z, v = y / z, r2 = u^2 + v^2
//! px = f u (1 + k r2) + cx, py = f v (1 + k r2) + cy

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{focal, polynomial, principal_point};
use super::{CameraModel, Linearized, Param, SimpleRadial};

impl CameraModel<4> for SimpleRadial {
    const NAME: &str = "SIMPLE_RADIAL";
    const COLMAP_ID: Option<i32> = Some(2);
    const WIDEST_ANGLE: f64 = FRAC_PI_2;
    const PARAMS: [Param; 4] =
        [focal("f"), principal_point("cx"), principal_point("cy"), polynomial("k").known_as("k1")];
    const EXAMPLES: &[[f64; 4]] = &[
        [500.0, 320.0, 240.0, -0.1],
        [1011.91, 640.0, 480.0, -0.241569],
        [2759.0, 1536.0, 1024.0, 0.02],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 4], point: &Vector3<f64>) -> Option<Linearized<4>> {
        let [f, cx, cy, k @ ..] = *params;
        let seen = lens::pinhole(point)?;
        Some(lens::one_focal([f, cx, cy], seen, lens::radial(seen.at, &k)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 4], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [f, cx, cy, k @ ..] = *params;
        Some(lens::unbend_radial(lens::undo_one_focal([f, cx, cy], pixel), &k)?.push(1.0))
    }

    fn largest_angle(params: &[f64; 4]) -> f64 {
        let [.., k] = *params;
        lens::pinhole_fold(&[k])
    }
}
