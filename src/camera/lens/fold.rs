//! Where a lens folds.

use super::grows;

/// The tangent of 90 degrees, as far as a polynomial in it stays within doubles.
pub const ENDLESS: f64 = 1e15;

/// The largest angle from the axis that r (1 + k1 r^2 + ...) sees without folding, r the angle's tangent.
pub fn pinhole_fold<const K: usize>(k: &[f64; K]) -> f64 {
    largest(ENDLESS, |tangent| grows(k, tangent * tangent).is_some()).atan()
}

/// The same, r the angle itself.
pub fn fisheye_fold<const K: usize>(k: &[f64; K]) -> f64 {
    largest(std::f64::consts::PI, |theta| grows(k, theta * theta).is_some())
}

/// The largest number up to `end` that is good, where everything below a good one is.
pub fn largest(end: f64, is_good: impl Fn(f64) -> bool) -> f64 {
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
