//! An axis: where a value lies along it, and its ticks.

use super::number::{fixed, power, short, significant};

/// Values nearer to each other than this, relative to their size, are drawn as equal: f64 could not tell ticks apart.
const EQUAL: f64 = 1e-11;
/// Values smaller than this are drawn as zero: powers of ten below it leave the range of f64.
const ZERO: f64 = 1e-200;
/// How far an axis reaches either side of equal values, relative to them.
const REACH_OF_EQUAL: f64 = 1e-3;
/// What either end of the axis adds to the span of the values, so that marks do not touch the frame.
const PADDING: f64 = 0.06;
/// Past this many units of the last digit, labels are given from an offset.
const LONGEST_LABEL: f64 = 1e6;

/// An axis.
#[derive(Debug, Clone)]
pub struct Axis {
    low: f64,
    high: f64,
    pub ticks: Vec<Tick>,
    /// What labels leave out: the value is (label times the power of ten) plus this.
    offset: Option<Offset>,
    exponent: i32,
    /// Decimals of the labels.
    decimals: i32,
}

/// What labels leave out.
#[derive(Debug, Clone)]
struct Offset {
    value: f64,
    text: String,
}

/// A tick of an axis.
#[derive(Debug, Clone)]
pub struct Tick {
    /// Where it is, as [`Axis::share`].
    pub share: f64,
    pub label: String,
}

/// On which side of an axis a value lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    Below,
    Within,
    Above,
}

impl Axis {
    /// An axis over these values with at most about so many ticks.
    pub fn new([low, high]: [f64; 2], tick_count: usize) -> Self {
        let size = low.abs().max(high.abs());
        let span = (high - low).min(f64::MAX);
        let reach = match (size > ZERO, span > EQUAL * size) {
            (true, true) => PADDING * span,
            (true, false) => REACH_OF_EQUAL * size,
            (false, _) => 1.0,
        };
        Self::exact([(low - reach).max(f64::MIN), (high + reach).min(f64::MAX)], tick_count)
    }

    /// An axis from the one number to the other, greater one.
    pub fn exact([low, high]: [f64; 2], tick_count: usize) -> Self {
        let mut axis =
            Self { low, high, ticks: Vec::new(), offset: None, exponent: 0, decimals: 0 };
        axis.place_ticks(tick_count);
        axis
    }

    /// An axis of so many decades: where a value lies goes by its logarithm to the base of ten.
    pub fn of_decades([low, high]: [f64; 2], tick_count: usize) -> Self {
        let ticks_of = |multiples: &[f64]| {
            let mut ticks = Vec::new();
            for exponent in decimal_exponent(low)..=decimal_exponent(high) {
                let at = multiples.iter().map(|times| decimal_number(*times, exponent));
                ticks.extend(at.filter(|value| (low..=high).contains(value)));
            }
            ticks
        };
        let fitting = [&[1.0, 2.0, 5.0][..], &[1.0, 3.0], &[1.0]].map(ticks_of);
        let fits = |ticks: &&Vec<f64>| ticks.len() <= tick_count;
        let values = fitting.iter().find(fits).unwrap_or(&fitting[2]);
        let (first, last) = (low.log10(), high.log10());
        let tick = |value: &f64| Tick {
            share: (value.log10() - first) / (last - first),
            label: short(*value),
        };
        let ticks = values.iter().map(tick).collect();
        Self { low: first, high: last, ticks, offset: None, exponent: 0, decimals: 0 }
    }

    /// The same axis, its low end up: image rows count down.
    pub fn downwards(mut self) -> Self {
        self.ticks.iter_mut().for_each(|tick| tick.share = 1.0 - tick.share);
        self
    }

    /// An axis over the positions 1 to `count`, ticks at whole ones.
    pub fn of_positions(count: usize, tick_count: usize) -> Self {
        let last = u32::try_from(count).map_or(f64::from(u32::MAX), f64::from);
        let mut axis = Self {
            low: 0.5,
            high: last + 0.5,
            ticks: Vec::new(),
            offset: None,
            exponent: 0,
            decimals: 0,
        };
        let step = nice_step(last / count_of(tick_count)).0.max(1.0);
        let mut at = step;
        while at <= last {
            axis.ticks.push(Tick { share: axis.share(at), label: fixed(at, 0) });
            at += step;
        }
        axis
    }

