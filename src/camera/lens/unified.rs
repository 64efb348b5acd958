//! The unified models, UCM and EUCM: a sphere, then a pinhole.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::{Bent, Seen, largest, over_at_once};

/// The unified models: (x, y) / w, w = alpha d + (1 - alpha) z, d = sqrt(beta (x^2 + y^2) + z^2); coefficients alpha, beta.
/// Says too whether it sees: not where w is not positive, nor where the map folds, at alpha z + (1 - alpha) d = 0.
#[inline(always)]
pub fn unified(point: &Vector3<f64>, alpha: f64, beta: f64) -> (Seen, Bent<2>, bool) {
    let [x, y, z]: [f64; 3] = (*point).into();
    let rho2 = x * x + y * y;
    let [d, w] = unified_denominator(point, alpha, beta);
    let share = alpha / d;
    let gradient = Vector3::new(share * beta * x, share * beta * y, share * z + 1.0 - alpha);
    let (seen, is_finite) = over_at_once(point, w, gradient);
    let sees = w > 0.0 && alpha * z + (1.0 - alpha) * d > 0.0 && is_finite;
    let wrt_coefficients =
        Matrix2::from_columns(&[seen.at * ((z - d) / w), seen.at * (-0.5 * share * rho2 / w)]);
    (seen, Bent { at: seen.at, wrt_at: Matrix2::identity(), wrt_coefficients }, sees)
}

/// The d and the w of `unified`.
#[inline(always)]
pub fn unified_denominator(point: &Vector3<f64>, alpha: f64, beta: f64) -> [f64; 2] {
    let [x, y, z]: [f64; 3] = (*point).into();
    let d = (beta * (x * x + y * y) + z * z).sqrt();
    [d, alpha * d + (1.0 - alpha) * z]
}

/// The ray that `unified` sees there, and whether it sees.
#[inline(always)]
pub fn undo_unified(at: Vector2<f64>, alpha: f64, beta: f64) -> (Vector3<f64>, bool) {
    let r2 = at.norm_squared();
    let under = 1.0 - (2.0 * alpha - 1.0) * beta * r2;
    let z = (1.0 - beta * alpha * alpha * r2) / (alpha * under.sqrt() + 1.0 - alpha);
    (at.push(z), under >= 0.0)
}

/// The largest angle from the axis that `unified` sees.
pub fn unified_angle(alpha: f64, beta: f64) -> f64 {
    largest(std::f64::consts::PI, |angle| {
        unified(&Vector3::new(angle.sin(), 0.0, angle.cos()), alpha, beta).2
    })
}
