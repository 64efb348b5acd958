//! The mathematics that lenses share: rays onto a plane, bending the plane, unbending it, plane to pixels.
//!
//! Everything comes with its derivatives, so that a model states its formula once.

use nalgebra::{Matrix2, Matrix2x3, SMatrix, Vector2, Vector3};

use super::polynomial::is_positive;

/// A projection with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearized<const N: usize> {
    /// The pixel.
    pub pixel: Vector2<f64>,
    /// d pixel / d point.
    pub wrt_point: Matrix2x3<f64>,
    /// d pixel / d parameters, in file order.
    pub wrt_params: SMatrix<f64, 2, N>,
}

/// A ray's place on a plane of the camera.
#[derive(Clone, Copy)]
pub(super) struct Seen {
    pub at: Vector2<f64>,
    pub wrt_point: Matrix2x3<f64>,
}

/// A place on the plane after distortion by K coefficients.
#[derive(Clone, Copy)]
pub(super) struct Bent<const K: usize> {
    pub at: Vector2<f64>,
    pub wrt_at: Matrix2<f64>,
    pub wrt_coefficients: SMatrix<f64, 2, K>,
}

/// (x, y) / z, for points before the camera.
#[inline(always)]
pub(super) fn pinhole(point: &Vector3<f64>) -> Option<Seen> {
    if point.z <= 0.0 {
        return None;
    }
    let inverse = 1.0 / point.z;
    let at = point.xy() * inverse;
    let wrt_point = Matrix2x3::new(inverse, 0.0, -at.x * inverse, 0.0, inverse, -at.y * inverse);
    at.iter().all(|value| value.is_finite()).then_some(Seen { at, wrt_point })
}

/// theta (x, y) / |(x, y)|, theta the angle from the axis, up to but without 180 degrees.
#[inline(always)]
pub(super) fn equidistant(point: &Vector3<f64>) -> Option<Seen> {
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
    (norm2 > 0.0 && at.iter().all(|value| value.is_finite())).then_some(Seen { at, wrt_point })
}

/// The ray that `equidistant` sees there.
#[inline(always)]
pub(super) fn undo_equidistant(at: Vector2<f64>) -> Option<Vector3<f64>> {
    let theta = at.norm();
    (theta < std::f64::consts::PI).then(|| (at * sinc(theta)).push(theta.cos()))
}

/// sin(x) / x
#[inline(always)]
pub(super) fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

/// No distortion.
#[inline(always)]
pub(super) fn straight(at: Vector2<f64>) -> Bent<0> {
    Bent { at, wrt_at: Matrix2::identity(), wrt_coefficients: SMatrix::zeros() }
}

/// at (1 + k1 r^2 + k2 r^4 + ...), as far as that grows with r.
#[inline(always)]
pub(super) fn radial<const K: usize>(at: Vector2<f64>, k: &[f64; K]) -> Option<Bent<K>> {
    let r2 = at.norm_squared();
    grows(k, r2)?;
    let mut power = 1.0;
    let (mut factor, mut slope) = (1.0, 0.0);
    let mut wrt_coefficients = SMatrix::<f64, 2, K>::zeros();
    for (index, k) in k.iter().enumerate() {
        slope += (index + 1) as f64 * k * power;
        power *= r2;
        factor += k * power;
        wrt_coefficients.set_column(index, &(at * power));
    }
    let outer = 2.0 * slope * at * at.transpose();
    Some(Bent {
        at: at * factor,
        wrt_at: Matrix2::from_diagonal_element(factor) + outer,
        wrt_coefficients,
    })
}

/// Whether d/dr r (1 + k1 r^2 + k2 r^4 + ...) is positive all the way to r.
#[inline(always)]
pub(super) fn grows<const K: usize>(k: &[f64; K], r2: f64) -> Option<()> {
    // The constant term 1 apart, as K + 1 cannot be written: 1 + s q(s) > 0.
    let positive = match *k.as_slice() {
        [] => true,
        [k1] => is_positive(&[1.0, 3.0 * k1], r2),
        [k1, k2] => is_positive(&[1.0, 3.0 * k1, 5.0 * k2], r2),
        [k1, k2, k3] => is_positive(&[1.0, 3.0 * k1, 5.0 * k2, 7.0 * k3], r2),
        [k1, k2, k3, k4] => is_positive(&[1.0, 3.0 * k1, 5.0 * k2, 7.0 * k3, 9.0 * k4], r2),
        [k1, k2, k3, k4, k5, k6] => {
            is_positive(&[1.0, 3.0 * k1, 5.0 * k2, 7.0 * k3, 9.0 * k4, 11.0 * k5, 13.0 * k6], r2)
        }
        _ => false,
    };
    positive.then_some(())
}