    /// Where a value lies: 0 at the low end, 1 at the high end, beyond them less or more.
    pub fn share(&self, value: f64) -> f64 {
        // In halves: the span of two finite numbers may not be finite.
        (value / 2.0 - self.low / 2.0) / (self.high / 2.0 - self.low / 2.0)
    }

    /// On which side of the axis a value lies.
    pub fn side(&self, value: f64) -> Side {
        if value < self.low {
            Side::Below
        } else if value > self.high {
            Side::Above
        } else {
            Side::Within
        }
    }

    /// What the axis shows, and in which unit its labels are.
    pub fn caption(&self, name: &str, unit: &str) -> String {
        let quantity = match &self.offset {
            Some(Offset { text, .. }) => match text.strip_prefix('−') {
                Some(size) => format!("{name} + {size}"),
                None => format!("{name} − {text}"),
            },
            None => name.to_owned(),
        };
        match (self.exponent, unit) {
            (0, "") => quantity,
            (0, unit) => format!("{quantity} [{unit}]"),
            (exponent, "") => format!("{quantity} [{}]", power(exponent)),
            (exponent, unit) => format!("{quantity} [{} {unit}]", power(exponent)),
        }
    }

    /// A value in the unit of the labels, with few digits, but enough to tell it from the ends of the axis.
    pub fn label(&self, value: f64) -> String {
        let offset = self.offset.as_ref().map_or(0.0, |offset| offset.value);
        let value = (value - offset) / power_of_ten(self.exponent);
        let digits = decimal_exponent(value) + 1 + self.decimals;
        // More than nine would tell it from an end so far away that four do.
        let digits = if digits > 9 { 4 } else { digits.max(4) };
        significant(value, usize::try_from(digits).unwrap_or(4))
    }

    fn place_ticks(&mut self, tick_count: usize) {
        let raw = self.high / count_of(tick_count) - self.low / count_of(tick_count);
        let (step, exponent) = nice_step(raw);
        let (first, last) = ((self.low / step).ceil(), (self.high / step).floor());
        // Ticks are whole multiples of 10^exponent, so that no label shows the noise of a sum.
        let multiple = (step / power_of_ten(exponent)).round();
        let offset = if (first.abs().max(last.abs()) * multiple) >= LONGEST_LABEL {
            (first * multiple / 1e3).round() * 1e3
        } else {
            0.0
        };
        if offset.abs() > 0.0 {
            self.offset = Some(Offset {
                value: offset * power_of_ten(exponent),
                text: digits(offset, exponent),
            });
        }
        let largest = (first * multiple - offset).abs().max((last * multiple - offset).abs());
        self.exponent = label_exponent(largest, exponent);
        self.decimals = (self.exponent - exponent).max(0);
        let mut index = first;
        while index <= last {
            let label = shifted(index * multiple - offset, exponent - self.exponent);
            self.ticks.push(Tick { share: self.share(index * step), label });
            index += 1.0;
        }
    }
}

/// The step of 1, 2 or 5 times a power of ten at or above this, and that power.
pub fn nice_step(raw: f64) -> (f64, i32) {
    let mut exponent = decimal_exponent(raw);
    let unit = power_of_ten(exponent);
    let multiple = [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * unit >= raw).unwrap_or(10.0);
    if multiple > 5.0 {
        exponent += 1;
    }
    (multiple * unit, exponent)
}

/// The power of ten that labels leave out: none, or a multiple of three that keeps them between 1 and 1000.
fn label_exponent(largest: f64, exponent: i32) -> i32 {
    let top = decimal_exponent(largest.max(1.0)) + exponent;
    if (-2..5).contains(&top) { 0 } else { top.div_euclid(3) * 3 }
}

/// The power of ten at or below this positive number.
pub fn decimal_exponent(value: f64) -> i32 {
    // By its decimal text: log10 errs near powers of ten.
    format!("{value:e}").rsplit('e').next().and_then(|text| text.parse().ok()).unwrap_or(0)
}

pub fn power_of_ten(exponent: i32) -> f64 {
    decimal_number(1.0, exponent)
}

/// A few digits times a power of ten: the number of that text, whose own text is as short.
pub fn decimal_number(digits: f64, exponent: i32) -> f64 {
    format!("{digits}e{exponent}").parse().unwrap_or(f64::NAN)
}

/// `whole` times 10^`exponent`, in digits.
fn shifted(whole: f64, exponent: i32) -> String {
    match usize::try_from(-exponent) {
        Ok(decimals) => fixed(whole / power_of_ten(-exponent), decimals),
        Err(_) => fixed(whole * power_of_ten(exponent), 0),
    }
}

