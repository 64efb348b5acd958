//! Where a polynomial stays positive: the test of every lens whose map must not fold.

/// Whether c0 + c1 s + c2 s^2 + ... is positive on the whole of [0, end].
#[inline(always)]
pub(super) fn is_positive<const D: usize>(coefficients: &[f64; D], end: f64) -> bool {
    lower_bound(coefficients[0], &coefficients[1..], end) > 0.0
        || is_positive_by_bernstein(coefficients, end)
}

/// A number that c0 + c1 s + c2 s^2 + ... is nowhere below on [0, end], from c0 and the others: the least value of its first
/// three terms, less what the further ones can take away. For most lenses it is positive. NaN stays NaN.
#[inline(always)]
pub(super) fn lower_bound(constant: f64, others: &[f64], end: f64) -> f64 {
    let if_negative = |value: f64| 0.5 * (value - value.abs());
    let further = others.iter().skip(2).rev().fold(0.0, |sum, c| (sum + if_negative(*c)) * end);
    let parabola = match *others {
        [] => 0.0,
        [linear] => linear * end,
        [linear, square, ..] => {
            let vertex = (-0.5 * linear / square).max(0.0);
            let lowest_at = if square > 0.0 { vertex.min(end) } else { end };
            lowest_at * (linear + lowest_at * square)
        }
    };
    constant + if_negative(parabola) + further * (end * end)
}

/// A polynomial lies between the least and the greatest of its Bernstein coefficients (Farouki, The Bernstein polynomial
/// basis, 2012): all positive is a proof, and for real lenses the first one.
#[inline(always)]
fn is_positive_by_bernstein<const D: usize>(coefficients: &[f64; D], end: f64) -> bool {
    let mut bernstein = [0.0; D];
    let mut power = 1.0;
    let mut binomial = 1.0;
    for index in 0..D {
        bernstein[index] = coefficients[index] / binomial * power;
        power *= end;
        binomial *= (D - 1 - index) as f64 / (index + 1) as f64;
    }
    for round in 1..D {
        for index in (round..D).rev() {
            bernstein[index] += bernstein[index - 1];
        }
    }
    if bernstein.iter().all(|value| *value > 0.0) {
        return true;
    }
    let ends_are_positive = bernstein[0] > 0.0 && bernstein[D - 1] > 0.0;
    ends_are_positive && is_positive_in_halves(&bernstein, 0)
}

/// The same, by de Casteljau's subdivision.
#[cold]
fn is_positive_in_halves<const D: usize>(bernstein: &[f64; D], depth: u32) -> bool {
    /// An interval halved so often is narrower than a double can tell: a touch of zero.
    const DEEPEST: u32 = 52;
    let (mut left, mut right) = ([0.0; D], *bernstein);
    for (round, left) in left.iter_mut().enumerate() {
        *left = right[0];
        for index in 0..D - 1 - round {
            right[index] = 0.5 * (right[index] + right[index + 1]);
        }
    }
    // What is left in `right` are the coefficients of the right half, first to last.
    [left, right].iter().all(|half| {
        let ends_are_positive = half[0] > 0.0 && half[D - 1] > 0.0;
        let all_are_positive = half.iter().all(|value| *value > 0.0);
        ends_are_positive
            && (all_are_positive || (depth < DEEPEST && is_positive_in_halves(half, depth + 1)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dip_below_zero_between_positive_ends_is_found() {
        // (s - 1)(s - 2) = 2 - 3 s + s^2
        let dip = [2.0, -3.0, 1.0];
        assert!(is_positive(&dip, 0.99) && !is_positive(&dip, 1.5) && !is_positive(&dip, 3.0));
        // 1.0001 - 2 s + s^2 has its least value 1e-4 at 1
        assert!(is_positive(&[1.0001, -2.0, 1.0], 5.0));
        assert!(!is_positive(&[0.9999, -2.0, 1.0], 5.0));
    }

    #[test]
    fn the_first_of_many_roots_ends_the_interval() {
        // (1 - s)(1 - s / 2)(1 - s / 3)(1 - s / 4) expanded
        let c = [1.0, -25.0 / 12.0, 35.0 / 24.0, -5.0 / 12.0, 1.0 / 24.0];
        for (end, want) in [(0.999, true), (1.001, false), (2.5, false), (10.0, false)] {
            assert_eq!(is_positive(&c, end), want, "{end}");
        }
    }
}
