//! How much of a variance comes from groups, and how much from the repeats within them: one-way random effects.
//!
//! Estimates by analysis of variance (S. R. Searle, G. Casella, C. E. McCulloch, Variance Components, 1992, section 3.6);
//! intervals by the modified large sample method (F. A. Graybill and C.-M. Wang 1980 for sums of mean squares, N. Ting and
//! others 1990 for differences; both in R. K. Burdick and F. A. Graybill, Confidence Intervals on Variance Components, 1992),
//! with unequal groups by the unweighted mean square of their means (J. D. Thomas and R. A. Hultquist 1978).

use super::fisher::{critical, upper_tail};
use super::repeats::{by_content, difference, independent_columns, mean_row, sum_of_squares};
use super::spread_interval::std_interval_factors_of_degrees;

/// Outside either end of an interval of 95 %.
const TAIL: f64 = 0.025;

/// Variances, in the unit of the numbers squared and summed over the columns, of normal groups and repeats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OneWay {
    /// Among repeats within a group: the mean square.
    pub within: f64,
    /// 95 % confidence interval of it (chi-square).
    pub within_interval: [f64; 2],
    /// Among the true means of groups; below zero where chance put the groups closer together than their repeats allow.
    pub between: f64,
    /// 95 % confidence interval of it, never below zero.
    pub between_interval: [f64; 2],
    /// Among repeats in a new group each: what is within and what is between.
    pub total: f64,
    /// 95 % confidence interval of it.
    pub total_interval: [f64; 2],
    /// The mean square between over that within.
    pub f: f64,
    /// Degrees of freedom of f, numerator first: groups less one, repeats less groups, both times the independent columns.
    pub degrees: [f64; 2],
    /// How often so large an f comes from groups that do not differ.
    pub p: f64,
}

/// A mean square and its degrees of freedom.
#[derive(Debug, Clone, Copy)]
struct MeanSquare {
    value: f64,
    degrees: f64,
}

/// The analysis of groups of rows. None with fewer than two groups, an empty one, no group of two rows, rows of unlike length, or
/// repeats that do not vary.
pub fn one_way(mut groups: Vec<Vec<Vec<f64>>>) -> Option<OneWay> {
    let columns = groups.first()?.first()?.len();
    let is_whole =
        |row: &Vec<f64>| row.len() == columns && row.iter().all(|value| value.is_finite());
    let row_count: usize = groups.iter().map(Vec::len).sum();
    let is_enough = groups.len() > 1 && row_count > groups.len() && columns > 0;
    if !is_enough || groups.iter().any(Vec::is_empty) || !groups.iter().flatten().all(is_whole) {
        return None;
    }
    for group in &mut groups {
        group.sort_by(|a, b| by_content(a, b));
    }
    // No two groups have equal rows and a sum that cares.
    groups.sort_by(|a, b| by_content(&a[0], &b[0]).then(a.len().cmp(&b.len())));
    let means: Vec<Vec<f64>> = groups.iter().map(|group| mean_row(group)).collect();
    let residuals: Vec<Vec<f64>> = groups
        .iter()
        .zip(&means)
        .filter(|(group, _)| group.len() > 1)
        .flat_map(|(group, mean)| group.iter().map(move |row| difference(row, mean)))
        .collect();
    let [group_count, count] = [groups.len() as f64, row_count as f64];
    let square_within = sum_of_squares(&residuals) / (count - group_count);
    if square_within <= 0.0 {
        return None;
    }
    let sizes: Vec<f64> = groups.iter().map(|group| group.len() as f64).collect();
    let columns = independent_columns(&residuals);
    let degrees = [(group_count - 1.0) * columns, (count - group_count) * columns];
    let square_between = sum_of_squares(&weighted_deviations(&sizes, &means)) / (group_count - 1.0);
    let f = square_between / square_within;
    let size =
        (count - sizes.iter().map(|size| size * size).sum::<f64>() / count) / (group_count - 1.0);
    let within = MeanSquare { value: square_within, degrees: degrees[1] };
    let (unweighted, mean_size) = unweighted_mean_square(&sizes, &means);
    let between = (square_between - square_within) / size;
    Some(OneWay {
        within: square_within,
        within_interval: interval_of_mean_square(within)?,
        between,
        between_interval: interval_of_difference(unweighted, within, mean_size.recip())?,
        total: square_within + between.max(0.0),
        total_interval: interval_of_sum(
            [unweighted, within],
            [mean_size.recip(), 1.0 - mean_size.recip()],
        )?,
        f,
        degrees,
        p: upper_tail(f, degrees)?,
    })
}

