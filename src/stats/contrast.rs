//! Which of two methods has the lesser root mean square error, when both met the same replicates in the same strata.

use std::collections::BTreeMap;

use super::fisher::{critical, upper_tail};
use super::std_interval_factors_of_degrees;

/// What both methods did in one replicate of one stratum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// The block that the replicate is of, and its number there. The same replicate in several strata is not independent of
    /// itself; replicates of different blocks may differ by more than chance.
    pub replicate: (usize, usize),
    /// The squared error of the one and of the other.
    pub squares: [f64; 2],
}

/// The logarithm of a ratio of root mean squares, mean over strata, and how sure it is.
///
/// Over independent replicates, ln of a mean square varies to first order as the mean of the squares over their mean does: so
/// the influences of each replicate, summed over the strata, tell the variance (the delta method).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contrast {
    /// ln of the one over the other.
    pub log_ratio: f64,
    /// Its standard deviation.
    pub std: f64,
    /// The degrees of freedom of that: replicates less blocks.
    pub degrees: f64,
}

impl Contrast {
    /// Of the pairs of each stratum. None without strata, where a mean square is zero, or with fewer than two replicates in
    /// every block.
    pub fn new(strata: &[Vec<Pair>]) -> Option<Self> {
        let mut log_ratio = 0.0;
        let mut influences: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        let weight = 0.5 / strata.len() as f64;
        for pairs in strata {
            let count = pairs.len() as f64;
            let mean = |side: usize| pairs.iter().map(|it| it.squares[side]).sum::<f64>() / count;
            let [one, other] = [mean(0), mean(1)];
            if !(one > 0.0 && other > 0.0) {
                return None;
            }
            log_ratio += weight * (one / other).ln();
            for Pair { replicate, squares } in pairs {
                let influence = weight * (squares[0] / one - squares[1] / other) / count;
                *influences.entry(*replicate).or_default() += influence;
            }
        }
        let mut blocks: Vec<usize> = influences.keys().map(|(block, _)| *block).collect();
        blocks.dedup();
        let (mut variance, mut degrees) = (0.0, 0.0);
        for block in blocks {
            let own = influences.range((block, 0)..=(block, usize::MAX));
            let count = own.clone().count() as f64;
            if count > 1.0 {
                variance += count / (count - 1.0) * own.map(|(_, part)| part * part).sum::<f64>();
                degrees += count - 1.0;
            }
        }
        (degrees > 0.0).then(|| Self { log_ratio, std: variance.sqrt(), degrees })
    }

    /// Of one such logarithm for each of several independent blocks; none for fewer than two.
    pub fn of_blocks(log_ratios: &[f64]) -> Option<Self> {
        let count = log_ratios.len() as f64;
        if log_ratios.len() < 2 {
            return None;
        }
        let mean = log_ratios.iter().sum::<f64>() / count;
        let squares = log_ratios.iter().map(|one| (one - mean).powi(2)).sum::<f64>();
        let std = (squares / (count - 1.0) / count).sqrt();
        Some(Self { log_ratio: mean, std, degrees: count - 1.0 })
    }

    /// The ratio of the root mean squares, geometric mean over the strata.
    pub fn ratio(&self) -> f64 {
        self.log_ratio.exp()
    }

    /// The ends of an interval that has the true ratio in it with this probability (Student's t).
    pub fn interval(&self, confidence: f64) -> Option<[f64; 2]> {
        // t^2 with so many degrees is F with 1 and so many.
        let reach = critical(1.0 - confidence, [1.0, self.degrees])?.sqrt() * self.std;
        Some([-reach, reach].map(|reach| (self.log_ratio + reach).exp()))
    }

    /// How often methods that are equally good differ by as much; one that never differed is equal.
    pub fn p(&self) -> Option<f64> {
        match (self.log_ratio.abs() > 0.0, self.std > 0.0) {
            (false, _) => Some(1.0),
            (true, false) => None,
            (true, true) => upper_tail((self.log_ratio / self.std).powi(2), [1.0, self.degrees]),
        }
    }
}

/// The ends of an interval of the root mean square behind independent squares: as if they were chi-squares of as many degrees
/// as their own mean and variance tell (F. E. Satterthwaite, Biometrics Bulletin 2, 1946). None for fewer than two, or equal ones.
pub fn rms_interval(squares: &[f64], confidence: f64) -> Option<[f64; 2]> {
    let count = squares.len() as f64;
    let mean = squares.iter().sum::<f64>() / count;
    let variance = squares.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let degrees = 2.0 * count * mean * mean / variance;
    if squares.len() < 2 || !(degrees > 0.0 && degrees.is_finite()) {
        return None;
    }
    let factors = std_interval_factors_of_degrees(degrees, confidence)?;
    Some(factors.map(|factor| factor * mean.sqrt()))
}

/// Kendall's coefficient of concordance: how far several judges order the same things alike, from 0 to 1 (M. G. Kendall, B.
/// Babington Smith, Annals of Mathematical Statistics 10, 1939). A row of scores for each judge. Equal scores share their
/// ranks. None for fewer than two judges or things, or where a judge sees no difference at all.
pub fn concordance(scores: &[Vec<f64>]) -> Option<f64> {
    let things = scores.first()?.len();
    if scores.len() < 2 || things < 2 || scores.iter().any(|row| row.len() != things) {
        return None;
    }
    let ranks: Vec<Vec<f64>> = scores.iter().map(|row| mid_ranks(row)).collect();
    let middle = (things as f64 + 1.0) / 2.0;
    let off = |rank: f64| (rank - middle).powi(2);
    let own: Vec<f64> =
        ranks.iter().map(|row| row.iter().map(|&rank| off(rank)).sum::<f64>()).collect();
    if own.iter().any(|&sum| sum <= 0.0) {
        return None;
    }
    let mean = |thing: usize| ranks.iter().map(|row| row[thing]).sum::<f64>() / ranks.len() as f64;
    let between: f64 = (0..things).map(|thing| off(mean(thing))).sum();
    Some(between * own.len() as f64 / own.iter().sum::<f64>())
}