/// Adds Brown's decentring to what is bent already: by p1, p2, with 2 p1 u v + p2 (r^2 + 2 u^2) in u.
/// Gives d/d(p1, p2) too.
#[inline(always)]
pub(super) fn decentring(at: Vector2<f64>, [p1, p2]: [f64; 2]) -> Bent<2> {
    let [u, v]: [f64; 2] = at.into();
    let (uu, uv, vv) = (u * u, u * v, v * v);
    let wrt_coefficients =
        SMatrix::<f64, 2, 2>::new(2.0 * uv, 3.0 * uu + vv, uu + 3.0 * vv, 2.0 * uv);
    let cross = 2.0 * (p1 * u + p2 * v);
    Bent {
        at: wrt_coefficients * Vector2::new(p1, p2),
        wrt_at: Matrix2::new(
            2.0 * p1 * v + 6.0 * p2 * u,
            cross,
            cross,
            6.0 * p1 * v + 2.0 * p2 * u,
        ),
        wrt_coefficients,
    }
}

/// Radial distortion and decentring; the columns say which of the K coefficients each of k and p is. None where the map folds.
#[inline(always)]
pub(super) fn brown<const R: usize, const K: usize>(
    at: Vector2<f64>,
    (k, k_columns): (&[f64; R], [usize; R]),
    (p, p_columns): ([f64; 2], [usize; 2]),
) -> Option<Bent<K>> {
    let radial = radial(at, k)?;
    let decentring = decentring(at, p);
    let mut wrt_coefficients = SMatrix::<f64, 2, K>::zeros();
    for (from, to) in k_columns.into_iter().enumerate() {
        wrt_coefficients.set_column(to, &radial.wrt_coefficients.column(from));
    }
    for (from, to) in p_columns.into_iter().enumerate() {
        wrt_coefficients.set_column(to, &decentring.wrt_coefficients.column(from));
    }
    let wrt_at = radial.wrt_at + decentring.wrt_at;
    unfolded(Bent { at: radial.at + decentring.at, wrt_at, wrt_coefficients })
}

/// None where the map turns the plane over.
#[inline(always)]
pub(super) fn unfolded<const K: usize>(bent: Bent<K>) -> Option<Bent<K>> {
    (bent.wrt_at.determinant() > 0.0).then_some(bent)
}

/// The place that is bent to `target`, by Newton's method from the axis side, on which a lens never folds: a step that leaves
/// the valid set or leads away is halved.
#[inline(always)]
pub(super) fn unbend<const K: usize>(
    target: Vector2<f64>,
    bend: impl Fn(Vector2<f64>) -> Option<Bent<K>>,
) -> Option<Vector2<f64>> {
    /// Near a fold the steps shrink by half at each round; sixty of them are a double's width.
    const ROUNDS: usize = 100;
    let size = 1.0 + target.norm();
    let mut at = target;
    // Not beyond the valid set, nor so far out that high powers take Newton a hundred steps to climb down.
    let is_near = |bent: &Bent<K>| bent.at.norm() <= 8.0 * size;
    let mut bent = loop {
        match bend(at).filter(is_near) {
            Some(bent) => break bent,
            None if at.norm() < f64::EPSILON * size => return None,
            None => at *= 0.5,
        }
    };
    let mut error = bent.at - target;
    for _ in 0..ROUNDS {
        let step = bent.wrt_at.try_inverse()? * error;
        if step.norm_squared() <= (4.0 * f64::EPSILON).powi(2) * at.norm_squared() {
            at -= step;
            break;
        }
        let (next, next_bent, next_error) = nearer(at, step, error, target, &bend)?;
        let is_settled = next_error.norm_squared() >= error.norm_squared();
        (at, bent, error) = (next, next_bent, next_error);
        if is_settled {
            break;
        }
    }
    // What rounding leaves; a larger rest means that no place is bent there.
    (error.norm() <= 64.0 * f64::EPSILON * size).then_some(at)
}

