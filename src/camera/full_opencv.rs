//! `FULL_OPENCV`: `OPENCV` with a rational radial term.
//! Numerator and denominator trade freely, so its k are not small.
//!
//! u = x / z, v = y / z, r2 = u^2 + v^2
//! s = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
//! px = fx (s u + 2 p1 u v + p2 (r2 + 2 u^2)) + cx
//! py = fy (s v + 2 p2 u v + p1 (r2 + 2 v^2)) + cy
//!
//! OpenCV, Camera Calibration and 3D Reconstruction.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix2, SMatrix, Vector2, Vector3};

use super::lens::{self, Bent, ENDLESS};
use super::param::{extra, focal, polynomial, principal_point};
use super::polynomial::is_positive;
use super::{CameraModel, FullOpenCv, Linearized, Param};

impl CameraModel<12> for FullOpenCv {
    const NAME: &str = "FULL_OPENCV";
    const COLMAP_ID: Option<i32> = Some(6);
    const WIDEST_ANGLE: f64 = FRAC_PI_2;
    const PARAMS: [Param; 12] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        extra("k1"),
        extra("k2"),
        polynomial("p1"),
        polynomial("p2"),
        extra("k3"),
        extra("k4"),
        extra("k5"),
        extra("k6"),
    ];
    const EXAMPLES: &[[f64; 12]] = &[
        [500.0, 490.0, 320.0, 240.0, -0.3, 0.12, 0.001, -0.002, -0.02, 0.01, -0.01, 0.002],
        [500.0, 490.0, 320.0, 240.0, 12.0, 3.0, 0.0005, -0.0002, 0.1, 12.3, 5.5, 0.4],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 12], point: &Vector3<f64>) -> Option<Linearized<12>> {
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let seen = lens::pinhole(point)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen, bent(bend, seen.at)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 12], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let target = lens::undo_two_focals([fx, fy, cx, cy], pixel);
        Some(lens::unbend(target, |at| bent(bend, at))?.push(1.0))
    }

    fn largest_angle(params: &[f64; 12]) -> f64 {
        let [.., k1, k2, _, _, k3, k4, k5, k6] = *params;
        let is_good = |tangent: f64| grows([k1, k2, k3], [k4, k5, k6], tangent * tangent);
        lens::largest(ENDLESS, is_good).atan()
    }

    fn denominator(params: &[f64; 12], point: &Vector3<f64>) -> Option<f64> {
        let [.., k4, k5, k6] = *params;
        let r2 = lens::pinhole(point)?.at.norm_squared();
        Some(series([k4, k5, k6], r2).0)
    }
}

#[inline(always)]
fn bent([k1, k2, p1, p2, k3, k4, k5, k6]: [f64; 8], at: Vector2<f64>) -> Option<Bent<8>> {
    let r2 = at.norm_squared();
    if !grows([k1, k2, k3], [k4, k5, k6], r2) {
        return None;
    }
    let (over, over_slope) = series([k1, k2, k3], r2);
    let (under, under_slope) = series([k4, k5, k6], r2);
    let factor = over / under;
    // d factor / d r2
    let slope = (over_slope - factor * under_slope) / under;
    let decentring = lens::decentring(at, [p1, p2]);
    let mut wrt_coefficients = SMatrix::<f64, 2, 8>::zeros();
    for (power, [up, down]) in [(r2, [0, 5]), (r2 * r2, [1, 6]), (r2 * r2 * r2, [4, 7])] {
        wrt_coefficients.set_column(up, &(at * (power / under)));
        wrt_coefficients.set_column(down, &(at * (-factor * power / under)));
    }
    wrt_coefficients.fixed_columns_mut::<2>(2).copy_from(&decentring.wrt_coefficients);
    lens::unfolded(Bent {
        at: at * factor + decentring.at,
        wrt_at: Matrix2::from_diagonal_element(factor)
            + 2.0 * slope * at * at.transpose()
            + decentring.wrt_at,
        wrt_coefficients,
    })
}

/// 1 + a s + b s^2 + c s^3 and its derivative.
#[inline(always)]
fn series([a, b, c]: [f64; 3], s: f64) -> (f64, f64) {
    (1.0 + s * (a + s * (b + s * c)), a + s * (2.0 * b + s * 3.0 * c))
}

/// Whether r over(r2) / under(r2) grows all the way to r2: under and (over + 2 r2 over') under - 2 r2 over under' stay positive.
#[inline(always)]
fn grows([a1, a2, a3]: [f64; 3], [b1, b2, b3]: [f64; 3], r2: f64) -> bool {
    let numerator = [
        1.0,
        3.0 * a1 - b1,
        5.0 * a2 + a1 * b1 - 3.0 * b2,
        7.0 * a3 + 3.0 * a2 * b1 - a1 * b2 - 5.0 * b3,
        5.0 * a3 * b1 + a2 * b2 - 3.0 * a1 * b3,
        3.0 * a3 * b2 - a2 * b3,
        a3 * b3,
    ];
    is_positive(&[1.0, b1, b2, b3], r2) && is_positive(&numerator, r2)
}
