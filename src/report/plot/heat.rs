//! The spread over the image: as the calibrations are, turned, turned and moved; and where the runs observed.

use super::color::{GREY, INK, PAPER};
use super::columns::{Columns, PanelWidth};
use super::contour::{contours, levels};
use super::drawing::{Drawing, Pinned, Point, Rect};
use super::font::Font;
use super::number::significant;
use super::page::{BODY, Page, SMALL};
use super::plane::{BELOW, Placed, Plane};
use super::ramp::{BAR_HEIGHT, Ramp};
use super::spreads::{SpreadOf, Spreads};
use crate::stability::spread::{Spread, SpreadMeasure};

const PLOT_WIDTHS: [f64; 2] = [380.0, 380.0];
const COLUMN_GAP: f64 = 26.0;
const HEADING_HEIGHT: f64 = 22.0;
const CAPTION_HEIGHT: f64 = 22.0;
const ROW_GAP: f64 = 6.0;
const GROUP_GAP: f64 = 22.0;
/// A few corner cells must not press all others into the lightest colour: beyond this many times what 95 % of the cells stay below, all
/// look the same.
const TALLEST: f64 = 1.5;
/// The same for what the runs show as they are, as a multiple of what they do turned.
const RAW_TALLEST: f64 = 2.0;

/// The figure; none without a spread.
pub fn draw(spreads: &Spreads, font: &Font) -> Option<Drawing> {
    let first = spreads.members.first()?;
    let plane = Plane::new(font, spreads.size, first.spread.grid(), PLOT_WIDTHS[1]);
    let width = PanelWidth { left: plane.left_room(font), plot: PLOT_WIDTHS, right: COLUMN_GAP };
    let columns = Columns::new(2, 0.0, &width);
    let subtitle = "Spread of the runs over the image, lines in px";
    let mut page = Page::new(font, columns.page_width, &spreads.camera, subtitle);
    let mut notes = Notes::default();
    for member in &spreads.members {
        group(&mut page, member, &plane, &columns.lefts, &mut notes);
    }
    Some(page.finish(&[&notes.sentences()[..], &spreads.runs_in_words].concat()))
}

/// What is on the page and wants a word.
#[derive(Default)]
struct Notes {
    has_outside: bool,
    has_mask: bool,
    beyond: Vec<String>,
}

impl Notes {
    fn sentences(self) -> Vec<String> {
        let mut told = Vec::new();
        if self.has_outside {
            told.push("White: outside the region that is compared; on the map of observations its border is drawn.".to_owned());
        }
        if self.has_mask {
            told.push("Hatched: in the region, but a run has no ray there.".to_owned());
        }
        told.extend(self.beyond);
        told
    }
}

fn group(page: &mut Page, member: &SpreadOf, plane: &Plane, lefts: &[f64], notes: &mut Notes) {
    let spread = member.spread;
    page.drawing.text(
        &member.heading(),
        [lefts[0], page.y + 0.5 * HEADING_HEIGHT],
        Pinned::Left,
        BODY,
        INK,
    );
    page.y += HEADING_HEIGHT;
    let mut maps = vec![("as they are", &spread.raw), ("turned", &spread.rotated)];
    maps.extend(spread.moved.as_ref().map(|moved| ("turned and moved", &moved.measure)));
    let ramp = Ramp::heat(top(&maps));
    let observations = Observations::of(spread);
    let panel_count = maps.len() + usize::from(observations.is_some());
    let row_height = CAPTION_HEIGHT + plane.height + BELOW + ROW_GAP;
    let corner = |index: usize| {
        [lefts[index % 2], page.y + CAPTION_HEIGHT + row_height * (index / 2) as f64]
    };
    let places: Vec<Placed> = (0..panel_count).map(|index| plane.placed(corner(index))).collect();
    for ((name, measure), place) in maps.iter().zip(&places) {
        map(page, place, spread, (name, measure), &ramp);
    }
    if let Some((observations, place)) = observations.as_ref().zip(places.last()) {
        observations.draw(page, place, spread);
    }
    page.y += row_height * panel_count.div_ceil(2) as f64;
    ramp.bar(page, ("spread", "px"), [lefts[0], page.y], plane.width);
    if let Some(observations) = &observations {
        let caption = "observations in a cell, mean over the runs";
        observations.ramp.bar(page, (caption, ""), [lefts[1], page.y], plane.width);
    }
    page.y += BAR_HEIGHT + GROUP_GAP;
    notes.has_outside |= spread.cell_share < 1.0;
    notes.has_mask |= !spread.masked_cells.is_empty();
    let most = maps.iter().map(|(_, measure)| measure.max_px).fold(0.0, f64::max);
    if most > ramp.top {
        let [top, most] = [ramp.top, most].map(|px| significant(px, 3));
        let label = &member.label;
        notes.beyond.push(format!("{label}: the darkest blue goes on from {top} to {most} px."));
    }
}