/// The ranks of numbers from 1 on; equal ones share the mean of theirs.
fn mid_ranks(values: &[f64]) -> Vec<f64> {
    let rank = |value: &f64| {
        let below = values.iter().filter(|other| *other < value).count();
        let above = values.iter().filter(|other| *other > value).count();
        (below + values.len() - above + 1) as f64 / 2.0
    };
    values.iter().map(rank).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::Random;
    use super::*;

    fn pairs(squares: impl Iterator<Item = [f64; 2]>) -> Vec<Pair> {
        squares.enumerate().map(|(at, squares)| Pair { replicate: (0, at), squares }).collect()
    }

    #[test]
    fn the_ratio_is_that_of_the_root_mean_squares() {
        let found = Contrast::new(&[pairs([[4.0, 1.0], [12.0, 1.0]].into_iter())]).unwrap();
        assert!((found.ratio() - 8.0_f64.sqrt()).abs() < 1e-14);
        assert!((found.degrees - 1.0).abs() < 1e-15);
        // The influences are -1/8 and 1/8: twice the sum of their squares is 1/16.
        assert!((found.std - 0.25).abs() < 1e-14, "{}", found.std);
    }

    #[test]
    fn strata_of_the_same_replicates_tell_no_more_than_one() {
        let one = pairs((0..9_u32).map(|at| [f64::from(at * at % 7 + 1), 3.0]));
        let alone = Contrast::new(std::slice::from_ref(&one)).unwrap();
        let thrice = Contrast::new(&[one.clone(), one.clone(), one]).unwrap();
        assert!((alone.std / thrice.std - 1.0).abs() < 1e-12);
        assert!((alone.degrees - thrice.degrees).abs() < 1e-12);
    }

    #[test]
    fn intervals_and_p_are_students() {
        // scipy: t.ppf(0.975, 29) = 2.045229642132703, 2 t.sf(2, 29) = 0.05494363718296717
        let found = Contrast { log_ratio: 0.2, std: 0.1, degrees: 29.0 };
        let [low, high] = found.interval(0.95).unwrap();
        assert!((high.ln() - 0.2 - 0.204_522_964_213_270_3).abs() < 1e-12);
        assert!((low.ln() - 0.2 + 0.204_522_964_213_270_3).abs() < 1e-12);
        assert!((found.p().unwrap() - 0.054_943_637_182_967_17).abs() < 1e-12);
        assert_eq!(Contrast { log_ratio: 0.0, std: 0.0, degrees: 5.0 }.p(), Some(1.0));
    }

    #[test]
    fn what_tells_nothing_is_refused() {
        assert_eq!(Contrast::new(&[]), None);
        assert_eq!(Contrast::new(&[pairs([[1.0, 2.0]].into_iter())]), None);
        assert_eq!(Contrast::new(&[pairs([[0.0, 2.0], [0.0, 1.0]].into_iter())]), None);
        assert_eq!(rms_interval(&[1.0], 0.95), None);
        assert_eq!(rms_interval(&[1.0, 1.0], 0.95), None);
        assert_eq!(Contrast::of_blocks(&[1.0]), None);
    }

    #[test]
    fn equal_methods_differ_as_seldom_as_is_said_and_intervals_hold_their_rms() {
        // The error of a lens is a few normal numbers, of which one weighs most.
        const TRIALS: u32 = 2000;
        let mut random = Random(7);
        let mut square = || random.normal().powi(2) + 0.3 * random.normal().powi(2);
        let (mut found, mut held) = (0_u32, 0_u32);
        for _ in 0..TRIALS {
            let drawn: Vec<[f64; 2]> = (0..30).map(|_| [square(), square()]).collect();
            let contrast = Contrast::new(&[pairs(drawn.iter().copied())]).unwrap();
            found += u32::from(contrast.p().unwrap() < 0.05);
            let one: Vec<f64> = drawn.iter().map(|pair| pair[0]).collect();
            let [low, high] = rms_interval(&one, 0.95).unwrap();
            held += u32::from((low..=high).contains(&1.3_f64.sqrt()));
        }
        // 100 and 1900 are promised; three deviations of a binomial are 29.
        assert!((50..=135).contains(&found), "{found}");
        assert!((1830..=1960).contains(&held), "{held}");
    }

    #[test]
    fn judges_that_agree_have_a_concordance_of_one() {
        let rows = |rows: &[[f64; 3]]| rows.iter().map(|row| row.to_vec()).collect::<Vec<_>>();
        let near = |found: Option<f64>, want: f64| (found.unwrap() - want).abs() < 1e-14;
        assert!(near(concordance(&rows(&[[1.0, 2.0, 3.0], [0.1, 0.5, 9.0]])), 1.0));
        assert!(near(concordance(&rows(&[[1.0, 2.0, 3.0], [3.0, 2.0, 1.0]])), 0.0));
        // Rank sums 4, 5, 9 of three judges: 12 * 14 / (9 * 24) = 7 / 9
        let three = rows(&[[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0]]);
        assert!(near(concordance(&three), 7.0 / 9.0));
        assert_eq!(concordance(&rows(&[[1.0, 2.0, 3.0]])), None);
        assert_eq!(concordance(&rows(&[[1.0, 1.0, 1.0], [1.0, 2.0, 3.0]])), None);
    }
}
