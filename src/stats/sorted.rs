//! One sample, sorted: sums then run in one order, whatever order the values came in.

/// Scales the median absolute deviation to the standard deviation of normal samples.
const MAD_TO_STD: f64 = 1.4826;

/// A sample of one or more finite numbers, ascending.
#[derive(Debug, Clone, PartialEq)]
pub struct Sorted(Vec<f64>);

/// Tukey's box plot: the box, and how far its whiskers go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxPlot {
    /// First quartile.
    pub q1: f64,
    /// Third quartile.
    pub q3: f64,
    /// Furthest values within 1.5 interquartile ranges of the box; what lies beyond is an outlier.
    pub whiskers: [f64; 2],
}

impl Sorted {
    /// None when there is no value, or one is not finite.
    pub fn new(mut values: Vec<f64>) -> Option<Self> {
        if values.is_empty() || values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        values.sort_by(f64::total_cmp);
        Some(Self(values))
    }

    /// How many values.
    pub fn n(&self) -> usize {
        self.0.len()
    }

    /// The least value.
    pub fn min(&self) -> f64 {
        self.0[0]
    }

    /// The greatest value.
    pub fn max(&self) -> f64 {
        self.0[self.n() - 1]
    }

    /// Arithmetic mean. Summed as differences from the middle value, so that a common offset costs no digits.
    pub fn mean(&self) -> f64 {
        let middle = self.0[self.n() / 2];
        let n = self.n() as f64;
        middle + self.0.iter().map(|value| (value - middle) / n).sum::<f64>()
    }

    /// Sample standard deviation, with n - 1; none for a single value.
    pub fn std(&self) -> Option<f64> {
        if self.n() < 2 {
            return None;
        }
        let mean = self.mean();
        let widest = (self.max() - mean).max(mean - self.min());
        if widest <= 0.0 {
            return Some(0.0);
        }
        // In units of the widest deviation no square overflows.
        let squares: f64 = self.0.iter().map(|value| ((value - mean) / widest).powi(2)).sum();
        Some(widest * (squares / (self.n() - 1) as f64).sqrt())
    }

    /// Quantile of type 7 of Hyndman and Fan (The American Statistician, 1996): numpy's and R's default.
    pub fn quantile(&self, probability: f64) -> f64 {
        let position = probability.clamp(0.0, 1.0) * (self.n() - 1) as f64;
        let below = position.floor();
        let part = position - below;
        // At most n - 1, so it fits.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let index = below as usize;
        match self.0.get(index + 1) {
            Some(next) => self.0[index] + part * (next - self.0[index]),
            None => self.0[index],
        }
    }

    /// The median.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    /// 1.4826 times the median absolute deviation from the median: the standard deviation, had the sample no outliers.
    pub fn mad_std(&self) -> f64 {
        let median = self.median();
        let mut deviations: Vec<f64> = self.0.iter().map(|value| (value - median).abs()).collect();
        deviations.sort_by(f64::total_cmp);
        MAD_TO_STD * Self(deviations).median()
    }

    /// Tukey's box plot.
    pub fn box_plot(&self) -> BoxPlot {
        let (q1, q3) = (self.quantile(0.25), self.quantile(0.75));
        let reach = 1.5 * (q3 - q1);
        let within = |value: &&f64| (q1 - reach..=q3 + reach).contains(*value);
        // The quartiles lie among the values, so some value is always within reach.
        let low = self.0.iter().find(within).copied().unwrap_or(q1);
        let high = self.0.iter().rfind(within).copied().unwrap_or(q3);
        BoxPlot { q1, q3, whiskers: [low, high] }
    }
}

impl BoxPlot {
    /// Whether a value of the sample lies beyond the whiskers.
    pub fn is_outlier(&self, value: f64) -> bool {
        value < self.whiskers[0] || value > self.whiskers[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(values: &[f64]) -> Sorted {
        Sorted::new(values.to_vec()).unwrap()
    }

    fn assert_near(found: f64, want: f64) {
        assert!((found - want).abs() <= 1e-14 * want.abs(), "found {found}, want {want}");
    }

    #[test]
    fn moments_are_those_of_a_sum_done_by_hand() {
        // 2 4 4 4 5 5 7 9: mean 5, sum of squares 32
        let sample = sorted(&[9.0, 2.0, 5.0, 4.0, 7.0, 4.0, 4.0, 5.0]);
        assert_near(sample.mean(), 5.0);
        assert_near(sample.std().unwrap(), (32.0_f64 / 7.0).sqrt());
    }

    #[test]
    fn an_offset_of_a_billion_costs_the_std_no_digit() {
        // In binary all of these are exact.
        let sample = sorted(&[1e9 + 0.25, 1e9 + 0.5, 1e9 + 0.75]);
        assert_near(sample.std().unwrap(), 0.25);
    }

    #[test]
    fn the_order_of_the_values_changes_no_bit() {
        let values = [0.1, 0.7, -0.3, 1e-9, 12.5, 0.1];
        let mut reversed = values;
        reversed.reverse();
        let (one, other) = (sorted(&values), sorted(&reversed));
        assert_eq!(one.mean().to_bits(), other.mean().to_bits());
        assert_eq!(one.std().map(f64::to_bits), other.std().map(f64::to_bits));
    }

    #[test]
    fn quantiles_are_numpys() {
        // numpy.quantile([1, 2, 4, 8, 16, 32], [0.25, 0.5, 0.75]) = 2.5, 6, 14
        let sample = sorted(&[32.0, 1.0, 16.0, 2.0, 8.0, 4.0]);
        assert_near(sample.quantile(0.25), 2.5);
        assert_near(sample.median(), 6.0);
        assert_near(sample.quantile(0.75), 14.0);
        assert_near(sample.quantile(1.0), 32.0);
    }

    #[test]
    fn the_mad_ignores_one_wild_value() {
        // deviations from the median 3: 2 1 0 1 997
        assert_near(sorted(&[1.0, 2.0, 3.0, 4.0, 1000.0]).mad_std(), 1.4826);
    }

    #[test]
    fn whiskers_end_at_data_and_not_at_the_fences() {
        let values = [10.0, 11.0, 12.0, 13.0, 14.0, 30.0];
        // quartiles 11.25 and 13.75, fences 7.5 and 17.5
        let drawn = sorted(&values).box_plot();
        assert_near(drawn.whiskers[0], 10.0);
        assert_near(drawn.whiskers[1], 14.0);
        assert!(drawn.is_outlier(30.0));
        assert_eq!(values.iter().filter(|value| drawn.is_outlier(**value)).count(), 1);
    }

    #[test]
    fn one_value_has_a_mean_and_no_std() {
        let sample = sorted(&[3.5]);
        assert_near(sample.mean(), 3.5);
        assert_eq!(sample.std(), None);
    }

    #[test]
    fn nothing_and_nan_are_no_sample() {
        assert_eq!(Sorted::new(vec![]), None);
        assert_eq!(Sorted::new(vec![1.0, f64::NAN]), None);
    }

    #[test]
    fn huge_values_do_not_overflow() {
        let std = sorted(&[-1e300, 0.0, 1e300]).std().unwrap();
        assert_near(std, 1e300);
    }
}