/// The number where colours end, one for all maps of a group: that of the turned one decides, if the others are not much lower.
fn top(maps: &[(&str, &SpreadMeasure)]) -> f64 {
    let own = |measure: &SpreadMeasure| measure.max_px.min(TALLEST * measure.p95_px);
    let turned = maps.get(1).map_or(f64::INFINITY, |(_, measure)| RAW_TALLEST * own(measure));
    let top = maps.iter().map(|(_, measure)| own(measure)).fold(0.0, f64::max).min(turned);
    if top > 0.0 { top } else { 1.0 }
}

fn map(
    page: &mut Page,
    place: &Placed,
    spread: &Spread,
    (name, measure): (&str, &SpreadMeasure),
    ramp: &Ramp,
) {
    let [rms, max] = [measure.rms_px, measure.max_px].map(|px| significant(px, 3));
    caption(page, place, &format!("{name}: {rms} px RMS, at most {max} px"));
    place.ticks(page);
    let cells = spread.cells.iter().zip(&measure.map_px);
    let steps: Vec<(usize, usize)> = cells.map(|(cell, px)| (*cell, ramp.step(*px))).collect();
    place.cells(&mut page.drawing, &steps, |step| ramp.color(step));
    place.hatch(&mut page.drawing, &spread.masked_cells, GREY);
    place.border(page);
    let mut whole = vec![None; spread.columns * spread.rows];
    for (cell, px) in spread.cells.iter().zip(&measure.map_px) {
        whole[*cell] = Some(*px);
    }
    let least = measure.map_px.iter().copied().fold(f64::INFINITY, f64::min);
    let mut spots: Vec<(Rect, String)> = Vec::new();
    for (level, label) in levels([least, measure.max_px]) {
        let on_page = |line: Vec<Point>| -> Vec<Point> {
            line.into_iter().map(|at| place.of_cells(at)).collect()
        };
        let lines: Vec<Vec<Point>> =
            contours(&whole, spread.columns, level).into_iter().map(on_page).collect();
        contour(page, place, &lines, &label, &mut spots);
    }
    // Over all lines: those of other levels may pass close by.
    for (spot, label) in spots {
        number(page, spot, &label);
    }
}

fn caption(page: &mut Page, place: &Placed, text: &str) {
    let at = [place.plot.left, place.plot.top - 0.5 * CAPTION_HEIGHT];
    page.drawing.text(text, at, Pinned::Left, SMALL, INK);
}

