//! Do two samples vary alike, how sure can so few tell, and how many would be needed?

use super::fisher::{critical, lower_tail, upper_tail};
use super::repeats::{Repeats, difference, mean_row, sum_of_squares};

/// More samples than this in a group is no advice to anyone.
const MOST_SAMPLES: usize = 10_000;

/// The outcome of a test that two or more samples vary alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VarianceTest {
    /// The value of F.
    pub f: f64,
    /// Its degrees of freedom, numerator first.
    pub degrees: [f64; 2],
    /// How often an F at least as extreme comes from samples that vary alike.
    pub p: f64,
}

/// The two-sided F test of equal variances, for normal samples: it is as easily misled by their shape as by their spread
/// (G. E. P. Box, Biometrika 40, 1953). Each side is a std and its degrees of freedom. None where a std is not above zero.
pub fn f_test(one: [f64; 2], other: [f64; 2]) -> Option<VarianceTest> {
    if one[0] <= 0.0 || other[0] <= 0.0 {
        return None;
    }
    let (f, degrees) = ((one[0] / other[0]).powi(2), [one[1], other[1]]);
    let tail = upper_tail(f, degrees)?.min(lower_tail(f, degrees)?);
    Some(VarianceTest { f, degrees, p: (2.0 * tail).min(1.0) })
}

/// M. B. Brown and A. B. Forsythe, Journal of the American Statistical Association 69 (1974): Levene's test about the medians,
/// which needs no normal samples. Rows of many columns enter by their distance from the columns' medians (M. J. Anderson,
/// Biometrics 62, 2006). None with one sample alone, or when no distance varies within one.
pub fn brown_forsythe(samples: &[&Repeats]) -> Option<VarianceTest> {
    let distances: Vec<Vec<Vec<f64>>> = samples.iter().map(|one| distances(one)).collect();
    let means: Vec<f64> = distances.iter().map(|group| mean_row(group)[0]).collect();
    let sizes: Vec<f64> = distances.iter().map(|group| group.len() as f64).collect();
    let count: f64 = sizes.iter().sum();
    let grand = sizes.iter().zip(&means).map(|(size, mean)| size / count * mean).sum::<f64>();
    let between: f64 =
        sizes.iter().zip(&means).map(|(size, mean)| size * (mean - grand).powi(2)).sum();
    let within: f64 = distances
        .iter()
        .zip(&means)
        .flat_map(|(group, mean)| group.iter().map(move |distance| (distance[0] - mean).powi(2)))
        .sum();
    let degrees = [sizes.len() as f64 - 1.0, count - sizes.len() as f64];
    if within <= 0.0 {
        return None;
    }
    let f = between / degrees[0] / (within / degrees[1]);
    Some(VarianceTest { f, degrees, p: upper_tail(f, degrees)? })
}

/// The distance of each row from the medians, as rows of one number in ascending order.
fn distances(sample: &Repeats) -> Vec<Vec<f64>> {
    let medians = sample.medians();
    let distance = |row: &Vec<f64>| sum_of_squares(&[difference(row, &medians)]).sqrt();
    let mut distances: Vec<f64> = sample.rows().iter().map(distance).collect();
    distances.sort_by(f64::total_cmp);
    distances.into_iter().map(|distance| vec![distance]).collect()
}

/// Corrects the p of several tests so that all together err as seldom as one would. In the order given.
///
/// S. Holm, Scandinavian Journal of Statistics 6 (1979).
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut corrected = vec![0.0; p.len()];
    let mut least = 0.0_f64;
    for (rank, index) in order.into_iter().enumerate() {
        least = least.max((p.len() - rank) as f64 * p[index]).min(1.0);
        corrected[index] = least;
    }
    corrected
}

/// How often the F test at this level tells two std apart that are in this ratio, of normal samples with these degrees.
pub fn f_test_power(ratio: f64, degrees: [f64; 2], level: f64) -> Option<f64> {
    let square = ratio * ratio;
    let above = upper_tail(critical(level / 2.0, degrees)? / square, degrees)?;
    let below = lower_tail(critical(1.0 - level / 2.0, degrees)? / square, degrees)?;
    Some(above + below)
}

