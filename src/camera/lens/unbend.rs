//! Unbending the plane: the one Newton's method of all models.

use nalgebra::Vector2;

use super::Bent;

/// The place that is bent to `target`, by Newton's method from the axis side, on which a lens never folds: a step that leaves
/// the valid set or leads away is halved.
#[inline(always)]
pub fn unbend<const K: usize>(
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
