//! `SIMPLE_RADIAL_FISHEYE`: equidistant fisheye with one term.
//!
//! theta = angle from the axis, (u, v) = theta (x, y) / |(x, y)|, r2 = theta^2
//! px = f u (1 + k r2) + cx, py = f v (1 + k r2) + cy

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{focal, polynomial, principal_point};
use super::{CameraModel, Linearized, Param, SimpleRadialFisheye};

impl CameraModel<4> for SimpleRadialFisheye {
    const NAME: &str = "SIMPLE_RADIAL_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(8);
    const PARAMS: [Param; 4] =
        [focal("f"), principal_point("cx"), principal_point("cy"), polynomial("k").known_as("k1")];
    const EXAMPLES: &[[f64; 4]] = &[
        [427.761, 512.0, 512.0, -0.0768701],
        [419.312, 512.0, 512.0, -0.0677735],
        [463.0, 376.0, 240.0, 0.0031],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 4], point: &Vector3<f64>) -> Option<Linearized<4>> {
        let [f, cx, cy, k @ ..] = *params;
        let seen = lens::equidistant(point)?;
        Some(lens::one_focal([f, cx, cy], seen, lens::radial(seen.at, &k)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 4], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [f, cx, cy, k @ ..] = *params;
        lens::undo_equidistant(lens::unbend_radial(lens::undo_one_focal([f, cx, cy], pixel), &k)?)
    }

    fn largest_angle(params: &[f64; 4]) -> f64 {
        let [.., k] = *params;
        lens::fisheye_fold(&[k])
    }
}
