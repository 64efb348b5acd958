//! `BAL_PINHOLE`: Bundle Adjustment in the Large with a full pinhole; looks along -Z.
//!
//! u = -x / z, v = -y / z, s = 1 + k1 r2 + k2 r2^2, r2 = u^2 + v^2
//! px = fx s u + cx, py = fy s v + cy; y points up

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{focal, polynomial, principal_point};
use super::{BalPinhole, CameraModel, Linearized, Param};

impl CameraModel<6> for BalPinhole {
    const NAME: &str = "BAL_PINHOLE";
    const COLMAP_ID: Option<i32> = None;
    const WIDEST_ANGLE: f64 = FRAC_PI_2;
    const PARAMS: [Param; 6] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        polynomial("k1"),
        polynomial("k2"),
    ];
    const EXAMPLES: &[[f64; 6]] =
        &[[500.0, 490.0, 320.0, 240.0, -0.1, 0.02], [700.0, 690.0, 10.0, -20.0, 0.1, -0.08]];

    #[inline(always)]
    fn linearize(params: &[f64; 6], point: &Vector3<f64>) -> Option<Linearized<6>> {
        let [fx, fy, cx, cy, k @ ..] = *params;
        let seen = lens::pinhole_behind(point)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen, lens::radial(seen.at, &k)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 6], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [fx, fy, cx, cy, k @ ..] = *params;
        let seen = lens::undo_two_focals([fx, fy, cx, cy], pixel);
        Some(lens::unbend_radial(seen, &k)?.push(-1.0))
    }

    fn largest_angle(params: &[f64; 6]) -> f64 {
        let [.., k1, k2] = *params;
        lens::pinhole_fold(&[k1, k2])
    }
}
