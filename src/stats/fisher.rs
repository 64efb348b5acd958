//! The F distribution, in its tails: statrs' own functions lose the digits of small probabilities.

use statrs::function::beta::{checked_beta_reg, checked_ln_beta};

/// Probability that F with these degrees exceeds `f`; none unless `f` is at least 0 and both degrees are above it.
pub fn upper_tail(f: f64, [above, below]: [f64; 2]) -> Option<f64> {
    if f.is_nan() || f < 0.0 {
        return None;
    }
    // I_x(b/2, a/2) at x = b / (b + a f): Abramowitz and Stegun 26.6.2.
    checked_beta_reg(below / 2.0, above / 2.0, below / (below + above * f)).ok()
}

/// Probability that F with these degrees falls below `f`.
pub(super) fn lower_tail(f: f64, [above, below]: [f64; 2]) -> Option<f64> {
    // 1 / F has the degrees exchanged.
    upper_tail(f.recip(), [below, above])
}

/// What F with these degrees exceeds with probability `tail`, between 0 and 1.
pub(super) fn critical(tail: f64, [above, below]: [f64; 2]) -> Option<f64> {
    if !(0.0..=0.5).contains(&tail) {
        return Some(critical_above_median(1.0 - tail, [below, above])?.recip());
    }
    critical_above_median(tail, [above, below])
}

