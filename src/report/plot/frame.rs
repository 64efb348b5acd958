//! The frame of a plot: its borders, guides, ticks and their labels.

use super::axis::Axis;
use super::color::{GREY, GUIDE};
use super::drawing::{Pinned, Rect};
use super::font::Font;
use super::page::{Page, SMALL};

const TICK: f64 = 4.0;
/// From the frame to the middle of a label below it.
const LABEL_BELOW: f64 = 13.0;
/// From the frame to the end of a label left of it.
const LABEL_LEFT: f64 = 7.0;
/// Least gap between neighbouring labels below a plot.
const LABEL_GAP: f64 = 14.0;
/// Least distance of ticks one above the other.
const ROW_GAP: f64 = 24.0;

/// A level axis over this span, as many ticks as their labels leave room for.
pub fn level_axis(font: &Font, span: [f64; 2], width: f64) -> Axis {
    fitting(width, font, |count| Axis::new(span, count))
}

/// A level axis from the one number to the other.
pub fn exact_level_axis(font: &Font, ends: [f64; 2], width: f64) -> Axis {
    fitting(width, font, |count| Axis::exact(ends, count))
}

/// A level axis over positions of runs.
pub fn run_axis(font: &Font, count: usize, width: f64) -> Axis {
    fitting(width, font, |ticks| Axis::of_positions(count, ticks))
}

/// An upright axis over this span.
pub fn upright_axis(span: [f64; 2], height: f64) -> Axis {
    Axis::new(span, upright_tick_count(height))
}

/// As many ticks as an upright axis has room for.
pub fn upright_tick_count(height: f64) -> usize {
    (2..=8).rev().find(|&count| count as f64 * ROW_GAP <= height).unwrap_or(2)
}

fn fitting(width: f64, font: &Font, axis_with: impl Fn(usize) -> Axis) -> Axis {
    let fits = |axis: &Axis| {
        let widest = label_width(axis, font) + LABEL_GAP;
        axis.ticks.windows(2).all(|pair| (pair[1].share - pair[0].share) * width >= widest)
    };
    (2..=7).rev().map(&axis_with).find(fits).unwrap_or_else(|| axis_with(1))
}

/// The width of the widest label of an axis.
pub fn label_width(axis: &Axis, font: &Font) -> f64 {
    axis.ticks.iter().map(|tick| font.width(&tick.label, SMALL)).fold(0.0, f64::max)
}

/// The room that the labels of an upright axis need left of its plot.
pub fn left_room(axis: &Axis, font: &Font) -> f64 {
    label_width(axis, font) + LABEL_LEFT
}

/// Guides, ticks and labels of a level axis.
pub fn level_ticks(page: &mut Page, plot: Rect, axis: &Axis) {
    for tick in &axis.ticks {
        let x = plot.left + tick.share * (plot.right - plot.left);
        page.drawing.hairline([x, plot.top], [x, plot.bottom], GUIDE);
        page.drawing.hairline([x, plot.bottom], [x, plot.bottom + TICK], GREY);
        page.drawing.text(&tick.label, [x, plot.bottom + LABEL_BELOW], Pinned::Center, SMALL, GREY);
    }
    page.drawing.hairline([plot.left, plot.bottom], [plot.right, plot.bottom], GREY);
}

/// Guides and labels of an upright axis.
pub fn upright_ticks(page: &mut Page, plot: Rect, axis: &Axis) {
    for tick in &axis.ticks {
        let y = plot.bottom - tick.share * (plot.bottom - plot.top);
        page.drawing.hairline([plot.left, y], [plot.right, y], GUIDE);
        page.drawing.text(&tick.label, [plot.left - LABEL_LEFT, y], Pinned::Right, SMALL, GREY);
    }
    page.drawing.hairline([plot.left, plot.top], [plot.left, plot.bottom], GREY);
}
