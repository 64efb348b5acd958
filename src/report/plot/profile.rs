//! The spread by distance from the image's centre, group beside group.

use super::axis::Axis;
use super::color::{GREY, INK};
use super::columns::{Columns, PanelWidth};
use super::drawing::{Drawing, Pinned, Point, Rect};
use super::font::Font;
use super::frame::{exact_level_axis, left_room, level_ticks, upright_tick_count, upright_ticks};
use super::legend::{Sample, legend};
use super::marker::{Style, dashed};
use super::page::{BODY, Page, SMALL};
use super::spreads::{SpreadOf, Spreads};
use crate::stability::PredictedSpread;
use crate::stability::spread::Ring;

pub const PLOT_WIDTHS: [f64; 2] = [380.0, 380.0];
pub const PLOT_HEIGHT: f64 = 240.0;
pub const CAPTION_HEIGHT: f64 = 24.0;
pub const TICKS_HEIGHT: f64 = 22.0;
pub const AXIS_NAME_HEIGHT: f64 = 20.0;
pub const COLUMN_GAP: f64 = 26.0;
pub const PANEL_GAP: f64 = 14.0;
/// Groups further apart than this factor share no even axis: the lower one would be a line at the bottom.
const EVEN: f64 = 12.0;
/// What a spread below this share of the greatest is, no one asks; without a bound zero would have no place.
const LEAST: f64 = 1e-4;

type OfRing = fn(&Ring) -> f64;

/// Which of a ring's spreads a panel shows, and under which name.
const PANELS: [(&str, OfRing); 2] =
    [("as they are", |ring| ring.raw_rms_px), (TURNED, |ring| ring.rms_px)];
const TURNED: &str = "turned";

const BAND: &str = "Thin line: what the adjustments predict of the turned spread. Band: where 95 % of such groups of runs would lie.";

/// The figure; none without a spread.
pub fn draw(spreads: &Spreads, font: &Font) -> Option<Drawing> {
    let heights = Heights::of(spreads)?;
    let room = left_room(&heights.axis, font);
    let width = PanelWidth { left: room, plot: PLOT_WIDTHS, right: COLUMN_GAP };
    let columns = Columns::new(2, 0.0, &width);
    let subtitle = "Spread by distance from the image's centre, RMS over rings";
    let mut page = Page::new(font, columns.page_width, &spreads.camera, subtitle);
    let of_members = |member: &SpreadOf| (member.label.clone(), member.style);
    let (labels, styles): (Vec<String>, Vec<Style>) =
        spreads.members.iter().map(of_members).unzip();
    if labels.iter().any(|label| !label.is_empty()) {
        legend(&mut page, &labels, &styles, Sample::MarkerOnLine);
    }
    let [wide, high] = spreads.size.map(|length| length as f64);
    let radii = exact_level_axis(font, [0.0, 0.5 * wide.hypot(high)], PLOT_WIDTHS[1]);
    let top = page.y + CAPTION_HEIGHT;
    for ((name, value), left) in PANELS.into_iter().zip(columns.lefts) {
        let right = left + columns.plot_width;
        let plot = Rect { left, top, right, bottom: top + PLOT_HEIGHT };
        let at = [left, top - 0.5 * CAPTION_HEIGHT - 1.0];
        let caption = heights.axis.caption(&format!("{name}: spread"), "px");
        page.drawing.text(&caption, at, Pinned::Left, BODY, INK);
        level_ticks(&mut page, plot, &radii);
        upright_ticks(&mut page, plot, &heights.axis);
        let below = plot.bottom + TICKS_HEIGHT + 0.5 * AXIS_NAME_HEIGHT;
        let at = [0.5 * (left + right), below];
        page.drawing.text("distance from the centre [px]", at, Pinned::Center, SMALL, GREY);
        for (member, predicted) in with_prediction(spreads).filter(|_| name == TURNED) {
            let share = |radius, px| [radii.share(radius), heights.share(px)];
            band(&mut page, plot, member, predicted, share);
        }
        for member in &spreads.members {
            curve(&mut page, plot, member, |ring| {
                [radii.share(ring.radius_px), heights.share(value(ring))]
            });
        }
    }
    page.y = top + PLOT_HEIGHT + TICKS_HEIGHT + AXIS_NAME_HEIGHT + PANEL_GAP;
    let band = with_prediction(spreads).next().map(|_| BAND.to_owned());
    let band: Vec<String> = band.into_iter().collect();
    Some(page.finish(&[&band[..], &heights.notes, &spreads.runs_in_words].concat()))
}

