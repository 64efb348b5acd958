//! `FTHETA`: r = k1 th + k2 th^2 + k3 th^3 + k4 th^4 in px.
//! k1, in px/rad, is its focal length.
//!
//! theta = angle from the axis, r = k1 theta + k2 theta^2 + k3 theta^3 + k4 theta^4
//! px = r x / |(x, y)| + cx, py = r y / |(x, y)| + cy

use std::f64::consts::PI;

use nalgebra::{Matrix2, Matrix2x4, SMatrix, Vector1, Vector2, Vector3};

use super::lens::{self, Bent};
use super::param::{extra, focal, principal_point};
use super::polynomial::is_positive;
use super::{CameraError, CameraModel, FTheta, Linearized, Pair, Param, estimate};

impl CameraModel<6> for FTheta {
    const NAME: &str = "FTHETA";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 6] = [
        principal_point("cx"),
        principal_point("cy"),
        focal("k1").in_unit("px/rad"),
        extra("k2").in_unit("px/rad²"),
        extra("k3").in_unit("px/rad³"),
        extra("k4").in_unit("px/rad⁴"),
    ];
    const EXAMPLES: &[[f64; 6]] = &[
        [320.0, 240.0, 250.0, 5.0, -3.0, 0.4],
        [512.0, 512.0, 420.0, 0.0, -20.0, 2.0],
        [960.0, 604.0, 800.0, -30.0, 10.0, -4.0],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 6], point: &Vector3<f64>) -> Option<Linearized<6>> {
        let [cx, cy, k @ ..] = *params;
        let seen = lens::equidistant(point)?;
        let bent = bent(k, seen.at)?;
        let mut wrt_params = SMatrix::<f64, 2, 6>::zeros();
        wrt_params.fixed_columns_mut::<2>(0).copy_from(&Matrix2::identity());
        wrt_params.fixed_columns_mut::<4>(2).copy_from(&bent.wrt_coefficients);
        let pixel = bent.at + Vector2::new(cx, cy);
        Some(Linearized { pixel, wrt_point: seen.chain(&bent.wrt_at), wrt_params })
    }

    #[inline(always)]
    fn unproject(params: &[f64; 6], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [cx, cy, k @ ..] = *params;
        // In units of k1, so that the search starts near its end.
        let target = (pixel - Vector2::new(cx, cy)) / k[0];
        let in_units =
            |bent: Bent<4>| Bent { at: bent.at / k[0], wrt_at: bent.wrt_at / k[0], ..bent };
        lens::undo_equidistant(lens::unbend(target, |at| bent(k, at).map(in_units))?)
    }

    fn largest_angle(params: &[f64; 6]) -> f64 {
        let [_, _, k @ ..] = *params;
        lens::largest(PI, |theta| grows(k, theta))
    }

    /// All four k, as the radius is linear in them.
    fn estimate_distortion(params: &[f64; 6], pairs: &[Pair]) -> Result<[f64; 6], CameraError> {
        let [cx, cy, ..] = *params;
        let k = estimate::fit(pairs, |ray, pixel| {
            let (r, _) = estimate::radius(ray, &(pixel - Vector2::new(cx, cy)));
            let theta = ray.xy().norm().atan2(ray.z);
            ([1, 2, 3, 4].map(|power| Vector1::new(theta.powi(power))), Vector1::new(r))
        })?;
        let [k1, k2, k3, k4] = k;
        Ok([cx, cy, k1, k2, k3, k4])
    }
}

#[inline(always)]
fn bent(k: [f64; 4], at: Vector2<f64>) -> Option<Bent<4>> {
    let [k1, k2, k3, k4] = k;
    let theta = at.norm();
    if !grows(k, theta) {
        return None;
    }
    let factor = k1 + theta * (k2 + theta * (k3 + theta * k4));
    // On the axis k2 / theta has no limit, but times at at^T it vanishes.
    let slope = if theta > 0.0 { k2 / theta + 2.0 * k3 + 3.0 * k4 * theta } else { 0.0 };
    let [t2, t3] = [theta * theta, theta * theta * theta];
    Some(Bent {
        at: at * factor,
        wrt_at: Matrix2::from_diagonal_element(factor) + slope * at * at.transpose(),
        wrt_coefficients: Matrix2x4::from_columns(&[at, at * theta, at * t2, at * t3]),
    })
}

/// Whether dr/dtheta is positive all the way to theta.
#[inline(always)]
fn grows([k1, k2, k3, k4]: [f64; 4], theta: f64) -> bool {
    is_positive(&[k1, 2.0 * k2, 3.0 * k3, 4.0 * k4], theta)
}
