//! Unbending the plane: the one Newton's method of all models.

use nalgebra::{Matrix2, Vector2};

use super::{Bent, radial};

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

/// `unbend` for `radial` alone.
#[inline(always)]
pub fn unbend_radial<const K: usize>(target: Vector2<f64>, k: &[f64; K]) -> Option<Vector2<f64>> {
    unbend(target, |at| radial(at, k))
}

/// matrix^-1 vector; not finite where there is none.
#[inline(always)]
fn solve(matrix: Matrix2<f64>, vector: Vector2<f64>) -> Vector2<f64> {
    let [[a, c], [b, d]] = matrix.data.0;
    Vector2::new(d * vector.x - b * vector.y, a * vector.y - c * vector.x) / (a * d - b * c)
}
