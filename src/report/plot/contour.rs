//! Lines of equal height through a map, by marching squares.
//!
//! Knows nothing of pages: points are counted in cells, (0.5, 0.5) the middle of the first one.

use std::collections::BTreeMap;

use super::axis::{decimal_exponent, decimal_number, nice_step, power_of_ten};
use super::drawing::Point;
use super::number::short;

/// A map whose values range over less than this factor has levels evenly spaced, else by ratio: 1, 2, 5, 10.
const EVEN: f64 = 8.0;
/// Levels lower than this share of the greatest value crowd where nothing happens.
const LEAST: f64 = 0.05;
/// Values nearer to each other than this are equal, and lines between them are noise.
const FLAT: f64 = 1e-6;

/// The heights at which lines are drawn through values of this range: about half a dozen round ones, with their labels.
pub fn levels([low, high]: [f64; 2]) -> Vec<(f64, String)> {
    if !high.is_finite() || high - low <= FLAT * high {
        return Vec::new();
    }
    let is_even = high < EVEN * low;
    let mut found = Vec::new();
    if is_even {
        let (step, exponent) = nice_step((high - low) / 5.0);
        let multiple = (step / power_of_ten(exponent)).round();
        let mut index = (low / step).floor();
        while index * step < high {
            found.push(decimal(index * multiple, exponent));
            index += 1.0;
        }
    } else {
        let top = decimal_exponent(high);
        for exponent in top - 2..=top {
            found.extend([1.0, 2.0, 5.0].map(|times| decimal(times, exponent)));
        }
    }
    let least = low.max(if is_even { 0.0 } else { LEAST * high });
    found.retain(|(level, _)| *level > least && *level < high);
    found
}

/// `whole` times 10^`exponent` as the nearest number, whose shortest digits are its label.
fn decimal(whole: f64, exponent: i32) -> (f64, String) {
    let value = decimal_number(whole, exponent);
    (value, short(value))
}

/// An edge between the middles of two neighbouring cells: that of this column and row, and the next one to the right or below.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Edge {
    Right(usize, usize),
    Below(usize, usize),
}

/// The lines of this height through a map of so many columns; they end where the map does. Closed ones end where they begin.
pub fn contours(map: &[Option<f64>], columns: usize, level: f64) -> Vec<Vec<Point>> {
    let rows = map.len() / columns;
    let mut joined: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
    for row in 0..rows.saturating_sub(1) {
        for column in 0..columns.saturating_sub(1) {
            for [from, to] in segments(map, columns, [column, row], level) {
                joined.entry(from).or_default().push(to);
                joined.entry(to).or_default().push(from);
            }
        }
    }
    let mut lines = Vec::new();
    // Open lines from an end first; what is left is closed.
    for most in [1, 2] {
        while let Some(start) =
            joined.iter().find(|(_, next)| (1..=most).contains(&next.len())).map(|(at, _)| *at)
        {
            lines.push(line(map, columns, level, follow(&mut joined, start)));
        }
    }
    lines
}

/// The edges from this one on, taken out.
fn follow(joined: &mut BTreeMap<Edge, Vec<Edge>>, start: Edge) -> Vec<Edge> {
    let mut edges = vec![start];
    let mut at = start;
    while let Some(next) = joined.get_mut(&at).and_then(Vec::pop) {
        let back = joined.entry(next).or_default();
        if let Some(place) = back.iter().position(|edge| *edge == at) {
            back.swap_remove(place);
        }
        edges.push(next);
        at = next;
    }
    edges
}

fn line(map: &[Option<f64>], columns: usize, level: f64, edges: Vec<Edge>) -> Vec<Point> {
    let crossing = |edge: Edge| {
        let (column, row, step) = match edge {
            Edge::Right(column, row) => (column, row, [1, 0]),
            Edge::Below(column, row) => (column, row, [0, 1]),
        };
        let from = map[row * columns + column]?;
        let to = map[(row + step[1]) * columns + column + step[0]]?;
        let share = (level - from) / (to - from);
        let [dx, dy] = step.map(|step| step as f64 * share);
        Some([column as f64 + 0.5 + dx, row as f64 + 0.5 + dy])
    };
    edges.into_iter().filter_map(crossing).collect()
}

