//! From where the images were taken, and how often each heuristic chose each: a panel a heuristic.

use super::choices::Choices;
use super::color::GREY;
use super::drawing::{Drawing, Point, Rect};
use super::font::Font;
use super::page::MARGIN;
use super::panels::Panels;
use super::ramp::{BAR_HEIGHT, Ramp};
use crate::selection::experiment::Cell;

const WIDTH: f64 = 240.0;
/// A path along a line is drawn in a band of this share of the width, and none is higher than wide.
const LOWEST: f64 = 0.35;
const INSET: f64 = 10.0;
const RADIUS: f64 = 4.2;

/// None where nothing was chosen.
pub fn draw(choices: &Choices<'_>, font: &Font) -> Option<Drawing> {
    let Choices { model, size, .. } = choices;
    let cells: Vec<&Cell> = choices.cells().collect();
    let most =
        cells.iter().flat_map(|cell| &cell.chosen).copied().max().filter(|&most| most > 0)?;
    let ramp = Ramp::heat(most as f64);
    let ends = |axis: usize| {
        let along = model.map.iter().map(|place| place[axis]);
        [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
    };
    let [across, up] = [ends(0), ends(1)];
    let span = (across[1] - across[0]).max(f64::MIN_POSITIVE);
    let height = WIDTH * ((up[1] - up[0]) / span).clamp(LOWEST, 1.0);
    let scale = (WIDTH - 2.0 * INSET) / span;
    let scale = scale.min((height - 2.0 * INSET) / (up[1] - up[0]).max(f64::MIN_POSITIVE));
    let captions: Vec<String> = cells.iter().map(|cell| cell.heuristic.clone()).collect();
    let panels = Panels {
        title: &format!("{}Which images were chosen, {size} at a time", choices.of_model()),
        subtitle: "Places of the cameras along the two directions in which they differ most",
        captions: &captions,
        size: [WIDTH, height],
    };
    let panel = |page: &mut super::page::Page, at: usize, [left, top]: Point| {
        let frame = Rect { left, top, right: left + WIDTH, bottom: top + height };
        page.drawing.outline(frame, GREY.faded(0.5));
        let middle = [across, up].map(|[low, high]| 0.5 * (low + high));
        // Those chosen most often lie over the others.
        let mut order: Vec<usize> = (0..model.map.len()).collect();
        order.sort_by_key(|&image| cells[at].chosen[image]);
        for image in order {
            let [x, y] = model.map[image];
            let place = [
                left + 0.5 * WIDTH + scale * (x - middle[0]),
                top + 0.5 * height - scale * (y - middle[1]),
            ];
            match cells[at].chosen[image] {
                0 => page.drawing.disc(place, 0.4 * RADIUS, GREY.faded(0.6)),
                times => {
                    page.drawing.disc(place, RADIUS + 0.7, GREY);
                    page.drawing.disc(place, RADIUS, ramp.color(ramp.step(times as f64)));
                }
            }
        }
    };
    let notes = [
        "A small grey dot is an image that was never chosen. Pools differ between repeats: none can be chosen every time.".to_owned(),
    ];
    let below = |page: &mut super::page::Page| {
        ramp.bar(page, ("times chosen", ""), [MARGIN, page.y], WIDTH);
        page.y += BAR_HEIGHT + 8.0;
    };
    Some(panels.draw(font, panel, below, &notes))
}
