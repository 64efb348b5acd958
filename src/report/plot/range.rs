//! Which part of the number line a plot shows.
//!
//! One wild value must not press all others into a line; it is drawn at the border, as an arrow with its number.

/// Values further than so many interquartile ranges from the middle half of all are left to the border. Of a normal
/// distribution that is 1 in 10^13: what goes there is of another kind.
const REACH: f64 = 5.0;

/// Fewer values than this have no middle half worth the name: of four, two near ones would banish the others.
const ENOUGH: usize = 6;

/// The span of an axis for these values, wide enough for these intervals (boxes with their whiskers) in any case.
/// None without a value.
pub fn span(values: &[f64], intervals: &[[f64; 2]]) -> Option<[f64; 2]> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    // Order statistics, not quantiles: this only chooses a view.
    let quarter = sorted.len() / 4;
    let (low, high) = (*sorted.get(quarter)?, *sorted.get(sorted.len() - 1 - quarter)?);
    let reach = REACH * (high - low);
    // Half of the values may be one number: no scale to call others far.
    let has_scale = reach > 0.0 && sorted.len() >= ENOUGH;
    let is_near = |value: &f64| !has_scale || (*value >= low - reach && *value <= high + reach);
    let shown = sorted.iter().copied().filter(is_near).chain(intervals.iter().flatten().copied());
    Some(shown.fold([low, high], |[low, high], value| [low.min(value), high.max(value)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wild_value_does_not_widen_the_view_and_a_far_box_does() {
        let values = [464.0, 465.0, 465.5, 466.0, 467.0, 149.0];
        assert_eq!(span(&values, &[]), Some([464.0, 467.0]));
        assert_eq!(span(&values, &[[150.0, 160.0]]), Some([150.0, 467.0]));
    }

    #[test]
    fn two_clusters_are_both_in_view() {
        let values = [464.0, 465.0, 465.5, 466.0, 149.0, 150.0, 151.0, 152.0];
        assert_eq!(span(&values, &[]), Some([149.0, 466.0]));
    }

    #[test]
    fn where_most_values_are_equal_all_are_in_view() {
        assert_eq!(span(&[1.0, 1.0, 1.0, 1.0, 1.0, 9.0], &[]), Some([1.0, 9.0]));
    }

    #[test]
    fn of_few_values_all_are_in_view() {
        assert_eq!(span(&[1.229, 1.335, -2.218, 2.56], &[]), Some([-2.218, 2.56]));
    }

    #[test]
    fn no_value_no_view() {
        assert_eq!(span(&[], &[]), None);
    }
}