/// The deviation of each group's mean from the mean of all rows, times the root of its size.
fn weighted_deviations(sizes: &[f64], means: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let count: f64 = sizes.iter().sum();
    let middle = &means[means.len() / 2];
    let mut mean = middle.clone();
    for (size, row) in sizes.iter().zip(means) {
        for (sum, difference) in mean.iter_mut().zip(difference(row, middle)) {
            *sum += size / count * difference;
        }
    }
    let weighted = |(size, row): (&f64, &Vec<f64>)| {
        difference(row, &mean).iter().map(|value| size.sqrt() * value).collect()
    };
    sizes.iter().zip(means).map(weighted).collect()
}

/// The mean square between the means as if all groups had the harmonic mean of the sizes, and that mean. With equal sizes the
/// usual one.
fn unweighted_mean_square(sizes: &[f64], means: &[Vec<f64>]) -> (MeanSquare, f64) {
    let group_count = sizes.len() as f64;
    let size = group_count / sizes.iter().map(|size| size.recip()).sum::<f64>();
    let deviations = weighted_deviations(&vec![1.0; sizes.len()], means);
    let degrees = (group_count - 1.0) * independent_columns(&deviations);
    let value = size * sum_of_squares(&deviations) / (group_count - 1.0);
    (MeanSquare { value, degrees }, size)
}

fn interval_of_mean_square(square: MeanSquare) -> Option<[f64; 2]> {
    let factors = std_interval_factors_of_degrees(square.degrees, 1.0 - 2.0 * TAIL)?;
    Some(factors.map(|factor| factor * factor * square.value))
}

/// G and H of the method: by how much of itself a mean square may be too large or too small.
fn reach(square: MeanSquare) -> Option<[f64; 2]> {
    let [low, high] = std_interval_factors_of_degrees(square.degrees, 1.0 - 2.0 * TAIL)?;
    Some([1.0 - low * low, high * high - 1.0])
}

/// Of the sum of mean squares times positive weights.
fn interval_of_sum(squares: [MeanSquare; 2], weights: [f64; 2]) -> Option<[f64; 2]> {
    let [one, other] = [0, 1].map(|side| weights[side] * squares[side].value);
    let [[g1, h1], [g2, h2]] = [reach(squares[0])?, reach(squares[1])?];
    Some([one + other - (g1 * one).hypot(g2 * other), one + other + (h1 * one).hypot(h2 * other)])
}

