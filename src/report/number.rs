//! Numbers with as many digits as their uncertainty allows.

/// Significant digits of a standard deviation: two, as its own uncertainty leaves no more.
const DIGITS_OF_STD: i32 = 2;
/// Beyond these powers of ten, plain decimals are harder to read than an exponent.
const PLAIN: std::ops::RangeInclusive<i32> = -7..=9;

/// How numbers of one parameter are written: all to the same last place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Places {
    /// So many decimals.
    Decimals(usize),
    /// An exponent, after so many decimals.
    Exponent(usize),
}

impl Places {
    /// The places that a standard deviation leaves meaningful in numbers of this size.
    pub(super) fn of_std(std: f64, size: f64) -> Self {
        let (std_power, power) = (power(std), power(size.abs().max(std)));
        if PLAIN.contains(&std_power) && PLAIN.contains(&power) {
            Self::Decimals(count(DIGITS_OF_STD - 1 - std_power))
        } else {
            Self::Exponent(count(DIGITS_OF_STD - 1 + power - std_power).min(16))
        }
    }

    pub(super) fn write(self, value: f64) -> String {
        let text = match self {
            Self::Decimals(decimals) => format!("{value:.decimals$}"),
            Self::Exponent(decimals) => format!("{value:.decimals$e}"),
        };
        // A minus before zero would be a sign of nothing.
        let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
        if is_zero { text.trim_start_matches('-').to_owned() } else { text }
    }
}

/// A standard deviation: two significant digits.
pub(super) fn std(value: f64) -> String {
    Places::of_std(value, value).write(value)
}

/// A share of one as percent: two significant digits.
pub(super) fn percent(share: f64) -> String {
    format!("{} %", std(100.0 * share))
}

/// A value that nothing says how far to trust: the shortest text that reads back as the same number, six digits at most.
pub(super) fn value(value: f64) -> String {
    if value.abs() > 0.0 && !PLAIN.contains(&power(value)) {
        return format!("{value:e}");
    }
    let shown = format!("{:.*}", count(5 - power(value)), value);
    let exact = value.to_string();
    if exact.len() < shown.len() { exact } else { shown }
}

/// A p-value.
pub(super) fn probability(p: f64) -> String {
    if p < 1e-99 {
        "less than 1e-99".to_owned()
    } else if p < 1e-3 {
        format!("{p:.0e}")
    } else {
        format!("{p:.3}")
    }
}

/// What was computed and not estimated: four significant digits.
pub(super) fn computed(value: f64) -> String {
    if value.abs() > 0.0 && !PLAIN.contains(&power(value)) {
        return format!("{value:.3e}");
    }
    if value.abs() > 0.0 {
        format!("{:.*}", count(3 - power(value)), value)
    } else {
        "0".to_owned()
    }
}

/// The power of ten of the first digit, of the value rounded to two digits.
fn power(value: f64) -> i32 {
    let rounded = format!("{:.*e}", count(DIGITS_OF_STD - 1), value);
    rounded.split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0)
}

fn count(decimals: i32) -> usize {
    usize::try_from(decimals).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_ends_where_the_second_digit_of_the_std_does() {
        let written = |mean: f64, std: f64| Places::of_std(std, mean).write(mean);
        assert_eq!(written(1071.8133, 51.0312), "1072");
        assert_eq!(written(425.2628, 9.9028), "425.3");
        assert_eq!(written(-0.355_892, 0.010_677), "-0.356");
        assert_eq!(written(2755.5, 0.0234), "2755.500");
        assert_eq!(written(5.4e12, 3.2e10), "5.400e12");
        assert_eq!(written(-0.0001, 1.0), "0.0");
    }

    #[test]
    fn a_std_has_two_digits_and_never_less_than_whole_units() {
        assert_eq!(std(9.9028), "9.9");
        assert_eq!(std(51.03), "51");
        assert_eq!(std(3912.7), "3913");
        assert_eq!(std(0.0067), "0.0067");
        assert_eq!(std(0.009_97), "0.010");
        assert_eq!(std(1.24e-9), "1.2e-9");
        assert_eq!(percent(0.0233), "2.3 %");
    }

    #[test]
    fn what_was_computed_has_four_digits() {
        let written = [30.049_57, 0.229_325_5, 1234.56, 0.0, 3.2e-12].map(computed);
        assert_eq!(written, ["30.05", "0.2293", "1235", "0", "3.200e-12"]);
    }

    #[test]
    fn a_lone_value_is_short() {
        assert_eq!(value(512.0), "512");
        assert_eq!(value(465.705_776_504), "465.706");
        assert_eq!(value(-0.274_912_976), "-0.274913");
        assert_eq!(value(0.0), "0");
    }
}
