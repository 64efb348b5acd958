//! The error of each heuristic by the number of images it chose, with intervals: a panel a model.

use super::axis::Axis;
use super::color::{GREY, INK};
use super::columns::{Columns, PanelWidth};
use super::drawing::{Drawing, Pinned, Point, Rect};
use super::font::{Font, clean};
use super::frame::{exact_level_axis, left_room, level_ticks, upright_tick_count, upright_ticks};
use super::legend::{Sample, legend};
use super::marker::{Style, dashed};
use super::page::{BODY, Page, SMALL};
use crate::selection::experiment::{Cell, Selection};

const PLOT_WIDTHS: [f64; 2] = [560.0, 420.0];
const PLOT_HEIGHT: f64 = 340.0;
const CAPTION_HEIGHT: f64 = 24.0;
const TICKS_HEIGHT: f64 = 22.0;
const AXIS_NAME_HEIGHT: f64 = 20.0;
const COLUMN_GAP: f64 = 26.0;
const PANEL_GAP: f64 = 14.0;
/// How far the intervals of neighbouring heuristics stand apart, in px: else they would hide each other.
const ASIDE: f64 = 3.0;

/// The figure; none where no heuristic gave calibrations.
pub fn draw(selection: &Selection, font: &Font) -> Option<Drawing> {
    let heights = heights(selection)?;
    let names: Vec<String> =
        selection.options.heuristics.iter().map(|(name, _)| name.clone()).collect();
    let styles: Vec<Style> = (0..names.len()).map(Style::of_group).collect();
    let width =
        PanelWidth { left: left_room(&heights, font), plot: PLOT_WIDTHS, right: COLUMN_GAP };
    let columns = Columns::new(selection.models.len(), 0.0, &width);
    let subtitle = "RMS error (bias and spread together) with its 95 % interval";
    let mut page = Page::new(font, columns.page_width, "Error by number of images", subtitle);
    legend(&mut page, &names, &styles, Sample::MarkerOnLine);
    for (line, models) in selection.models.chunks(columns.lefts.len()).enumerate() {
        let top = page.y + CAPTION_HEIGHT;
        for (place, (model, &left)) in models.iter().zip(&columns.lefts).enumerate() {
            let right = left + columns.plot_width;
            let plot = Rect { left, top, right, bottom: top + PLOT_HEIGHT };
            let at = [left, top - 0.5 * CAPTION_HEIGHT - 1.0];
            let caption = format!("{}: error [px]", clean(&model.name));
            let caption = font.shorten(&caption, BODY, columns.plot_width);
            page.drawing.text(&caption, at, Pinned::Left, BODY, INK);
            let index = line * columns.lefts.len() + place;
            panel(&mut page, plot, (selection, index), &heights, &styles);
        }
        page.y = top + PLOT_HEIGHT + TICKS_HEIGHT + AXIS_NAME_HEIGHT + PANEL_GAP;
    }
    Some(page.finish(&["The axis of the error goes by ratio.".to_owned()]))
}

/// One axis for all panels, by ratio.
fn heights(selection: &Selection) -> Option<Axis> {
    let ends = selection.cells.iter().flat_map(|cell| {
        let error = cell.error.map(|error| error.rms_px);
        error.into_iter().chain(cell.interval_95.into_iter().flatten())
    });
    let positive: Vec<f64> = ends.filter(|px| *px > 0.0).collect();
    let high = positive.iter().copied().reduce(f64::max)?;
    let low = positive.iter().copied().reduce(f64::min)?;
    Some(Axis::of_decades([low / 1.1, 1.1 * high], upright_tick_count(PLOT_HEIGHT)))
}

fn panel(
    page: &mut Page,
    plot: Rect,
    (selection, model): (&Selection, usize),
    heights: &Axis,
    styles: &[Style],
) {
    let sizes = || selection.options.sizes.iter().map(|&size| size as f64);
    let (first, last) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max));
    let beyond = 0.08 * (last - first).max(1.0);
    let widths =
        exact_level_axis(page.font, [first - beyond, last + beyond], plot.right - plot.left);
    level_ticks(page, plot, &widths);
    upright_ticks(page, plot, heights);
    let below = plot.bottom + TICKS_HEIGHT + 0.5 * AXIS_NAME_HEIGHT;
    let unit = if selection.options.unit == "frame" { "frames" } else { "images" };
    let at = [0.5 * (plot.left + plot.right), below];
    page.drawing.text(unit, at, Pinned::Center, SMALL, GREY);
    let middle = 0.5 * (styles.len() as f64 - 1.0);
    let x = |size: usize, at: usize| {
        let aside = ASIDE * (at as f64 - middle);
        plot.left + widths.share(size as f64) * (plot.right - plot.left) + aside
    };
    let y = |px: f64| plot.bottom - heights.share(px.log10()) * (plot.bottom - plot.top);
    for ((at, style), (name, _)) in styles.iter().enumerate().zip(&selection.options.heuristics) {
        let own = selection.cells.iter().filter(|it| it.model == model && it.heuristic == *name);
        let known = own.filter_map(|it| Some((it, it.error?.rms_px)));
        let known: Vec<(&Cell, f64)> = known.filter(|(_, px)| *px > 0.0).collect();
        for (cell, _) in &known {
            if let Some([low, high]) = cell.interval_95 {
                let ends = [[x(cell.size, at), y(low)], [x(cell.size, at), y(high)]];
                page.drawing.line(&ends, style.color.faded(0.55), 1.0);
            }
        }
        let points: Vec<Point> =
            known.iter().map(|(cell, px)| [x(cell.size, at), y(*px)]).collect();
        if points.len() > 1 {
            dashed(&mut page.drawing, &points, style, 1.4);
        }
        for at in points {
            style.marker.draw(&mut page.drawing, at, 3.2, style.color);
        }
    }
}
