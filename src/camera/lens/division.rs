//! The division models.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::{Bent, Seen, over};

/// At its fold the pixel of a division model runs away from the ray without limit; nearer to it than this, in the last
/// thousandth of the radius, a double's ray no longer tells the pixel to 1e-9 px.
const DIVISION_EDGE: f64 = 1e-3;

/// The division models: (x, y) / w, w = (z + sqrt(z^2 - 4 k (x^2 + y^2))) / 2; coefficient k.
#[inline(always)]
pub fn division(point: &Vector3<f64>, k: f64) -> Option<(Seen, Bent<1>)> {
    let [x, y, z]: [f64; 3] = (*point).into();
    let rho2 = x * x + y * y;
    let root = (z * z - 4.0 * k * rho2).sqrt();
    // Behind the camera the sum cancels, and its twin does not.
    let w = if z > 0.0 { 0.5 * (z + root) } else { -2.0 * k * rho2 / (root - z) };
    // A NaN is no root.
    if !(w > 0.0 && root >= DIVISION_EDGE * w) {
        return None;
    }
    let seen = over(point, w, Vector3::new(-2.0 * k * x / root, -2.0 * k * y / root, w / root))?;
    let wrt_coefficients = seen.at * (rho2 / (root * w));
    Some((seen, Bent { at: seen.at, wrt_at: Matrix2::identity(), wrt_coefficients }))
}

/// The ray that `division` sees there; none beyond the radius at which it folds.
#[inline(always)]
pub fn undo_division(at: Vector2<f64>, k: f64) -> Option<Vector3<f64>> {
    let bend = k * at.norm_squared();
    (bend < 1.0 - DIVISION_EDGE).then(|| at.push(1.0 + bend))
}

/// What is linear in k: ([factor of k], right side).
pub fn division_equation(
    ray: &Vector3<f64>,
    at: Vector2<f64>,
) -> ([Vector2<f64>; 1], Vector2<f64>) {
    ([ray.xy() * at.norm_squared()], at * ray.z - ray.xy())
}

/// The largest angle from the axis that `division` sees.
pub fn division_angle(k: f64) -> f64 {
    use std::f64::consts::{FRAC_PI_2, PI};
    if k > 0.0 {
        let bend = 1.0 - DIVISION_EDGE;
        ((bend / k).sqrt() / (1.0 + bend)).atan()
    } else if k < 0.0 {
        PI
    } else {
        FRAC_PI_2
    }
}
