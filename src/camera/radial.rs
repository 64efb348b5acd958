//! `RADIAL`: pinhole, one focal length, two radial terms.
//!
//! u = x / z, v = y / z, r2 = u^2 + v^2
//! s = 1 + k1 r2 + k2 r2^2,  px = f s u + cx, py = f s v + cy

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{focal, polynomial, principal_point};
use super::{CameraModel, Linearized, Param, Radial};

impl CameraModel<5> for Radial {
    const NAME: &str = "RADIAL";
    const COLMAP_ID: Option<i32> = Some(3);
    const WIDEST_ANGLE: f64 = FRAC_PI_2;
    const PARAMS: [Param; 5] = [
        focal("f"),
        principal_point("cx"),
        principal_point("cy"),
        polynomial("k1"),
        polynomial("k2"),
    ];
    const EXAMPLES: &[[f64; 5]] = &[
        [500.0, 320.0, 240.0, -0.1, 0.02],
        [700.0, 640.0, 480.0, -0.35, 0.15],
        [700.0, 640.0, 480.0, 0.1, -0.08],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 5], point: &Vector3<f64>) -> Option<Linearized<5>> {
        let [f, cx, cy, k @ ..] = *params;
        let seen = lens::pinhole(point)?;
        Some(lens::one_focal([f, cx, cy], seen, lens::radial(seen.at, &k)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 5], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [f, cx, cy, k @ ..] = *params;
        Some(lens::unbend_radial(lens::undo_one_focal([f, cx, cy], pixel), &k)?.push(1.0))
    }

    fn largest_angle(params: &[f64; 5]) -> f64 {
        let [.., k1, k2] = *params;
        lens::pinhole_fold(&[k1, k2])
    }
}
