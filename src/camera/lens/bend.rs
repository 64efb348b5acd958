//! Bending the plane: Brown's distortion, radial and decentring.

use nalgebra::{Matrix2, SMatrix, Vector2};

use super::super::polynomial::{is_positive, lower_bound};

/// A place on the plane after distortion by K coefficients.
#[derive(Clone, Copy)]
pub struct Bent<const K: usize> {
    pub at: Vector2<f64>,
    pub wrt_at: Matrix2<f64>,
    pub wrt_coefficients: SMatrix<f64, 2, K>,
}

/// No distortion.
#[inline(always)]
pub fn straight(at: Vector2<f64>) -> Bent<0> {
    Bent { at, wrt_at: Matrix2::identity(), wrt_coefficients: SMatrix::zeros() }
}

/// at (1 + k1 r^2 + k2 r^4 + ...), as far as that grows with r.
#[inline(always)]
pub fn radial<const K: usize>(at: Vector2<f64>, k: &[f64; K]) -> Option<Bent<K>> {
    grows(k, at.norm_squared())?;
    Some(unchecked_radial(at, k))
}

/// `radial` without a branch, and whether it surely grows.
#[inline(always)]
pub fn radial_at_once<const K: usize>(at: Vector2<f64>, k: &[f64; K]) -> (Bent<K>, bool) {
    (unchecked_radial(at, k), stretches_more(k, [0.0; 2], at.norm_squared()))
}

#[inline(always)]
pub(super) fn unchecked_radial<const K: usize>(at: Vector2<f64>, k: &[f64; K]) -> Bent<K> {
    let r2 = at.norm_squared();
    let (factor, slope) = stretch(k, r2);
    let mut power = 1.0;
    let mut wrt_coefficients = SMatrix::<f64, 2, K>::zeros();
    for index in 0..K {
        power *= r2;
        wrt_coefficients.set_column(index, &(at * power));
    }
    let outer = 2.0 * slope * at * at.transpose();
    Bent {
        at: at * factor,
        wrt_at: Matrix2::from_diagonal_element(factor) + outer,
        wrt_coefficients,
    }
}

/// 1 + k1 r^2 + k2 r^4 + ..., and its derivative by r^2.
#[inline(always)]
pub(super) fn stretch<const K: usize>(k: &[f64; K], r2: f64) -> (f64, f64) {
    let (mut factor, mut slope, mut power) = (1.0, 0.0, 1.0);
    for (index, k) in k.iter().enumerate() {
        slope += (index + 1) as f64 * k * power;
        power *= r2;
        factor += k * power;
    }
    (factor, slope)
}

/// Whether d/dr r (1 + k1 r^2 + k2 r^4 + ...) is positive all the way to r.
#[inline(always)]
pub fn grows<const K: usize>(k: &[f64; K], r2: f64) -> Option<()> {
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
pub fn decentring(at: Vector2<f64>, [p1, p2]: [f64; 2]) -> Bent<2> {
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
pub fn brown<const R: usize, const K: usize>(
    at: Vector2<f64>,
    (k, k_columns): (&[f64; R], [usize; R]),
    p: ([f64; 2], [usize; 2]),
) -> Option<Bent<K>> {
    let (bent, surely_unfolds) = brown_at_once(at, (k, k_columns), p);
    if surely_unfolds {
        return Some(bent);
    }
    grows(k, at.norm_squared())?;
    unfolded(bent)
}

/// `brown` without a branch, and whether it surely does not fold.
#[inline(always)]
pub fn brown_at_once<const R: usize, const K: usize>(
    at: Vector2<f64>,
    (k, k_columns): (&[f64; R], [usize; R]),
    (p, p_columns): ([f64; 2], [usize; 2]),
) -> (Bent<K>, bool) {
    let radial = unchecked_radial(at, k);
    let decentring = decentring(at, p);
    let mut wrt_coefficients = SMatrix::<f64, 2, K>::zeros();
    for (from, to) in k_columns.into_iter().enumerate() {
        wrt_coefficients.set_column(to, &radial.wrt_coefficients.column(from));
    }
    for (from, to) in p_columns.into_iter().enumerate() {
        wrt_coefficients.set_column(to, &decentring.wrt_coefficients.column(from));
    }
    let wrt_at = radial.wrt_at + decentring.wrt_at;
    let bent = Bent { at: radial.at + decentring.at, wrt_at, wrt_coefficients };
    (bent, stretches_more(k, p, at.norm_squared()))
}

/// Whether the radial part surely stretches the plane more than decentring squeezes it, in every direction and all the way
/// to r: the one by the least of d/dr r (1 + k1 r^2 + ...), the other by 6 (|p1| + |p2|) r at the most, and 2 r <= 1 + r^2.
/// True of most lenses over most of their image, and much cheaper than the exact tests.
#[inline(always)]
pub(super) fn stretches_more<const R: usize>(k: &[f64; R], [p1, p2]: [f64; 2], r2: f64) -> bool {
    let growth: [f64; R] = std::array::from_fn(|index| (2 * index + 3) as f64 * k[index]);
    lower_bound(1.0, &growth, r2) > 3.0 * (p1.abs() + p2.abs()) * (1.0 + r2)
}

/// None where the map turns the plane over, once or twice.
#[inline(always)]
pub fn unfolded<const K: usize>(bent: Bent<K>) -> Option<Bent<K>> {
    (bent.wrt_at.determinant() > 0.0 && bent.wrt_at.trace() > 0.0).then_some(bent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheap_proof_that_a_lens_unfolds_never_contradicts_the_exact_tests() {
        let (mut proved, mut folded) = (0, 0);
        for index in 0..200_000 {
            // Multiples of the roots of primes, all over strong and mild lenses alike.
            let at = |prime: f64| 2.0 * (f64::from(index) * prime.sqrt()).fract() - 1.0;
            let (k, p) = ([at(2.0), at(3.0)], [0.2 * at(5.0), 0.2 * at(7.0)]);
            let place = Vector2::new(at(11.0), at(13.0));
            let r2 = place.norm_squared();
            let wrt_at = unchecked_radial(place, &k).wrt_at + decentring(place, p).wrt_at;
            let unfolds = grows(&k, r2).is_some() && wrt_at.determinant() > 0.0;
            let is_proved = stretches_more(&k, p, r2);
            assert!(unfolds || !is_proved, "{k:?} {p:?} at {place:?}");
            proved += u32::from(is_proved);
            folded += u32::from(!unfolds);
        }
        assert!(proved > 20_000 && folded > 20_000, "{proved} {folded}");
    }
}