/// Newton on the logarithm of the tail over ln f. Both density and tail are log-concave there, so the steps overshoot once at
/// most and then come down on the root from the right.
fn critical_above_median(tail: f64, [above, below]: [f64; 2]) -> Option<f64> {
    const MOST_STEPS: usize = 60;
    let ln_beta = checked_ln_beta(above / 2.0, below / 2.0).ok()?;
    let mut ln_f = 0.0_f64;
    for _ in 0..MOST_STEPS {
        let f = ln_f.exp();
        let q = upper_tail(f, [above, below])?;
        // f times the density, from Abramowitz and Stegun 26.6.1
        let sum = above * f + below;
        let [x, rest] = [above * f / sum, below / sum];
        let slope = (above / 2.0 * x.ln() + below / 2.0 * rest.ln() - ln_beta).exp() / q;
        let step = (q / tail).ln() / slope;
        ln_f += step;
        if step.abs() <= 1e-14 * ln_f.abs().max(1.0) {
            break;
        }
    }
    Some(ln_f.exp()).filter(|f| f.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(got: Option<f64>, want: f64, what: &str) {
        let is_near = got.is_some_and(|got| (got / want - 1.0).abs() < 1e-10);
        assert!(is_near, "{what}: {got:?}, scipy {want:e}");
    }

    #[test]
    fn tails_and_critical_values_are_scipys() {
        for (degrees, f, upper) in SCIPY_TAILS {
            assert_near(upper_tail(f, degrees), upper, &format!("{degrees:?} at {f}"));
            let [above, below] = degrees;
            assert_near(lower_tail(f.recip(), [below, above]), upper, "the reciprocal");
        }
        for (degrees, tail, f) in SCIPY_CRITICAL {
            assert_near(critical(tail, degrees), f, &format!("{degrees:?} at {tail}"));
        }
    }

    #[test]
    fn with_two_degrees_above_the_tail_is_a_power() {
        // Q(f) = (1 + 2 f / b)^(-b / 2)
        for (f, below) in [(0.3_f64, 3.0_f64), (7.0, 11.0), (200.0, 2.5)] {
            let want = (1.0 + 2.0 * f / below).powf(-below / 2.0);
            assert_near(upper_tail(f, [2.0, below]), want, "closed form");
            assert_near(critical(want, [2.0, below]), f, "and back");
        }
    }

    #[test]
    fn what_is_no_f_has_no_tail() {
        assert_eq!(upper_tail(-1.0, [2.0, 3.0]), None);
        assert_eq!(upper_tail(f64::NAN, [2.0, 3.0]), None);
        assert_eq!(upper_tail(1.0, [0.0, 3.0]), None);
        assert_eq!(upper_tail(f64::INFINITY, [2.0, 3.0]), Some(0.0));
    }

    // scipy.stats.f.sf
    const SCIPY_TAILS: [([f64; 2], f64, f64); 24] = [
        ([1.0, 1.0], 0.9, 0.5167608961656444),
        ([1.0, 1.0], 3.0, 0.33333333333333337),
        ([1.0, 1.0], 25.0, 0.1256659163780024),
        ([2.0, 2.0], 0.9, 0.5263157894736842),
        ([2.0, 2.0], 3.0, 0.25),
        ([2.0, 2.0], 25.0, 0.038461538461538464),
        ([5.0, 5.0], 0.9, 0.5446132206335015),
        ([5.0, 5.0], 3.0, 0.1265849975501613),
        ([5.0, 5.0], 25.0, 0.001511575420492895),
        ([2.0, 30.0], 0.9, 0.4172650607355408),
        ([2.0, 30.0], 3.0, 0.06490547151887446),
        ([2.0, 30.0], 25.0, 4.078204653978901e-07),
        ([9.7, 3.3], 0.9, 0.6040110700789125),
        ([9.7, 3.3], 3.0, 0.18183250022180783),
        ([9.7, 3.3], 25.0, 0.007967589944926986),
        ([40.0, 12.0], 0.9, 0.6217214883623932),
        ([40.0, 12.0], 3.0, 0.022003914516374474),
        ([40.0, 12.0], 25.0, 4.0559406834932984e-07),
        ([999.0, 999.0], 0.98, 0.6252089668436864),
        ([999.0, 999.0], 1.05, 0.22040584705536165),
        ([999.0, 999.0], 1.1, 0.06608867847052884),
        ([9999.0, 5000.0], 0.98, 0.7962697872585198),
        ([9999.0, 5000.0], 1.05, 0.023652725480717913),
        ([9999.0, 5000.0], 1.1, 5.509864134056163e-05),
    ];

    // scipy.stats.f.isf
    const SCIPY_CRITICAL: [([f64; 2], f64, f64); 32] = [
        ([1.0, 1.0], 0.025, 647.7890114778442),
        ([1.0, 1.0], 0.4, 1.894427190999916),
        ([1.0, 1.0], 0.975, 0.0015437125086741337),
        ([1.0, 1.0], 1e-06, 405284734545.376),
        ([2.0, 2.0], 0.025, 38.999999999999964),
        ([2.0, 2.0], 0.4, 1.4999999999999998),
        ([2.0, 2.0], 0.975, 0.025641025641025664),
        ([2.0, 2.0], 1e-06, 999998.9999712444),
        ([5.0, 5.0], 0.025, 7.146381828732832),
        ([5.0, 5.0], 0.4, 1.2692279607322507),
        ([5.0, 5.0], 0.975, 0.13993095022986143),
        ([5.0, 5.0], 1e-06, 492.8811018391836),
        ([2.0, 30.0], 0.025, 4.182060590996112),
        ([2.0, 30.0], 0.4, 0.9448556893430899),
        ([2.0, 30.0], 0.975, 0.02533918639051077),
        ([2.0, 30.0], 1e-06, 22.678296472571468),
        ([9.7, 3.3], 0.025, 12.075046616357207),
        ([9.7, 3.3], 0.4, 1.481426660501006),
        ([9.7, 3.3], 0.975, 0.20973109329297776),
        ([9.7, 3.3], 1e-06, 5979.703020156075),
        ([40.0, 12.0], 0.025, 2.9063463655921393),
        ([40.0, 12.0], 0.4, 1.1749297623518342),
        ([40.0, 12.0], 0.975, 0.4370329512952648),
        ([40.0, 12.0], 1e-06, 21.348549011646696),
        ([999.0, 999.0], 0.025, 1.13211983774704),
        ([999.0, 999.0], 0.4, 1.0161644470633973),
        ([999.0, 999.0], 0.975, 0.8832987168478884),
        ([999.0, 999.0], 1e-06, 1.3517853232837775),
        ([9999.0, 5000.0], 0.025, 1.049390036047607),
        ([9999.0, 5000.0], 0.4, 1.0062946161883561),
        ([9999.0, 5000.0], 0.975, 0.9533057206776806),
        ([9999.0, 5000.0], 1e-06, 1.1244519508235795),
    ];
}