type Nearer<const K: usize> = (Vector2<f64>, Bent<K>, Vector2<f64>);

/// The end of the step, or of the first of its halves at which the error is smaller; itself when it is as small as it gets.
#[inline(always)]
fn nearer<const K: usize>(
    at: Vector2<f64>,
    step: Vector2<f64>,
    error: Vector2<f64>,
    target: Vector2<f64>,
    bend: &impl Fn(Vector2<f64>) -> Option<Bent<K>>,
) -> Option<Nearer<K>> {
    let mut share = 1.0;
    for _ in 0..60 {
        let next = at - step * share;
        if let Some(bent) = bend(next) {
            let next_error = bent.at - target;
            if next_error.norm_squared() < error.norm_squared() {
                return Some((next, bent, next_error));
            }
        }
        share *= 0.5;
    }
    Some((at, bend(at)?, error))
}

/// px = fx u + cx, py = fy v + cy: the first four parameters are fx, fy, cx, cy, the others the coefficients of the bend.
#[inline(always)]
pub(super) fn two_focals<const K: usize, const N: usize>(
    [fx, fy, cx, cy]: [f64; 4],
    seen: Seen,
    bent: Bent<K>,
) -> Linearized<N> {
    let [x, y]: [f64; 2] = bent.at.into();
    let scale = |column: Vector2<f64>| Vector2::new(fx * column.x, fy * column.y);
    let mut wrt_params = SMatrix::<f64, 2, N>::zeros();
    wrt_params.set_column(0, &Vector2::new(x, 0.0));
    wrt_params.set_column(1, &Vector2::new(0.0, y));
    wrt_params.set_column(2, &Vector2::x());
    wrt_params.set_column(3, &Vector2::y());
    for column in 0..K {
        wrt_params.set_column(4 + column, &scale(bent.wrt_coefficients.column(column).into()));
    }
    Linearized {
        pixel: Vector2::new(fx * x + cx, fy * y + cy),
        wrt_point: Matrix2::new(fx, 0.0, 0.0, fy) * bent.wrt_at * seen.wrt_point,
        wrt_params,
    }
}

/// The same with one focal length: the first three parameters are f, cx, cy.
#[inline(always)]
pub(super) fn one_focal<const K: usize, const N: usize>(
    [f, cx, cy]: [f64; 3],
    seen: Seen,
    bent: Bent<K>,
) -> Linearized<N> {
    let mut wrt_params = SMatrix::<f64, 2, N>::zeros();
    wrt_params.set_column(0, &bent.at);
    wrt_params.set_column(1, &Vector2::x());
    wrt_params.set_column(2, &Vector2::y());
    for column in 0..K {
        wrt_params.set_column(3 + column, &(bent.wrt_coefficients.column(column) * f));
    }
    Linearized {
        pixel: bent.at * f + Vector2::new(cx, cy),
        wrt_point: bent.wrt_at * seen.wrt_point * f,
        wrt_params,
    }
}

/// From pixels back to the plane.
#[inline(always)]
pub(super) fn undo_two_focals([fx, fy, cx, cy]: [f64; 4], pixel: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new((pixel.x - cx) / fx, (pixel.y - cy) / fy)
}

/// From pixels back to the plane, with one focal length.
#[inline(always)]
pub(super) fn undo_one_focal([f, cx, cy]: [f64; 3], pixel: &Vector2<f64>) -> Vector2<f64> {
    undo_two_focals([f, f, cx, cy], pixel)
}

/// The tangent of 90 degrees, as far as a polynomial in it stays within doubles.
pub(super) const ENDLESS: f64 = 1e15;

/// The largest angle from the axis that r (1 + k1 r^2 + ...) sees without folding, r the angle's tangent.
pub(super) fn pinhole_fold<const K: usize>(k: &[f64; K]) -> f64 {
    largest(ENDLESS, |tangent| grows(k, tangent * tangent).is_some()).atan()
}