/// The least n in each of two groups with which the F test at this level tells std in this ratio apart with this power, when
/// n samples have n - 1 degrees times `columns`. None when ten thousand would not do.
pub fn samples_needed(ratio: f64, columns: f64, level: f64, power: f64) -> Option<usize> {
    let is_enough = |n: usize| {
        let degrees = (n - 1) as f64 * columns;
        f_test_power(ratio, [degrees; 2], level).is_some_and(|found| found >= power)
    };
    let (mut short, mut enough) = (1, 2);
    while !is_enough(enough) {
        if enough >= MOST_SAMPLES {
            return None;
        }
        (short, enough) = (enough, (2 * enough).min(MOST_SAMPLES));
    }
    while enough - short > 1 {
        let middle = (short + enough) / 2;
        if is_enough(middle) { enough = middle } else { short = middle }
    }
    Some(enough)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(got: f64, want: f64, what: &str) {
        assert!((got - want).abs() <= 1e-9 * want.abs(), "{what}: {got}, scipy {want}");
    }

    const A: [f64; 6] = [421.001, 411.932, 419.312, 430.513, 440.073, 428.747];
    const B: [f64; 4] = [420.5, 421.75, 419.0, 420.25];
    const C: [f64; 11] =
        [400.0, 431.0, 422.5, 418.0, 455.0, 390.5, 421.0, 424.0, 420.0, 433.0, 408.0];

    #[test]
    fn tests_and_power_are_scipys() {
        let sample = |values: &[f64]| Repeats::of_numbers(values).unwrap();
        let (a, b, c) = (sample(&A), sample(&B), sample(&C));
        let by_f =
            |x: &Repeats, y: &Repeats| f_test([x.std(), x.degrees()], [y.std(), y.degrees()]);
        // numpy.var(ddof=1), scipy.stats.f
        let found = by_f(&a, &b).unwrap();
        assert_near(found.f, 77.16691860983588, "F");
        assert_near(found.p, 0.004570054603969162, "p");
        // numpy.var(ddof=1), scipy.stats.f
        let found = by_f(&b, &c).unwrap();
        assert_near(found.f, 0.004299628348071254, "F");
        assert_near(found.p, 0.000831854888757254, "p");
        // numpy.var(ddof=1), scipy.stats.f
        let found = by_f(&a, &c).unwrap();
        assert_near(found.f, 0.3317890707881575, "F");
        assert_near(found.p, 0.23502958846268673, "p");
        // scipy.stats.levene(center="median")
        let found = brown_forsythe(&[&a, &b]).unwrap();
        assert_near(found.f, 7.848158085970302, "F");
        assert_near(found.p, 0.02314581847762997, "p");
        // scipy.stats.levene(center="median")
        let found = brown_forsythe(&[&a, &b, &c]).unwrap();
        assert_near(found.f, 2.0459922428317894, "F");
        assert_near(found.p, 0.15824863763454922, "p");
        // isf and ppf of scipy.stats.f for the critical values
        let powers = [
            (2.0, [5.0, 5.0], 0.05, 0.27092551373931406),
            (3.0, [2.0, 2.0], 0.05, 0.19034090909090923),
            (0.7, [9.0, 3.5], 0.01, 0.04204475575755739),
            (2.5, [14.2, 7.7], 0.05, 0.7484346981532619),
        ];
        for (ratio, degrees, level, want) in powers {
            assert_near(f_test_power(ratio, degrees, level).unwrap(), want, "power");
        }
    }

    #[test]
    fn of_two_columns_the_distances_are_compared() {
        // Distances from the medians (0, 0): 5 5 5 5 0 and 10 10 10 10 0: scipy.stats.f_oneway
        let cross = |r: f64| {
            vec![
                vec![3.0 * r, 4.0 * r],
                vec![-3.0 * r, -4.0 * r],
                vec![-4.0 * r, 3.0 * r],
                vec![4.0 * r, -3.0 * r],
                vec![0.0, 0.0],
            ]
        };
        let [one, other] = [1.0, 2.0].map(|r| Repeats::new(cross(r)).unwrap());
        let test = brown_forsythe(&[&one, &other]).unwrap();
        assert_near(test.f, 3.2, "F");
        assert_near(test.p, 0.11143428937060935, "p");
    }

    #[test]
    fn three_against_three_never_reject_by_brown_and_forsythe() {
        // Either has a distance of zero and two that are nearly equal at best: F stays below 4.
        let test = |a: &[f64], b: &[f64]| {
            brown_forsythe(&[&Repeats::of_numbers(a).unwrap(), &Repeats::of_numbers(b).unwrap()])
        };
        assert!(test(&[-1.0, 0.0, 1.0], &[-1000.0, 0.0, 1000.0]).unwrap().p > 0.116);
        assert_eq!(test(&[1.0, 2.0], &[1.0, 5.0]).map(|test| test.p), None);
    }

    #[test]
    fn what_does_not_vary_has_no_f_test() {
        assert_eq!(f_test([0.0, 3.0], [1.0, 3.0]), None);
        let f = f_test([2.0, 5.0], [2.0, 5.0]).unwrap();
        assert_near(f.p, 1.0, "equal std");
    }

    #[test]
    fn holms_correction_is_by_hand() {
        // sorted .01 .02 .03 .04 times 4 3 2 1, never falling
        let corrected = holm(&[0.03, 0.01, 0.04, 0.02]);
        for (got, want) in corrected.iter().zip([0.06, 0.04, 0.06, 0.06]) {
            assert_near(*got, want, "Holm");
        }
        assert_eq!(holm(&[0.9, 0.6]), [1.0, 1.0]);
        assert_eq!(holm(&[]), [0.0; 0]);
    }

    #[test]
    fn power_at_a_ratio_of_one_is_the_level_and_grows_with_either() {
        let power = |ratio, degrees: f64| f_test_power(ratio, [degrees, 7.5], 0.05).unwrap();
        assert_near(power(1.0, 5.0), 0.05, "the level");
        assert!(power(2.0, 5.0) < power(3.0, 5.0) && power(2.0, 5.0) < power(2.0, 8.0));
        assert!((power(0.5, 7.5) - power(2.0, 7.5)).abs() < 1e-12);
    }

    #[test]
    fn the_n_needed_is_the_least_that_suffices() {
        for (ratio, columns) in [(2.0, 1.0), (3.0, 1.0), (1.3, 1.0), (2.0, 3.4), (0.5, 1.0)] {
            let n = samples_needed(ratio, columns, 0.05, 0.8).unwrap();
            let power =
                |n: usize| f_test_power(ratio, [(n - 1) as f64 * columns; 2], 0.05).unwrap();
            assert!(power(n) >= 0.8 && power(n - 1) < 0.8, "{ratio}: {n}");
        }
        assert_eq!(samples_needed(1.001, 1.0, 0.05, 0.8), None);
        assert_eq!(samples_needed(1e9, 1.0, 0.05, 0.8), Some(2));
    }
}
