//! `THIN_PRISM_FISHEYE`: equidistant fisheye with radial, tangential and thin-prism terms.
//!
//! theta = angle from the axis, (u, v) = theta (x, y) / |(x, y)|, r2 = theta^2
//! s = 1 + k1 r2 + k2 r2^2 + k3 r2^3 + k4 r2^4
//! px = fx (s u + 2 p1 u v + p2 (r2 + 2 u^2) + sx1 r2) + cx
//! py = fy (s v + 2 p2 u v + p1 (r2 + 2 v^2) + sy1 r2) + cy
//!
//! J. Weng, P. Cohen, M. Herniou, Camera Calibration with Distortion Models, PAMI 1992.

use nalgebra::{Vector2, Vector3};

use super::lens::{self, Bent};
use super::param::{focal, polynomial, principal_point};
use super::{CameraModel, Linearized, Param, ThinPrismFisheye};

impl CameraModel<12> for ThinPrismFisheye {
    const NAME: &str = "THIN_PRISM_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(10);
    const PARAMS: [Param; 12] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        polynomial("k1"),
        polynomial("k2"),
        polynomial("p1"),
        polynomial("p2"),
        polynomial("k3"),
        polynomial("k4"),
        polynomial("sx1"),
        polynomial("sy1"),
    ];
    const EXAMPLES: &[[f64; 12]] = &[
        [
            402.294, 437.448, 512.0, 512.0, -0.08, 0.02, 0.001, -0.0005, -0.004, 0.0005, 0.002,
            -0.001,
        ],
        [500.0, 490.0, 320.0, 240.0, 0.01, -0.02, 0.0004, 0.0003, 0.006, -0.001, -0.0002, 0.0006],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 12], point: &Vector3<f64>) -> Option<Linearized<12>> {
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let seen = lens::equidistant(point)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen, bent(bend, seen.at)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 12], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let target = lens::undo_two_focals([fx, fy, cx, cy], pixel);
        lens::undo_equidistant(lens::unbend(target, |at| bent(bend, at))?)
    }

    fn largest_angle(params: &[f64; 12]) -> f64 {
        let [.., k1, k2, _, _, k3, k4, _, _] = *params;
        lens::fisheye_fold(&[k1, k2, k3, k4])
    }
}

#[inline(always)]
fn bent([k1, k2, p1, p2, k3, k4, sx1, sy1]: [f64; 8], at: Vector2<f64>) -> Option<Bent<8>> {
    let k = (&[k1, k2, k3, k4], [0, 1, 4, 5]);
    let mut bent: Bent<8> = lens::brown(at, k, ([p1, p2], [2, 3]))?;
    let r2 = at.norm_squared();
    let prism = Vector2::new(sx1, sy1);
    bent.at += prism * r2;
    bent.wrt_at += 2.0 * prism * at.transpose();
    bent.wrt_coefficients.set_column(6, &Vector2::new(r2, 0.0));
    bent.wrt_coefficients.set_column(7, &Vector2::new(0.0, r2));
    lens::unfolded(bent)
}