/// Of the difference of two mean squares, times a positive weight; cut off at zero.
fn interval_of_difference(from: MeanSquare, what: MeanSquare, weight: f64) -> Option<[f64; 2]> {
    let [one, other] = [weight * from.value, weight * what.value];
    let [[g1, h1], [g2, h2]] = [reach(from)?, reach(what)?];
    let [f1, f2] = [
        critical(TAIL, [from.degrees, what.degrees])?,
        critical(1.0 - TAIL, [from.degrees, what.degrees])?,
    ];
    let g12 = ((f1 - 1.0).powi(2) - (g1 * f1).powi(2) - h2 * h2) / f1;
    let h12 = ((1.0 - f2).powi(2) - (h1 * f2).powi(2) - g2 * g2) / f2;
    let below = (g1 * one).powi(2) + (h2 * other).powi(2) + g12 * one * other;
    let above = (h1 * one).powi(2) + (g2 * other).powi(2) + h12 * one * other;
    let ends = [one - other - below.max(0.0).sqrt(), one - other + above.max(0.0).sqrt()];
    Some(ends.map(|end| end.max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::super::testing::Random;
    use super::*;

    fn rows(groups: &[&[f64]]) -> Vec<Vec<Vec<f64>>> {
        groups.iter().map(|group| group.iter().map(|value| vec![*value]).collect()).collect()
    }

    fn assert_near(got: f64, want: f64, what: &str) {
        assert!((got - want).abs() <= 1e-9 * want.abs(), "{what}: {got}, expected {want}");
    }

    /// scipy.stats.f_oneway, chi2.isf and f.isf, put together by the formulas in numpy.
    const NUMPY_AND_SCIPY: [(&[&[f64]], [f64; 11]); 3] = [
        (
            &[
                &[421.001, 411.932, 419.312, 430.513, 440.073, 428.747],
                &[400.5, 401.75, 419.0, 400.25],
                &[470.0, 431.0, 452.5, 448.0, 455.0, 460.5, 421.0],
            ],
            [
                176.14803810204074,
                94.41699294995638,
                438.1226743466508,
                411.2918970438562,
                88.03022291005476,
                18177.97224728363,
                587.4399351458969,
                261.7937838186175,
                18359.07435509698,
                13.910744160119894,
                0.00047108563400553573,
            ],
        ),
        (
            &[
                &[421.001, 411.932, 419.312, 430.513, 440.073, 428.747],
                &[430.0, 420.5, 425.25, 441.0, 422.0, 433.5],
            ],
            [
                79.0383545333332,
                38.58696001097589,
                243.42167268666773,
                -7.237898199999768,
                0.0,
                6028.055667931323,
                79.0383545333332,
                37.75741834709403,
                6110.945782274632,
                0.4505529694234088,
                0.5172765718724439,
            ],
        ),
        (
            &[&[400.5, 401.75, 419.0, 400.25], &[440.0]],
            [
                82.9375,
                26.615506831597724,
                1153.002498361591,
                547.6093749999999,
                0.0,
                610319.6147402925,
                630.5468749999999,
                149.95628341483177,
                610421.3802901297,
                11.564280331574981,
                0.04244168674264316,
            ],
        ),
    ];

    #[test]
    fn components_and_intervals_are_those_of_numpy_and_scipy() {
        for (groups, want) in NUMPY_AND_SCIPY {
            let found = one_way(rows(groups)).unwrap();
            let got = [
                found.within,
                found.within_interval[0],
                found.within_interval[1],
                found.between,
                found.between_interval[0],
                found.between_interval[1],
                found.total,
                found.total_interval[0],
                found.total_interval[1],
                found.f,
                found.p,
            ];
            for (index, (got, want)) in got.into_iter().zip(want).enumerate() {
                assert_near(got, want, &format!("{groups:?}, number {index}"));
            }
        }
    }

    #[test]
    fn equal_means_leave_nothing_between() {
        let found = one_way(rows(&[&[1.0, 2.0, 3.0], &[0.0, 2.0, 4.0]])).unwrap();
        assert_near(found.within, 2.5, "within");
        assert_near(found.between, -2.5 / 3.0, "between");
        assert_near(found.total, 2.5, "total");
        assert_eq!(found.between_interval[0].to_bits(), 0.0_f64.to_bits());
        assert_near(found.p, 1.0, "p");
    }

    #[test]
    fn columns_add_their_variances_and_one_column_twice_counts_once() {
        let numbers: [&[f64]; 2] = [&[1.0, 2.0, 4.0], &[7.0, 9.0]];
        let once = one_way(rows(&numbers)).unwrap();
        let twice: Vec<Vec<Vec<f64>>> = numbers
            .iter()
            .map(|group| group.iter().map(|value| vec![*value, -value]).collect())
            .collect();
        let twice = one_way(twice).unwrap();
        assert_near(twice.within, 2.0 * once.within, "within");
        assert_near(twice.between, 2.0 * once.between, "between");
        assert_near(twice.between_interval[1], 2.0 * once.between_interval[1], "its interval");
        assert_near(twice.p, once.p, "p");
    }

    #[test]
    fn the_order_of_rows_and_groups_changes_no_bit() {
        let one = one_way(rows(&[&[0.1, 0.7, -0.3], &[1.5, 1.9], &[0.2]])).unwrap();
        let other = one_way(rows(&[&[0.2], &[1.9, 1.5], &[-0.3, 0.1, 0.7]])).unwrap();
        let bits = |one: OneWay| [one.within, one.between, one.total_interval[1]].map(f64::to_bits);
        assert_eq!(bits(one), bits(other));
    }

    #[test]
    fn what_has_no_components_is_refused() {
        assert_eq!(one_way(rows(&[&[1.0, 2.0]])), None);
        assert_eq!(one_way(rows(&[&[1.0], &[2.0]])), None);
        assert_eq!(one_way(rows(&[&[1.0, 1.0], &[2.0, 2.0]])), None);
        assert_eq!(one_way(rows(&[&[1.0, f64::NAN], &[2.0, 3.0]])), None);
        assert_eq!(one_way(rows(&[&[1.0, 2.0], &[]])), None);
        assert_eq!(one_way(vec![]), None);
    }

    #[test]
    fn intervals_cover_the_truth_nineteen_times_of_twenty() {
        const TRIALS: u32 = 4000;
        for (sizes, sigma_between) in
            [([5, 5, 5, 5], 0.0), ([6, 6, 6, 6], 2.0), ([2, 9, 4, 5], 1.0)]
        {
            let mut random = Random(20);
            let mut covered = [0_u32; 3];
            for _ in 0..TRIALS {
                let group = |random: &mut Random, size: i32| {
                    let mean = sigma_between * random.normal();
                    (0..size).map(|_| vec![mean + random.normal()]).collect()
                };
                let groups = sizes.map(|size| group(&mut random, size)).to_vec();
                let found = one_way(groups).unwrap();
                let truth =
                    [1.0, sigma_between * sigma_between, 1.0 + sigma_between * sigma_between];
                let intervals =
                    [found.within_interval, found.between_interval, found.total_interval];
                for ((covered, truth), [low, high]) in covered.iter_mut().zip(truth).zip(intervals)
                {
                    *covered += u32::from(low <= truth && truth <= high);
                }
            }
            // Of 4000 trials at 95 % 3800 cover, give or take 14. The method is known to be within 94 and 97 % where it is not
            // exact; at a truth of zero the lower end never misses.
            let least = f64::from(TRIALS) * 0.937;
            let most = f64::from(TRIALS) * 0.985;
            for covered in covered {
                assert!((least..most).contains(&f64::from(covered)), "{sizes:?}: {covered}");
            }
        }
    }
}
