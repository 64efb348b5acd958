//! Repeats of one measurement, of one number each or of many at once.

/// Sums of products that finding the independent columns may take; beyond, every so many columns are left out.
const MOST_PRODUCTS: usize = 100_000_000;

/// Two or more rows of finite numbers, equally long. They are kept in the order of their content, so that sums run in one
/// order whatever order the rows came in.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeats(Vec<Vec<f64>>);

impl Repeats {
    /// None with fewer than two rows, rows of unlike length or without numbers, or a number that is not finite.
    pub fn new(mut rows: Vec<Vec<f64>>) -> Option<Self> {
        let columns = rows.first().map_or(0, Vec::len);
        let is_whole =
            |row: &Vec<f64>| row.len() == columns && row.iter().all(|value| value.is_finite());
        if rows.len() < 2 || columns == 0 || !rows.iter().all(is_whole) {
            return None;
        }
        rows.sort_by(|a, b| by_content(a, b));
        Some(Self(rows))
    }

    /// Of single numbers.
    pub fn of_numbers(values: &[f64]) -> Option<Self> {
        Self::new(values.iter().map(|&value| vec![value]).collect())
    }

    /// How many rows.
    pub fn n(&self) -> usize {
        self.0.len()
    }

    /// The rows, in the order of their content.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.0
    }

    /// The root of the variance, with n - 1, summed over the columns.
    pub fn std(&self) -> f64 {
        (sum_of_squares(&self.deviations()) / (self.n() - 1) as f64).sqrt()
    }

    /// Degrees of freedom of the std: (n - 1) times the columns that vary independently.
    pub fn degrees(&self) -> f64 {
        (self.n() - 1) as f64 * independent_columns(&self.deviations())
    }

    /// What is left of each row without the mean of all.
    fn deviations(&self) -> Vec<Vec<f64>> {
        let mean = mean_row(&self.0);
        self.0.iter().map(|row| difference(row, &mean)).collect()
    }

    /// The median of each column.
    pub(super) fn medians(&self) -> Vec<f64> {
        let columns = 0..self.0[0].len();
        let mut column = vec![0.0; self.n()];
        let median = |at: usize| {
            for (value, row) in column.iter_mut().zip(&self.0) {
                *value = row[at];
            }
            column.sort_by(f64::total_cmp);
            let middle = column.len() / 2;
            let below = column[(column.len() - 1) / 2];
            below + (column[middle] - below) / 2.0
        };
        columns.map(median).collect()
    }
}

/// An order of rows by what stands in them.
pub(super) fn by_content(one: &[f64], other: &[f64]) -> std::cmp::Ordering {
    let unequal = one.iter().zip(other).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
    unequal.unwrap_or(one.len().cmp(&other.len()))
}

/// The mean of the rows. Summed as differences from the middle row, so that a common offset costs no digits.
pub(super) fn mean_row(rows: &[Vec<f64>]) -> Vec<f64> {
    let (n, middle) = (rows.len() as f64, &rows[rows.len() / 2]);
    let mut sum = vec![0.0; middle.len()];
    for row in rows {
        for ((sum, value), middle) in sum.iter_mut().zip(row).zip(middle) {
            *sum += (value - middle) / n;
        }
    }
    sum.iter().zip(middle).map(|(sum, middle)| middle + sum).collect()
}

pub(super) fn difference(row: &[f64], from: &[f64]) -> Vec<f64> {
    row.iter().zip(from).map(|(value, from)| value - from).collect()
}

pub(super) fn sum_of_squares(rows: &[Vec<f64>]) -> f64 {
    rows.iter().flatten().map(|value| value * value).sum()
}

/// As how many independent columns the sum of squares of these residuals varies: (tr W)^2 / tr W^2 over the products W of
/// their rows, which lies between 1 and the number of columns or rows.
///
/// G. E. P. Box, Annals of Mathematical Statistics 25 (1954): a sum of unequal chi-squares is nearly a chi-square of fewer
/// degrees. With the covariance estimated by W the number is too low for few rows, never too high on the average: a test that
/// uses it keeps to its level. The number of parameters behind the columns would not: a focal length that moves the image most
/// leaves little to the others, and F tests with p (n - 1) degrees were seen to reject up to a quarter of equal groups.
pub(super) fn independent_columns(residuals: &[Vec<f64>]) -> f64 {
    let columns = residuals[0].len();
    if columns == 1 {
        return 1.0;
    }
    // Odd, so that of columns that come in pairs both kinds are taken. A smooth field needs few.
    let every = residuals.len().pow(2).saturating_mul(columns) / MOST_PRODUCTS / 2 * 2 + 1;
    let thin = |row: &Vec<f64>| row.iter().step_by(every).copied().collect::<Vec<f64>>();
    let rows: Vec<Vec<f64>> = residuals.iter().map(thin).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut trace, mut square) = (0.0, 0.0);
    for (index, row) in rows.iter().enumerate() {
        let own = dot(row, row);
        let others: f64 = rows[..index].iter().map(|other| dot(row, other).powi(2)).sum();
        trace += own;
        square += own * own + 2.0 * others;
    }
    if square > 0.0 { trace * trace / square } else { 1.0 }
}