/// The members whose adjustments predict a spread in the rings.
fn with_prediction<'a>(
    spreads: &'a Spreads,
) -> impl Iterator<Item = (&'a SpreadOf<'a>, &'a PredictedSpread)> {
    let known = |member: &'a SpreadOf| Some((member, member.predicted?));
    let is_drawn = |(_, predicted): &(_, &PredictedSpread)| predicted.radial_px.len() > 1;
    spreads.members.iter().filter_map(known).filter(is_drawn)
}

/// The predicted spread, and how far that of so many runs may lie from it.
fn band(
    page: &mut Page,
    plot: Rect,
    member: &SpreadOf,
    predicted: &PredictedSpread,
    share: impl Fn(f64, f64) -> [f64; 2],
) {
    let line = |factor: f64| -> Vec<Point> {
        let rings = member.spread.radial_profile.iter().zip(&predicted.radial_px);
        let point = |(ring, px): (&Ring, &f64)| {
            let [x, y] = share(ring.radius_px, factor * px);
            let [x, y] = [x, y.clamp(0.0, 1.0)];
            [plot.left + x * (plot.right - plot.left), plot.bottom - y * (plot.bottom - plot.top)]
        };
        rings.map(point).collect()
    };
    let [low, high] = predicted.band_95.map(line);
    let around: Vec<Point> = low.into_iter().chain(high.into_iter().rev()).collect();
    page.drawing.area(&around, member.style.color.faded(0.12));
    page.drawing.line(&line(1.0), member.style.color, 0.8);
}

fn curve(page: &mut Page, plot: Rect, member: &SpreadOf, share: impl Fn(&Ring) -> [f64; 2]) {
    let point = |ring: &Ring| -> Point {
        let [x, y] = share(ring);
        [plot.left + x * (plot.right - plot.left), plot.bottom - y * (plot.bottom - plot.top)]
    };
    let points: Vec<Point> = member.spread.radial_profile.iter().map(point).collect();
    if points.len() > 1 {
        dashed(&mut page.drawing, &points, &member.style, 1.4);
    }
    for at in points {
        member.style.marker.draw(&mut page.drawing, at, 3.0, member.style.color);
    }
}

/// The upright axis of both panels.
struct Heights {
    axis: Axis,
    is_even: bool,
    least: f64,
    notes: Vec<String>,
}

impl Heights {
    fn of(spreads: &Spreads) -> Option<Self> {
        let tallest_of = |member: &SpreadOf| -> [f64; 2] {
            let predicted = member.predicted.iter().flat_map(|predicted| &predicted.radial_px);
            let predicted = predicted.copied().fold(0.0, f64::max);
            PANELS.map(|(_, value)| {
                member.spread.radial_profile.iter().map(value).fold(predicted, f64::max)
            })
        };
        let tallest: Vec<f64> = spreads.members.iter().flat_map(tallest_of).collect();
        let high = tallest.iter().copied().reduce(f64::max)?;
        let low = tallest.iter().copied().filter(|px| *px > 0.0).fold(high, f64::min);
        let tick_count = upright_tick_count(PLOT_HEIGHT);
        if high <= EVEN * low {
            let top = if high > 0.0 { 1.06 * high } else { 1.0 };
            let axis = Axis::exact([0.0, top], tick_count);
            return Some(Self { axis, is_even: true, least: 0.0, notes: Vec::new() });
        }
        let rings = spreads.members.iter().flat_map(|member| &member.spread.radial_profile);
        let values = rings.flat_map(|ring| PANELS.map(|(_, value)| value(ring)));
        let (far, near): (Vec<f64>, Vec<f64>) = values.partition(|px| *px < LEAST * high);
        let least = near.iter().copied().fold(high, f64::min) / 1.2;
        let mut notes = vec!["The axis of the spread goes by ratio.".to_owned()];
        if !far.is_empty() {
            notes.push(format!("{} rings whose spread is lower stand at its foot.", far.len()));
        }
        let axis = Axis::of_decades([least, 1.2 * high], tick_count);
        Some(Self { axis, is_even: false, least, notes })
    }

    fn share(&self, px: f64) -> f64 {
        if self.is_even { self.axis.share(px) } else { self.axis.share(px.max(self.least).log10()) }
    }
}
