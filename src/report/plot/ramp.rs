//! Colours for numbers: from light to dark, so that black and white tell them too, and the bar that says which is which.

use super::color::{Color, GREY, INK, opaque};
use super::drawing::{Pinned, Point, Rect};
use super::frame::{exact_level_axis, level_ticks};
use super::page::{BODY, Page};

const BAR_CAPTION: f64 = 20.0;
const BAR: f64 = 11.0;
const BAR_TICKS: f64 = 22.0;
/// The height of a bar with its caption and numbers.
pub const BAR_HEIGHT: f64 = BAR_CAPTION + BAR + BAR_TICKS;

/// Colours for the numbers from 0 to a top, in steps.
#[derive(Debug, Clone, Copy)]
pub struct Ramp {
    stops: &'static [Color],
    /// More than these no one tells apart, and each makes more shapes of a map.
    steps: usize,
    /// The number of the last colour's end; what is greater has the last colour too.
    pub top: f64,
}

/// ColorBrewer's YlGnBu (C. Brewer), without the two darkest, on which ink would not be read.
const HEAT: [Color; 7] = [
    opaque(0xFF, 0xFF, 0xD9),
    opaque(0xED, 0xF8, 0xB1),
    opaque(0xC7, 0xE9, 0xB4),
    opaque(0x7F, 0xCD, 0xBB),
    opaque(0x41, 0xB6, 0xC4),
    opaque(0x1D, 0x91, 0xC0),
    opaque(0x22, 0x5E, 0xA8),
];

const GREYS: [Color; 2] = [opaque(0xF2, 0xF2, 0xF2), opaque(0x60, 0x60, 0x60)];

impl Ramp {
    pub fn heat(top: f64) -> Self {
        Self { stops: &HEAT, steps: 14, top }
    }

    pub fn greys(top: f64) -> Self {
        Self { stops: &GREYS, steps: 8, top }
    }

    /// The step of a number: equal ones look the same.
    pub fn step(&self, value: f64) -> usize {
        let reached = |step: &usize| value >= self.top * *step as f64 / self.steps as f64;
        (1..self.steps).take_while(reached).count()
    }

    pub fn color(&self, step: usize) -> Color {
        let place = step as f64 / (self.steps - 1) as f64 * (self.stops.len() - 1) as f64;
        let from = (0..self.stops.len() - 1).take_while(|&at| at as f64 <= place).count() - 1;
        self.stops[from].toward(self.stops[from + 1], place - from as f64)
    }

    /// The bar with its caption above and its numbers below, from this corner.
    pub fn bar(
        &self,
        page: &mut Page,
        (caption, unit): (&str, &str),
        [left, top]: Point,
        width: f64,
    ) {
        let axis = exact_level_axis(page.font, [0.0, self.top], width);
        let at = [left, top + 0.5 * BAR_CAPTION];
        page.drawing.text(&axis.caption(caption, unit), at, Pinned::Left, BODY, INK);
        let bar = Rect {
            left,
            top: top + BAR_CAPTION,
            right: left + width,
            bottom: top + BAR_CAPTION + BAR,
        };
        level_ticks(page, bar, &axis);
        for step in 0..self.steps {
            let x = left + width * step as f64 / self.steps as f64;
            // To the end: the next step covers the rest, and no gap shows between them.
            page.drawing.area(&Rect { left: x, ..bar }.corners(), self.color(step));
        }
        page.drawing.outline(bar, GREY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_is_darker_than_the_one_before_and_ink_stays_legible_on_all() {
        for ramp in [Ramp::heat(1.0), Ramp::greys(1.0)] {
            let lightness: Vec<f64> =
                (0..ramp.steps).map(|step| ramp.color(step).lightness()).collect();
            for pair in lightness.windows(2) {
                assert!(pair[1] < pair[0] - 1.5, "{lightness:?}");
            }
            assert!(lightness[ramp.steps - 1] > INK.lightness() + 20.0, "{lightness:?}");
        }
    }

    #[test]
    fn lightness_is_that_of_the_standard() {
        // By Python from the luminances of the sRGB primaries (IEC 61966-2-1): paper, black, and the last colour of the heat ramp.
        for (color, want) in
            [(opaque(255, 255, 255), 100.0), (opaque(0, 0, 0), 0.0), (HEAT[6], 39.867)]
        {
            assert!((color.lightness() - want).abs() < 0.01, "{}", color.lightness());
        }
    }

    #[test]
    fn numbers_have_the_step_they_lie_in() {
        let ramp = Ramp::heat(14.0);
        let steps = [0.0, 0.99, 1.0, 12.5, 13.0, 14.0, 99.0].map(|value| ramp.step(value));
        assert_eq!(steps, [0, 0, 1, 12, 13, 13, 13]);
        assert_eq!(ramp.color(0), HEAT[0]);
        assert_eq!(ramp.color(13), HEAT[6]);
    }
}
