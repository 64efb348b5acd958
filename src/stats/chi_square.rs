//! The chi-square distribution: its upper tail and its quantiles.

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF};

/// Probability that chi-square with so many degrees exceeds `statistic`; none unless both are above zero and finite.
pub fn chi_square_tail(statistic: f64, degrees: f64) -> Option<f64> {
    let is_meant = statistic.is_finite() && statistic >= 0.0;
    is_meant.then(|| ChiSquared::new(degrees).ok()).flatten().map(|law| law.sf(statistic))
}

/// What chi-square with so many degrees stays below with this probability; none unless the degrees are above zero.
pub fn chi_square_quantile(probability: f64, degrees: f64) -> Option<f64> {
    let law = ChiSquared::new(degrees).ok()?;
    // statrs' quantile is off by 7e-11 at 2 degrees; Newton's steps on its distribution function are not.
    let mut at = law.inverse_cdf(probability);
    for _ in 0..3 {
        at -= (law.cdf(at) - probability) / law.pdf(at);
    }
    Some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_scipys() {
        // scipy.stats.chi2.sf(statistic, degrees)
        let mut count = 0;
        for (statistic, degrees, want) in SCIPY {
            let got = chi_square_tail(statistic, degrees).unwrap();
            assert!(
                (got / want - 1.0).abs() < 1e-9,
                "{statistic} {degrees}: {got:e}, scipy {want:e}"
            );
            count += 1;
        }
        assert!(count >= 20);
        assert_eq!(chi_square_tail(-1.0, 3.0), None);
        assert_eq!(chi_square_tail(f64::NAN, 3.0), None);
        assert_eq!(chi_square_tail(1.0, 0.0), None);
    }

    const SCIPY: [(f64, f64, f64); 45] = [
        (0.1, 1.0, 0.7518296340458492),
        (0.9, 1.0, 0.34278171114790873),
        (1.0, 1.0, 0.31731050786291115),
        (1.7, 1.0, 0.19228797711151613),
        (3.0, 1.0, 0.08326451666355042),
        (0.2, 2.0, 0.9048374180359595),
        (1.8, 2.0, 0.4065696597405992),
        (2.0, 2.0, 0.36787944117144245),
        (3.4, 2.0, 0.18268352405273466),
        (6.0, 2.0, 0.04978706836786395),
        (0.30000000000000004, 3.0, 0.9600284803068776),
        (2.7, 3.0, 0.4402272943602312),
        (3.0, 3.0, 0.3916251762710877),
        (5.1, 3.0, 0.16461940408195308),
        (9.0, 3.0, 0.02929088653488826),
        (0.4, 4.0, 0.9824769036935782),
        (3.6, 4.0, 0.46283688702044234),
        (4.0, 4.0, 0.40600584970983794),
        (6.8, 4.0, 0.14684238782543477),
        (12.0, 4.0, 0.01735126523666451),
        (0.8, 8.0, 0.999223748623793),
        (7.2, 8.0, 0.5152161104661482),
        (8.0, 8.0, 0.43347012036670896),
        (13.6, 8.0, 0.09280568545255084),
        (24.0, 8.0, 0.002291791207791423),
        (1.2000000000000002, 12.0, 0.9999611439218486),
        (10.8, 12.0, 0.5461321043581993),
        (12.0, 12.0, 0.44567964136461097),
        (20.4, 12.0, 0.05988765537102166),
        (36.0, 12.0, 0.00032399345110116875),
        (3.0, 30.0, 0.9999999999176028),
        (27.0, 30.0, 0.6232711254087306),
        (30.0, 30.0, 0.4656537089440098),
        (51.0, 30.0, 0.0097408242493361),
        (90.0, 30.0, 6.56732682000148e-08),
        (10.0, 100.0, 1.0),
        (90.0, 100.0, 0.7531979655998298),
        (100.0, 100.0, 0.48119168452795674),
        (170.0, 100.0, 1.5887549983147087e-05),
        (300.0, 100.0, 7.4121008573230175e-22),
        (100.0, 1000.0, 1.0),
        (900.0, 1000.0, 0.9892827619087102),
        (1000.0, 1000.0, 0.49405285382923964),
        (1700.0, 1000.0, 4.213816622672781e-39),
        (3000.0, 1000.0, 1.6436845843568014e-198),
    ];
}
