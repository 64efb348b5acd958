//! How well so few samples determine a standard deviation.

use super::chi_square_quantile;

/// Factors by which to multiply the standard deviation of n normal samples for the ends of its confidence interval:
/// sqrt((n - 1) / q) at the quantiles q of chi-square with n - 1 degrees. None with fewer than two samples.
pub fn std_interval_factors(n: usize, confidence: f64) -> Option<[f64; 2]> {
    if n < 2 {
        return None;
    }
    std_interval_factors_of_degrees((n - 1) as f64, confidence)
}

/// The same for any standard deviation with so many degrees of freedom, which need not be whole.
pub fn std_interval_factors_of_degrees(degrees: f64, confidence: f64) -> Option<[f64; 2]> {
    let tail = (1.0 - confidence) / 2.0;
    let factor = |probability| Some((degrees / chi_square_quantile(probability, degrees)?).sqrt());
    Some([factor(1.0 - tail)?, factor(tail)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_two_degrees_the_quantile_is_an_exponential() {
        // chi-square with 2 degrees: cdf = 1 - exp(-x / 2)
        let [low, high] = std_interval_factors(3, 0.95).unwrap();
        let factor = |tail: f64| (2.0 / (-2.0 * tail.ln())).sqrt();
        assert!((low / factor(0.025) - 1.0).abs() < 1e-13, "{low}");
        assert!((high / factor(0.975) - 1.0).abs() < 1e-13, "{high}");
    }

    #[test]
    fn the_interval_is_scipys_from_2_to_1000_samples() {
        // sqrt((n - 1) / scipy.stats.chi2.ppf([0.975, 0.025], n - 1))
        for (n, want) in SCIPY {
            let found = std_interval_factors(n, 0.95).unwrap();
            for side in 0..2 {
                let relative = (found[side] / want[side] - 1.0).abs();
                assert!(relative < 1e-11, "n = {n}: {found:?}, scipy {want:?}");
            }
        }
        assert_eq!(std_interval_factors(1, 0.95), None);
    }

    const SCIPY: [(usize, [f64; 2]); 5] = [
        (2, [0.4461491849207089, 31.91015934964397]),
        (6, [0.6242080022589825, 2.4526139885482974]),
        (10, [0.6878352067489997, 1.8256101825195739]),
        (100, [0.8780068454038706, 1.161675255294621]),
        (1000, [0.9580123491251626, 1.0458653573974395]),
    ];
}
