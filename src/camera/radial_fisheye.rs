//! `RADIAL_FISHEYE`: equidistant fisheye with two terms.
//!
//! theta = angle from the axis, (u, v) = theta (x, y) / |(x, y)|, r2 = theta^2
//! s = 1 + k1 r2 + k2 r2^2,  px = f s u + cx, py = f s v + cy

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{focal, polynomial, principal_point};
use super::{CameraModel, Linearized, Param, RadialFisheye};

impl CameraModel<5> for RadialFisheye {
    const NAME: &str = "RADIAL_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(9);
    const PARAMS: [Param; 5] = [
        focal("f"),
        principal_point("cx"),
        principal_point("cy"),
        polynomial("k1"),
        polynomial("k2"),
    ];
    const EXAMPLES: &[[f64; 5]] =
        &[[427.761, 512.0, 512.0, -0.07, 0.01], [419.312, 512.0, 512.0, 0.05, -0.02]];

    #[inline(always)]
    fn linearize(params: &[f64; 5], point: &Vector3<f64>) -> Option<Linearized<5>> {
        let [f, cx, cy, k @ ..] = *params;
        let seen = lens::equidistant(point)?;
        Some(lens::one_focal([f, cx, cy], seen, lens::radial(seen.at, &k)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 5], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [f, cx, cy, k @ ..] = *params;
        lens::undo_equidistant(lens::unbend_radial(lens::undo_one_focal([f, cx, cy], pixel), &k)?)
    }

    fn largest_angle(params: &[f64; 5]) -> f64 {
        let [.., k1, k2] = *params;
        lens::fisheye_fold(&[k1, k2])
    }
}
