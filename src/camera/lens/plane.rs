//! Rays onto a plane of the camera, and back.

use nalgebra::{Matrix2x3, Vector2, Vector3};

/// A ray's place on a plane of the camera.
#[derive(Clone, Copy)]
pub struct Seen {
    pub at: Vector2<f64>,
    pub wrt_point: Matrix2x3<f64>,
}

/// (x, y) / z, for points before the camera.
#[inline(always)]
pub fn pinhole(point: &Vector3<f64>) -> Option<Seen> {
    if point.z <= 0.0 {
        return None;
    }
    let inverse = 1.0 / point.z;
    let at = point.xy() * inverse;
    let wrt_point = Matrix2x3::new(inverse, 0.0, -at.x * inverse, 0.0, inverse, -at.y * inverse);
    at.sum().is_finite().then_some(Seen { at, wrt_point })
}

/// `pinhole` of a camera that looks along -Z.
#[inline(always)]
pub fn pinhole_behind(point: &Vector3<f64>) -> Option<Seen> {
    let mut seen = pinhole(&Vector3::new(point.x, point.y, -point.z))?;
    seen.wrt_point.column_mut(2).neg_mut();
    Some(seen)
}

/// theta (x, y) / |(x, y)|, theta the angle from the axis, up to but without 180 degrees.
#[inline(always)]
pub fn equidistant(point: &Vector3<f64>) -> Option<Seen> {
    /// Below this tangent of theta the quotient's series is exact to the last bit, and the quotient is not.
    const NEAR_AXIS: f64 = 1e-4;
    let [x, y, z]: [f64; 3] = (*point).into();
    let rho2 = x * x + y * y;
    let rho = rho2.sqrt();
    let norm2 = rho2 + z * z;
    // scale = theta / rho, and its derivative by rho divided by rho
    let (scale, slope) = if rho < NEAR_AXIS * z {
        let t2 = rho2 / (z * z);
        ((1.0 - t2 / 3.0 + t2 * t2 / 5.0) / z, (-2.0 / 3.0 + 0.8 * t2) / (z * z * z))
    } else {
        let scale = rho.atan2(z) / rho;
        (scale, (z / norm2 - scale) / rho2)
    };
    let wrt_z = -1.0 / norm2;
    let wrt_point = Matrix2x3::new(
        scale + slope * x * x,
        slope * x * y,
        x * wrt_z,
        slope * x * y,
        scale + slope * y * y,
        y * wrt_z,
    );
    let at = Vector2::new(scale * x, scale * y);
    (norm2 > 0.0 && at.sum().is_finite()).then_some(Seen { at, wrt_point })
}

/// The ray that `equidistant` sees there.
#[inline(always)]
pub fn undo_equidistant(at: Vector2<f64>) -> Option<Vector3<f64>> {
    let theta = at.norm();
    (theta < std::f64::consts::PI).then(|| (at * sinc(theta)).push(theta.cos()))
}

/// sin(x) / x
#[inline(always)]
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

/// (x, y) / w, for a denominator with this gradient.
#[inline(always)]
pub fn over(point: &Vector3<f64>, w: f64, gradient: Vector3<f64>) -> Option<Seen> {
    let at = point.xy() / w;
    let mut wrt_point = -at * gradient.transpose() / w;
    wrt_point[(0, 0)] += 1.0 / w;
    wrt_point[(1, 1)] += 1.0 / w;
    at.sum().is_finite().then_some(Seen { at, wrt_point })
}
