//! `RAD_TAN_THIN_PRISM_FISHEYE`: equidistant fisheye with six radial, two tangential and
//! four thin-prism terms (Project Aria's Fisheye624).
//!
//! theta = angle from the axis, (u, v) = theta (x, y) / |(x, y)|, r2 = theta^2
//! (a, b) = (1 + k0 r2 + ... + k5 r2^6) (u, v), q2 = a^2 + b^2
//! px = fx (a + p0 (q2 + 2 a^2) + 2 p1 a b + s0 q2 + s1 q2^2) + cx
//! py = fy (b + p1 (q2 + 2 b^2) + 2 p0 a b + s2 q2 + s3 q2^2) + cy

use nalgebra::{Matrix2, SMatrix, Vector2, Vector3};

use super::lens::{self, Bent};
use super::param::{focal, polynomial, principal_point};
use super::{CameraModel, Linearized, Param, RadTanThinPrismFisheye};

impl CameraModel<16> for RadTanThinPrismFisheye {
    const NAME: &str = "RAD_TAN_THIN_PRISM_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(11);
    const PARAMS: [Param; 16] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        polynomial("k0").known_as("k1"),
        polynomial("k1").known_as("k2"),
        polynomial("k2").known_as("k3"),
        polynomial("k3").known_as("k4"),
        polynomial("k4").known_as("k5"),
        polynomial("k5").known_as("k6"),
        polynomial("p0").known_as("p2"),
        polynomial("p1"),
        polynomial("s0").known_as("sx1"),
        polynomial("s1"),
        polynomial("s2").known_as("sy1"),
        polynomial("s3"),
    ];
    const EXAMPLES: &[[f64; 16]] = &[
        [
            610.0, 612.0, 704.0, 704.0, 0.03, -0.01, 0.004, -0.002, 0.0005, -4e-05, 0.0005,
            -0.0003, 0.0008, -0.0001, -0.0004, 5e-05,
        ],
        [
            402.0, 404.0, 512.0, 512.0, -0.06, 0.01, -0.003, 0.001, -0.0002, 1e-05, 0.0002, 0.0001,
            -0.0005, 3e-05, 0.0006, -2e-05,
        ],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 16], point: &Vector3<f64>) -> Option<Linearized<16>> {
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let seen = lens::equidistant(point)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen, bent(bend, seen.at)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 16], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let target = lens::undo_two_focals([fx, fy, cx, cy], pixel);
        lens::undo_equidistant(lens::unbend(target, |at| bent(bend, at))?)
    }

    fn largest_angle(params: &[f64; 16]) -> f64 {
        let [_, _, _, _, k0, k1, k2, k3, k4, k5, ..] = *params;
        lens::fisheye_fold(&[k0, k1, k2, k3, k4, k5])
    }
}

#[inline(always)]
fn bent(
    [k0, k1, k2, k3, k4, k5, p0, p1, s0, s1, s2, s3]: [f64; 12],
    at: Vector2<f64>,
) -> Option<Bent<12>> {
    let radial = lens::radial(at, &[k0, k1, k2, k3, k4, k5])?;
    let q2 = radial.at.norm_squared();
    // Its p0 is what others call p2.
    let decentring = lens::decentring(radial.at, [p1, p0]);
    let prism = Vector2::new(s0 + s1 * q2, s2 + s3 * q2);
    let prism_slope = Vector2::new(s0 + 2.0 * s1 * q2, s2 + 2.0 * s3 * q2);
    let wrt_radial =
        Matrix2::identity() + decentring.wrt_at + 2.0 * prism_slope * radial.at.transpose();
    let mut wrt_coefficients = SMatrix::<f64, 2, 12>::zeros();
    let wrt_k = wrt_radial * radial.wrt_coefficients;
    wrt_coefficients.fixed_columns_mut::<6>(0).copy_from(&wrt_k);
    wrt_coefficients.set_column(6, &decentring.wrt_coefficients.column(1));
    wrt_coefficients.set_column(7, &decentring.wrt_coefficients.column(0));
    for (column, power) in [(8, q2), (9, q2 * q2)] {
        wrt_coefficients.set_column(column, &Vector2::new(power, 0.0));
        wrt_coefficients.set_column(column + 2, &Vector2::new(0.0, power));
    }
    if wrt_radial.determinant() <= 0.0 || wrt_radial.trace() <= 0.0 {
        return None;
    }
    let wrt_at = wrt_radial * radial.wrt_at;
    lens::unfolded(Bent { at: radial.at + decentring.at + prism * q2, wrt_at, wrt_coefficients })
}