/// The lines of one level, and room for its number; without it they are left out, as no one could read them.
fn contour(
    page: &mut Page,
    place: &Placed,
    lines: &[Vec<Point>],
    label: &str,
    spots: &mut Vec<(Rect, String)>,
) {
    /// Shorter pieces of a line have no number of their own, if another piece has.
    const LABELLED: f64 = 90.0;
    /// Shorter pieces are specks.
    const DRAWN: f64 = 8.0;
    /// A number hides a line that is not so many times as long.
    const LEAST: f64 = 2.5;
    let mut order: Vec<&Vec<Point>> = lines.iter().collect();
    order.sort_by(|a, b| length(b).total_cmp(&length(a)));
    let width = page.font.width(label, SMALL);
    let known = spots.len();
    for (index, line) in order.iter().enumerate() {
        let is_long = length(line) >= LABELLED || index == 0 && length(line) >= LEAST * width;
        let spot = if is_long { room(line, width, place.plot, spots) } else { None };
        spots.extend(spot.map(|spot| (spot, label.to_owned())));
    }
    if spots.len() > known {
        for line in order.into_iter().filter(|line| length(line) >= DRAWN) {
            page.drawing.line(line, INK, 1.1);
        }
    }
}

/// The number of a line, with some ground of its own.
fn number(page: &mut Page, spot: Rect, label: &str) {
    let Rect { left, top, right, bottom } = spot;
    let ground =
        Rect { left: left + 3.0, right: right - 3.0, top: top + 3.0, bottom: bottom - 3.0 };
    page.drawing.area(&ground.corners(), PAPER);
    let middle = [0.5 * (left + right), 0.5 * (top + bottom)];
    page.drawing.text(label, middle, Pinned::Center, SMALL, INK);
}

/// A place on the line for a number of this width, off the border and off all others: near the line's middle, if there is one.
fn room(line: &[Point], width: f64, plot: Rect, taken: &[(Rect, String)]) -> Option<Rect> {
    const HALF_HEIGHT: f64 = 10.0;
    /// From the number to what is next to it.
    const APART: f64 = 5.0;
    let half = 0.5 * width + APART;
    let spot = |&[x, y]: &Point| Rect {
        left: x - half,
        right: x + half,
        top: y - HALF_HEIGHT,
        bottom: y + HALF_HEIGHT,
    };
    let is_free = |spot: &Rect| {
        let is_inside = spot.left >= plot.left
            && spot.right <= plot.right
            && spot.top >= plot.top
            && spot.bottom <= plot.bottom;
        is_inside && !taken.iter().any(|(other, _)| other.meets(spot))
    };
    let (before, after) = line.split_at(line.len() / 2);
    let mut outwards = after.iter().zip(before.iter().rev()).flat_map(|(a, b)| [a, b]);
    outwards.find_map(|at| Some(spot(at)).filter(is_free))
}

fn length(line: &[Point]) -> f64 {
    line.windows(2).map(|ends| (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1])).sum()
}

/// The mean counts of observations, with their colours.
struct Observations {
    means: Vec<f64>,
    ramp: Ramp,
}

impl Observations {
    fn of(spread: &Spread) -> Option<Self> {
        let means = spread.mean_observations()?;
        let mut sorted: Vec<f64> = means.iter().copied().filter(|mean| *mean > 0.0).collect();
        sorted.sort_by(f64::total_cmp);
        // An order statistic, not a quantile: this only chooses a view.
        let most = sorted.last()?;
        let usual = sorted[sorted.len() - 1 - sorted.len() / 20];
        Some(Self { ramp: Ramp::greys(most.min(TALLEST * usual)), means })
    }

    fn draw(&self, page: &mut Page, place: &Placed, spread: &Spread) {
        let most = self.means.iter().copied().fold(0.0, f64::max);
        caption(page, place, &format!("observations: at most {} in a cell", significant(most, 3)));
        place.ticks(page);
        let cells = self.means.iter().enumerate().filter(|(_, mean)| **mean > 0.0);
        let steps: Vec<(usize, usize)> =
            cells.map(|(cell, mean)| (cell, self.ramp.step(*mean))).collect();
        place.cells(&mut page.drawing, &steps, |step| self.ramp.color(step));
        let mut region: Vec<usize> =
            spread.cells.iter().chain(&spread.masked_cells).copied().collect();
        region.sort_unstable();
        place.edge(&mut page.drawing, &region, INK);
        place.hatch(&mut page.drawing, &spread.masked_cells, GREY);
        place.border(page);
    }
}
