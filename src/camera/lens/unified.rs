//! The unified models, UCM and EUCM: a sphere, then a pinhole.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::{Bent, Seen, largest, over};

/// The unified models: (x, y) / w, w = alpha d + (1 - alpha) z, d = sqrt(beta (x^2 + y^2) + z^2); coefficients alpha, beta.
/// None where w is not positive, or where the map folds: at alpha z + (1 - alpha) d = 0.
#[inline(always)]
pub fn unified(point: &Vector3<f64>, alpha: f64, beta: f64) -> Option<(Seen, Bent<2>)> {
    let [x, y, z]: [f64; 3] = (*point).into();
    let rho2 = x * x + y * y;
    let [d, w] = unified_denominator(point, alpha, beta);
    if w <= 0.0 || alpha * z + (1.0 - alpha) * d <= 0.0 {
        return None;
    }
    let share = alpha / d;
    let seen =
        over(point, w, Vector3::new(share * beta * x, share * beta * y, share * z + 1.0 - alpha))?;
    let wrt_coefficients =
        Matrix2::from_columns(&[seen.at * ((z - d) / w), seen.at * (-0.5 * share * rho2 / w)]);
    Some((seen, Bent { at: seen.at, wrt_at: Matrix2::identity(), wrt_coefficients }))
}

/// The d and the w of `unified`.
#[inline(always)]
pub fn unified_denominator(point: &Vector3<f64>, alpha: f64, beta: f64) -> [f64; 2] {
    let [x, y, z]: [f64; 3] = (*point).into();
    let d = (beta * (x * x + y * y) + z * z).sqrt();
    [d, alpha * d + (1.0 - alpha) * z]
}

/// The ray that `unified` sees there.
#[inline(always)]
pub fn undo_unified(at: Vector2<f64>, alpha: f64, beta: f64) -> Option<Vector3<f64>> {
    let r2 = at.norm_squared();
    let under = 1.0 - (2.0 * alpha - 1.0) * beta * r2;
    if under < 0.0 {
        return None;
    }
    let z = (1.0 - beta * alpha * alpha * r2) / (alpha * under.sqrt() + 1.0 - alpha);
    Some(at.push(z))
}

/// The largest angle from the axis that `unified` sees.
pub fn unified_angle(alpha: f64, beta: f64) -> f64 {
    largest(std::f64::consts::PI, |angle| {
        unified(&Vector3::new(angle.sin(), 0.0, angle.cos()), alpha, beta).is_some()
    })
}