/// A whole multiple of 10^`exponent`, with as many digits as it has.
fn digits(whole: f64, exponent: i32) -> String {
    let text = format!("{whole:e}");
    let mantissa = text.split('e').next().unwrap_or(&text);
    let count = mantissa.chars().filter(char::is_ascii_digit).count();
    significant(whole * power_of_ten(exponent), count)
}

fn count_of(tick_count: usize) -> f64 {
    u32::try_from(tick_count.max(1)).map_or(1.0, f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(span: [f64; 2], count: usize) -> (String, Vec<String>) {
        let axis = Axis::new(span, count);
        (axis.caption("k", "px"), axis.ticks.iter().map(|tick| tick.label.clone()).collect())
    }

    #[test]
    fn labels_have_the_digits_that_tell_them_apart_and_no_more() {
        assert_eq!(labels([461.9, 465.8], 5).1, ["462", "463", "464", "465", "466"]);
        assert_eq!(labels([-0.12, 0.23], 4).1, ["−0.1", "0.0", "0.1", "0.2"]);
    }

    #[test]
    fn powers_of_ten_and_long_common_parts_move_to_the_caption() {
        assert_eq!(
            labels([0.0008, 0.0018], 3),
            ("k [10⁻³ px]".to_owned(), ["1.0", "1.5"].map(str::to_owned).to_vec())
        );
        assert_eq!(labels([1e9, 2e9], 3).0, "k [10⁹ px]");
        let (caption, labels) = labels([2755.44001, 2755.44003], 3);
        assert_eq!(caption, "k − 2755.44 [10⁻⁶ px]");
        assert_eq!(labels, ["10", "20", "30"]);
    }

    #[test]
    fn a_label_read_with_its_caption_is_the_value() {
        // 2755.44 + 25e-6
        assert_eq!(Axis::new([2755.44001, 2755.44003], 3).label(2755.440025), "25.00");
        assert_eq!(Axis::new([0.0008, 0.0018], 3).label(-0.0176), "−17.60");
        // Four digits, -123.5, would seem to lie at the other end.
        assert_eq!(Axis::new([-123459.0, -123456.0], 4).label(-123450.0), "−123.450");
    }

    #[test]
    fn equal_values_stand_in_the_middle_of_an_axis_that_has_ticks() {
        for value in [465.25, 0.0, -1e9, 1e-6, 1e-300, 1e300] {
            let axis = Axis::new([value, value], 4);
            assert!((axis.share(value) - 0.5).abs() < 1e-6, "{value}: {}", axis.share(value));
            assert!(axis.ticks.len() >= 2, "{value}: {:?}", axis.ticks);
        }
    }

    #[test]
    fn the_whole_range_of_f64_is_an_axis() {
        let axis = Axis::new([f64::MIN, f64::MAX], 5);
        assert!(
            axis.ticks.len() >= 3
                && axis.ticks.iter().all(|tick| (0.0..=1.0).contains(&tick.share))
        );
    }

    #[test]
    fn decades_have_round_ticks_where_their_logarithms_are() {
        let axis = Axis::of_decades([0.08, 90.0], 8);
        let labels: Vec<&str> = axis.ticks.iter().map(|tick| tick.label.as_str()).collect();
        assert_eq!(labels, ["0.1", "0.3", "1", "3", "10", "30"]);
        // log(1 / 0.08) / log(90 / 0.08)
        assert!((axis.ticks[2].share - 0.359_506_8).abs() < 1e-6, "{}", axis.ticks[2].share);
        assert!((axis.share(0.0) - axis.ticks[2].share).abs() < 1e-15);
    }

    #[test]
    fn an_axis_turned_down_begins_at_the_top() {
        let ticks = Axis::exact([0.0, 400.0], 4).downwards().ticks;
        assert_eq!((ticks[0].label.as_str(), ticks[0].share > 0.999), ("0", true));
    }

    #[test]
    fn runs_are_counted_in_whole_numbers() {
        let labels = |count, ticks| -> Vec<String> {
            Axis::of_positions(count, ticks).ticks.iter().map(|tick| tick.label.clone()).collect()
        };
        assert_eq!(labels(3, 7), ["1", "2", "3"]);
        assert_eq!(labels(1000, 5), ["200", "400", "600", "800", "1000"]);
    }
}