/// How the line passes between the middles of four cells; not at all where one has no value.
fn segments(
    map: &[Option<f64>],
    columns: usize,
    [column, row]: [usize; 2],
    level: f64,
) -> Vec<[Edge; 2]> {
    let at = |right: usize, below: usize| map[(row + below) * columns + column + right];
    let (Some(a), Some(b), Some(c), Some(d)) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1)) else {
        return Vec::new();
    };
    let [top, right] = [Edge::Right(column, row), Edge::Below(column + 1, row)];
    let [bottom, left] = [Edge::Right(column, row + 1), Edge::Below(column, row)];
    let is_centre_high = (a + b + c + d) / 4.0 >= level;
    match [a, b, c, d].map(|value| value >= level) {
        [true, true, true, true] | [false, false, false, false] => Vec::new(),
        [true, false, false, false] | [false, true, true, true] => vec![[top, left]],
        [false, true, false, false] | [true, false, true, true] => vec![[top, right]],
        [false, false, true, false] | [true, true, false, true] => vec![[right, bottom]],
        [false, false, false, true] | [true, true, true, false] => vec![[bottom, left]],
        [true, true, false, false] | [false, false, true, true] => vec![[left, right]],
        [true, false, false, true] | [false, true, true, false] => vec![[top, bottom]],
        // Two opposite corners are high: the middle says whether they are joined.
        [is_first_high, _, _, _] if is_first_high == is_centre_high => {
            vec![[top, right], [bottom, left]]
        }
        _ => vec![[top, left], [right, bottom]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(height: impl Fn(f64, f64) -> Option<f64>) -> Vec<Option<f64>> {
        let middle = |index: u8| f64::from(index) + 0.5;
        (0..30)
            .flat_map(|y| (0..40).map(move |x| [x, y]))
            .map(|at| {
                let [x, y] = at.map(middle);
                height(x, y)
            })
            .collect()
    }

    #[test]
    fn a_cone_has_closed_circles_of_its_radius() {
        let cone = map(|x, y| Some((x - 20.0).hypot(y - 15.0)));
        for radius in [3.0, 7.0, 12.0] {
            let found = contours(&cone, 40, radius);
            assert_eq!(found.len(), 1);
            let (first, last) = (found[0][0], found[0][found[0].len() - 1]);
            assert!((first[0] - last[0]).hypot(first[1] - last[1]) < 1e-12);
            assert!(found[0].len() > 12);
            for [x, y] in &found[0] {
                // A chord of one cell is off a circle by 1 / (8 radius) at most.
                assert!(((x - 20.0).hypot(y - 15.0) - radius).abs() < 0.125 / radius + 1e-12);
            }
        }
    }

    #[test]
    fn a_plane_has_a_straight_line_from_end_to_end_and_none_where_it_has_no_value() {
        let plane = map(|x, y| Some(x + 2.0 * y));
        let found = contours(&plane, 40, 31.3);
        assert_eq!(found.len(), 1);
        assert!(found[0].iter().all(|[x, y]| (x + 2.0 * y - 31.3).abs() < 1e-12));
        let [first, last] = [found[0][0], found[0][found[0].len() - 1]];
        assert!((first[0] - last[0]).abs() > 28.0, "{first:?} {last:?}");
        let holed = map(|x, y| (!(15.0..18.0).contains(&x)).then_some(x + 2.0 * y));
        let found = contours(&holed, 40, 31.3);
        assert_eq!(found.len(), 2);
        assert!(found.iter().flatten().all(|[x, _]| *x <= 14.5 || *x >= 18.5));
    }

    #[test]
    fn a_saddle_has_two_lines_that_do_not_cross() {
        let saddle = map(|x, y| Some((x - 20.0) * (y - 15.0)));
        for level in [-0.1, 0.1] {
            let found = contours(&saddle, 40, level);
            assert_eq!(found.len(), 2, "{level}");
            let is_right = |line: &[Point]| line.iter().all(|[x, _]| *x > 19.5);
            assert_ne!(is_right(&found[0]), is_right(&found[1]));
        }
    }

    #[test]
    fn levels_are_round_and_lie_within() {
        let labels =
            |range| -> Vec<String> { levels(range).into_iter().map(|(_, label)| label).collect() };
        assert_eq!(labels([0.01, 3.0]), ["0.2", "0.5", "1", "2"]);
        assert_eq!(labels([0.0, 120.0]), ["10", "20", "50", "100"]);
        assert_eq!(labels([0.31, 0.52]), ["0.35", "0.4", "0.45", "0.5"]);
        assert_eq!(labels([17.0, 17.0]), [""; 0]);
        assert_eq!(labels([0.0, 0.0]), [""; 0]);
        assert_eq!(labels([1.0, f64::NAN]), [""; 0]);
    }
}