/// Degrees of freedom of the std of repeats of which only the distances from each to each are known: (n - 1) (tr W)^2 / tr W^2
/// again, W found from the squares of the distances less the means of their rows and columns (Torgerson 1952).
pub fn degrees_of_distances(distances: &[Vec<f64>]) -> f64 {
    let n = distances.len() as f64;
    let row_means: Vec<f64> =
        distances.iter().map(|row| row.iter().map(|d| d * d).sum::<f64>() / n).collect();
    let mean = row_means.iter().sum::<f64>() / n;
    let (mut trace, mut square) = (0.0, 0.0);
    for (row, (of_row, row_mean)) in distances.iter().zip(&row_means).enumerate() {
        for (column, (distance, column_mean)) in of_row.iter().zip(&row_means).enumerate() {
            let product = 0.5 * (row_mean + column_mean - mean - distance * distance);
            square += product * product;
            trace += if row == column { product } else { 0.0 };
        }
    }
    (n - 1.0) * if square > 0.0 { trace * trace / square } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_column_has_the_std_of_its_numbers_and_n_minus_one_degrees() {
        let values = [9.0, 2.0, 5.0, 4.0, 7.0, 4.0, 4.0, 5.0];
        let repeats = Repeats::of_numbers(&values).unwrap();
        assert!((repeats.std() - (32.0_f64 / 7.0).sqrt()).abs() < 1e-14);
        assert!((repeats.degrees() - 7.0).abs() < 1e-14);
    }

    #[test]
    fn columns_that_vary_alike_count_once_and_independent_ones_each() {
        let alike = |t: f64| vec![t, 2.0 * t, -t];
        let alike = Repeats::new([1.0, 2.0, 4.0, 7.0].map(alike).to_vec()).unwrap();
        assert!((alike.degrees() - 3.0).abs() < 1e-12, "{}", alike.degrees());
        // A tetrahedron about its centre: three directions of equal weight
        let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let apart = Repeats::new(corners.map(Vec::from).to_vec()).unwrap();
        assert!((apart.degrees() - 9.0).abs() < 1e-12, "{}", apart.degrees());
        assert!((apart.std() - 2.0).abs() < 1e-12, "{}", apart.std());
    }

    #[test]
    fn distances_alone_tell_the_degrees() {
        let rows = [[0.1, 3.0, 1.0], [0.7, 2.9, 1.5], [-0.3, 3.1, 0.2], [0.1, 2.0, 0.9]];
        let distance = |a: &[f64; 3], b: &[f64; 3]| {
            a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let distances: Vec<Vec<f64>> =
            rows.iter().map(|a| rows.iter().map(|b| distance(a, b)).collect()).collect();
        let want = Repeats::new(rows.map(Vec::from).to_vec()).unwrap().degrees();
        assert!(want > 3.5, "{want}: the columns would count as one");
        assert!((degrees_of_distances(&distances) / want - 1.0).abs() < 1e-13);
        assert!((degrees_of_distances(&vec![vec![0.0; 3]; 3]) - 2.0).abs() < 1e-15);
    }

    #[test]
    fn the_order_of_the_rows_changes_no_bit() {
        let mut rows = vec![vec![0.1, 3.0], vec![0.7, 2.9], vec![-0.3, 3.1], vec![0.1, 2.0]];
        let one = Repeats::new(rows.clone()).unwrap();
        rows.reverse();
        let other = Repeats::new(rows).unwrap();
        assert_eq!(one.std().to_bits(), other.std().to_bits());
        assert_eq!(one.degrees().to_bits(), other.degrees().to_bits());
    }

    #[test]
    fn many_rows_are_counted_on_fewer_columns() {
        // Two directions of equal weight over 900 columns; 400^2 * 900 products are over the limit.
        let quarter = std::f64::consts::FRAC_PI_2;
        let row = |i: i32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 400.0;
            let value = |c: i32| angle.cos() * wave(c, 0.0) + angle.sin() * wave(c, quarter);
            (0..900).map(value).collect()
        };
        fn wave(column: i32, phase: f64) -> f64 {
            (f64::from(column) * std::f64::consts::TAU / 90.0 + phase).cos()
        }
        let repeats = Repeats::new((0..400).map(row).collect()).unwrap();
        assert!((repeats.degrees() / 399.0 - 2.0).abs() < 1e-3, "{}", repeats.degrees());
    }

    #[test]
    fn what_has_no_std_is_refused() {
        assert_eq!(Repeats::of_numbers(&[1.0]), None);
        assert_eq!(Repeats::of_numbers(&[1.0, f64::NAN]), None);
        assert_eq!(Repeats::new(vec![vec![1.0], vec![1.0, 2.0]]), None);
        assert_eq!(Repeats::new(vec![vec![], vec![]]), None);
    }
}