/// The same, r the angle itself.
pub(super) fn fisheye_fold<const K: usize>(k: &[f64; K]) -> f64 {
    largest(std::f64::consts::PI, |theta| grows(k, theta * theta).is_some())
}

/// The largest number up to `end` that is good, where everything below a good one is.
pub(super) fn largest(end: f64, is_good: impl Fn(f64) -> bool) -> f64 {
    if is_good(end) {
        return end;
    }
    let (mut low, mut high) = (0.0, end);
    loop {
        // On a wide interval the geometric middle is nearer in digits.
        let middle = if low > 0.0 { (low * high).sqrt() } else { 0.5 * high };
        if middle <= low || middle >= high {
            return low;
        }
        if is_good(middle) { low = middle } else { high = middle }
    }
}

/// (x, y) / w, for a denominator with this gradient.
#[inline(always)]
pub(super) fn over(point: &Vector3<f64>, w: f64, gradient: Vector3<f64>) -> Option<Seen> {
    let at = point.xy() / w;
    let mut wrt_point = -at * gradient.transpose() / w;
    wrt_point[(0, 0)] += 1.0 / w;
    wrt_point[(1, 1)] += 1.0 / w;
    at.iter().all(|value| value.is_finite()).then_some(Seen { at, wrt_point })
}

/// The unified models: (x, y) / w, w = alpha d + (1 - alpha) z, d = sqrt(beta (x^2 + y^2) + z^2); coefficients alpha, beta.
/// None where w is not positive, or where the map folds: at alpha z + (1 - alpha) d = 0.
#[inline(always)]
pub(super) fn unified(point: &Vector3<f64>, alpha: f64, beta: f64) -> Option<(Seen, Bent<2>)> {
    let [x, y, z]: [f64; 3] = (*point).into();
    let rho2 = x * x + y * y;
    let d = (beta * rho2 + z * z).sqrt();
    let w = alpha * d + (1.0 - alpha) * z;
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

/// The ray that `unified` sees there.
#[inline(always)]
pub(super) fn undo_unified(at: Vector2<f64>, alpha: f64, beta: f64) -> Option<Vector3<f64>> {
    let r2 = at.norm_squared();
    let under = 1.0 - (2.0 * alpha - 1.0) * beta * r2;
    if under < 0.0 {
        return None;
    }
    let z = (1.0 - beta * alpha * alpha * r2) / (alpha * under.sqrt() + 1.0 - alpha);
    Some(at.push(z))
}

/// The largest angle from the axis that `unified` sees.
pub(super) fn unified_angle(alpha: f64, beta: f64) -> f64 {
    largest(std::f64::consts::PI, |angle| {
        unified(&Vector3::new(angle.sin(), 0.0, angle.cos()), alpha, beta).is_some()
    })
}

/// At its fold the pixel of a division model runs away from the ray without limit; nearer to it than this, in the last
/// thousandth of the radius, a double's ray no longer tells the pixel to 1e-9 px.
const DIVISION_EDGE: f64 = 1e-3;

/// The division models: (x, y) / w, w = (z + sqrt(z^2 - 4 k (x^2 + y^2))) / 2; coefficient k.
#[inline(always)]
pub(super) fn division(point: &Vector3<f64>, k: f64) -> Option<(Seen, Bent<1>)> {
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
pub(super) fn undo_division(at: Vector2<f64>, k: f64) -> Option<Vector3<f64>> {
    let bend = k * at.norm_squared();
    (bend < 1.0 - DIVISION_EDGE).then(|| at.push(1.0 + bend))
}

/// The largest angle from the axis that `division` sees.
pub(super) fn division_angle(k: f64) -> f64 {
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

/// `pinhole` of a camera that looks along -Z.
#[inline(always)]
pub(super) fn pinhole_behind(point: &Vector3<f64>) -> Option<Seen> {
    let mut seen = pinhole(&Vector3::new(point.x, point.y, -point.z))?;
    seen.wrt_point.column_mut(2).neg_mut();
    Some(seen)
}
