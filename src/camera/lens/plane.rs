//! Rays onto a plane of the camera, and back.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

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
        let scale = angle(rho, z) / rho;
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

/// atan2(rho, z) for rho >= 0, inlined, without branches, and the same on every machine; within four roundings.
#[inline(always)]
fn angle(rho: f64, z: f64) -> f64 {
    /// (1 - atan(t) / t) / t^2 in powers of t^2 for |t| < 7/16: FreeBSD's msun, s_atan.c.
    const SERIES: [f64; 11] = [
        3.333_333_333_333_293e-1,
        -1.999_999_999_987_648_3e-1,
        1.428_571_427_250_346_6e-1,
        -1.111_111_040_546_235_6e-1,
        9.090_887_133_436_507e-2,
        -7.691_876_205_044_83e-2,
        6.661_073_137_387_531e-2,
        -5.833_570_133_790_573_5e-2,
        4.976_877_994_615_932_4e-2,
        -3.653_157_274_421_691_6e-2,
        1.628_582_011_536_578_2e-2,
    ];
    const TAN_PI_8: f64 = std::f64::consts::SQRT_2 - 1.0;
    let across = z.abs();
    let (low, high) = (rho.min(across), rho.max(across));
    // atan(q) = pi/4 + atan((q - 1) / (q + 1)), where q is above tan(pi/8). A factor, as a branch would often be mispredicted.
    let turned = if low > TAN_PI_8 * high { 1.0 } else { 0.0 };
    let (over, under) = (low - turned * high, high + turned * low);
    let t = over / under;
    let t2 = t * t;
    // Even and odd terms apart, so that neither sum waits for the other.
    let t4 = t2 * t2;
    let every_other =
        |from: usize| SERIES[from..].iter().step_by(2).rev().fold(0.0, |sum, c| sum * t4 + c);
    let rest = every_other(0) + t2 * every_other(1);
    let octant = turned * FRAC_PI_4 + (t - t * t2 * rest);
    let quadrant = if rho > across { FRAC_PI_2 - octant } else { octant };
    if z < 0.0 { PI - quadrant } else { quadrant }
}

/// The ray that `equidistant` sees there.
#[inline(always)]
pub fn undo_equidistant(at: Vector2<f64>) -> Option<Vector3<f64>> {
    let theta = at.norm();
    (theta < PI).then(|| (at * sinc(theta)).push(theta.cos()))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_is_that_of_atan2_all_round_and_to_the_last_digits() {
        let mut count = 0;
        for index in 0..=100_000 {
            let theta = PI * f64::from(index) / 100_000.0;
            for distance in [1e-30, 0.3, 1e20] {
                let (rho, z) = (distance * theta.sin().abs(), distance * theta.cos());
                let want = rho.atan2(z);
                let error = (angle(rho, z) - want).abs();
                assert!(error <= 4.0 * f64::EPSILON * want, "{theta}: {error:.1e}");
                count += 1;
            }
        }
        assert_eq!(count, 300_003);
    }
}
