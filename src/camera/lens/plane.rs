//! Rays onto a plane of the camera, and back.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};

use super::angle::{angle, sine_and_cosine};

/// A ray's place on a plane of the camera. Its derivative by x and y is stretch I + slant.0 slant.1^T.
#[derive(Clone, Copy)]
pub struct Seen {
    pub at: Vector2<f64>,
    pub stretch: f64,
    /// None where the plane is that of a pinhole, so that no work is done on zeros.
    pub slant: Option<[Vector2<f64>; 2]>,
    pub wrt_z: Vector2<f64>,
}

impl Seen {
    /// d/d point of what has the derivative `outer` by the place.
    #[inline(always)]
    pub fn chain(&self, outer: &Matrix2<f64>) -> Matrix2x3<f64> {
        let mut wrt_xy = outer * self.stretch;
        if let Some([column, row]) = self.slant {
            wrt_xy += (outer * column) * row.transpose();
        }
        let [[a, c], [b, d]] = wrt_xy.data.0;
        let [e, f]: [f64; 2] = (outer * self.wrt_z).into();
        Matrix2x3::new(a, b, e, c, d, f)
    }
}

/// (x, y) / z, for points before the camera.
#[inline(always)]
pub fn pinhole(point: &Vector3<f64>) -> Option<Seen> {
    let (seen, sees) = pinhole_at_once(point);
    sees.then_some(seen)
}

/// `pinhole` without a branch, and whether it sees the point.
#[inline(always)]
pub fn pinhole_at_once(point: &Vector3<f64>) -> (Seen, bool) {
    let stretch = 1.0 / point.z;
    let at = point.xy() * stretch;
    let seen = Seen { at, stretch, slant: None, wrt_z: at * -stretch };
    (seen, point.z > 0.0 && at.sum().abs() < f64::INFINITY)
}

/// `pinhole` of a camera that looks along -Z.
#[inline(always)]
pub fn pinhole_behind(point: &Vector3<f64>) -> Option<Seen> {
    let seen = pinhole(&Vector3::new(point.x, point.y, -point.z))?;
    Some(Seen { wrt_z: -seen.wrt_z, ..seen })
}

/// theta (x, y) / |(x, y)|, theta the angle from the axis, up to but without 180 degrees.
#[inline(always)]
pub fn equidistant(point: &Vector3<f64>) -> Option<Seen> {
    let (mut seen, mut sees) = equidistant_at_once(point);
    let [x, y, z]: [f64; 3] = (*point).into();
    let rho2 = x * x + y * y;
    if !sees && z > 0.0 && rho2 < z * z {
        // The series of theta / rho and of its derivative.
        let t2 = rho2 / (z * z);
        seen.stretch = (1.0 - t2 / 3.0 + t2 * t2 / 5.0) / z;
        seen.at = point.xy() * seen.stretch;
        seen.slant = Some([point.xy() * ((-2.0 / 3.0 + 0.8 * t2) / (z * z * z)), point.xy()]);
        sees = seen.at.sum().is_finite() && seen.wrt_z.sum().is_finite();
    }
    sees.then_some(seen)
}

/// Below a tangent or an angle of this a quotient such as theta / rho loses digits, and its series does not.
const NEAR_AXIS: f64 = 1e-4;

/// `equidistant` without a branch, and whether it sees the point far enough from the axis.
#[inline(always)]
pub fn equidistant_at_once(point: &Vector3<f64>) -> (Seen, bool) {
    let (across, z) = (point.xy(), point.z);
    let rho2 = across.norm_squared();
    let rho = rho2.sqrt();
    let per_norm2 = 1.0 / (rho2 + z * z);
    let per_rho = 1.0 / rho;
    // theta / rho, and its derivative by rho divided by rho
    let stretch = angle(rho, z) * per_rho;
    let slope = (z * per_norm2 - stretch) * (per_rho * per_rho);
    let at = across * stretch;
    let seen =
        Seen { at, stretch, slant: Some([across * slope, across]), wrt_z: across * -per_norm2 };
    (seen, rho >= NEAR_AXIS * z && per_norm2 > 0.0 && at.sum().abs() < f64::INFINITY)
}

/// The ray that `equidistant` sees there.
#[inline(always)]
pub fn undo_equidistant(at: Vector2<f64>) -> Option<Vector3<f64>> {
    let (ray, sees) = undo_equidistant_at_once(at);
    if sees {
        return Some(ray);
    }
    let theta2 = at.norm_squared();
    (theta2 < 2.0 * NEAR_AXIS * NEAR_AXIS)
        .then(|| (at * (1.0 - theta2 / 6.0)).push(1.0 - 0.5 * theta2))
}

/// `undo_equidistant` without a branch, and whether something is seen there, far enough from the axis.
#[inline(always)]
pub fn undo_equidistant_at_once(at: Vector2<f64>) -> (Vector3<f64>, bool) {
    let theta = at.norm();
    let [sine, cosine] = sine_and_cosine(theta);
    ((at * (sine / theta)).push(cosine), (NEAR_AXIS..PI).contains(&theta))
}

/// (x, y) / w, for a denominator with this gradient.
#[inline(always)]
pub fn over(point: &Vector3<f64>, w: f64, gradient: Vector3<f64>) -> Option<Seen> {
    let (seen, sees) = over_at_once(point, w, gradient);
    sees.then_some(seen)
}

/// `over` without a branch, and whether it is finite.
#[inline(always)]
pub fn over_at_once(point: &Vector3<f64>, w: f64, gradient: Vector3<f64>) -> (Seen, bool) {
    let stretch = 1.0 / w;
    let at = point.xy() * stretch;
    let along = at * -stretch;
    let seen = Seen { at, stretch, slant: Some([along, gradient.xy()]), wrt_z: along * gradient.z };
    (seen, at.sum().abs() < f64::INFINITY)
}
