//! Unbending the plane: the one Newton's method of all models.

use nalgebra::{Matrix2, Vector2};

use super::bend::{stretch, stretches_more, unchecked_radial};
use super::{Bent, decentring, radial};

/// The place that is bent to `target`, by Newton's method from the axis side, on which a lens never folds: a step that leaves
/// the valid set or leads away is halved.
#[inline(always)]
pub fn unbend<const K: usize>(
    target: Vector2<f64>,
    bend: impl Fn(Vector2<f64>) -> Option<Bent<K>>,
) -> Option<Vector2<f64>> {
    /// Near a fold the steps shrink by half at each round; sixty of them are a double's width.
    const ROUNDS: usize = 200;
    let size = 1.0 + target.norm();
    // The first step is from the axis to the target, but not so far out that high powers take Newton a hundred steps to
    // climb down.
    let (mut at, mut step) = (Vector2::zeros(), target);
    let mut error2 = (8.0 * size).powi(2);
    for _ in 0..ROUNDS {
        // One call of `bend` in all, or the compiler does not inline it and computes what is not needed.
        let bent = bend(at + step).map(|bent| (bent.wrt_at, bent.at - target));
        if let Some((wrt_at, error)) = bent.filter(|(_, error)| error.norm_squared() < error2) {
            (at, error2) = (at + step, error.norm_squared());
            step = -solve(wrt_at, error);
            // Each step squares the error: with half of a double's digits right, one more step makes all right.
            if step.norm_squared() <= f64::EPSILON * at.norm_squared() {
                return Some(at + step);
            }
        } else if step.norm() < f64::EPSILON * size {
            break;
        } else {
            step *= 0.5;
        }
    }
    // What rounding leaves; a larger rest means that no place is bent there.
    (error2.sqrt() <= 64.0 * f64::EPSILON * size).then_some(at)
}

/// `unbend` for `brown` without a branch, in as many steps of Newton's as most lenses need, and whether it surely arrived:
/// where the last step was short, and the lens surely stretches the plane all the way, so that it brings no other place there.
#[inline(always)]
pub fn unbend_brown_at_once<const R: usize>(
    target: Vector2<f64>,
    k: &[f64; R],
    p: [f64; 2],
) -> (Vector2<f64>, bool) {
    // One after another, as a loop within the loop over pixels would not become SIMD.
    let mut near = target;
    near = brown_step(near, target, k, p);
    near = brown_step(near, target, k, p);
    near = brown_step(near, target, k, p);
    near = brown_step(near, target, k, p);
    let at = brown_step(near, target, k, p);
    let is_near = (at - near).norm_squared() <= f64::EPSILON * at.norm_squared();
    (at, is_near && stretches_more(k, p, at.norm_squared()))
}

#[inline(always)]
fn brown_step<const R: usize>(
    at: Vector2<f64>,
    target: Vector2<f64>,
    k: &[f64; R],
    p: [f64; 2],
) -> Vector2<f64> {
    let (radial, decentring) = (unchecked_radial(at, k), decentring(at, p));
    at - solve(radial.wrt_at + decentring.wrt_at, radial.at + decentring.at - target)
}

/// `unbend` for `radial` alone.
#[inline(always)]
pub fn unbend_radial<const K: usize>(target: Vector2<f64>, k: &[f64; K]) -> Option<Vector2<f64>> {
    let (at, is_sure) = unbend_radial_at_once(target, k);
    if is_sure { Some(at) } else { unbend(target, |at| radial(at, k)) }
}

/// The same for `radial` alone, which moves a place along its radius.
#[inline(always)]
pub fn unbend_radial_at_once<const K: usize>(
    target: Vector2<f64>,
    k: &[f64; K],
) -> (Vector2<f64>, bool) {
    let length = target.norm();
    let next = |r: f64| {
        let (factor, slope) = stretch(k, r * r);
        r - (r * factor - length) / (factor + 2.0 * slope * r * r)
    };
    let near = next(next(next(next(length))));
    let r = next(near);
    let is_near = (r - near).abs() <= f64::EPSILON.sqrt() * r;
    (target / stretch(k, r * r).0, is_near && stretches_more(k, [0.0; 2], r * r))
}

/// matrix^-1 vector; not finite where there is none.
#[inline(always)]
fn solve(matrix: Matrix2<f64>, vector: Vector2<f64>) -> Vector2<f64> {
    let [[a, c], [b, d]] = matrix.data.0;
    Vector2::new(d * vector.x - b * vector.y, a * vector.y - c * vector.x) / (a * d - b * c)
}
