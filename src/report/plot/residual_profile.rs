//! How far residuals lean outward and along the tangent, by distance from the principal point, group beside group.

use super::axis::Axis;
use super::color::{GREY, INK};
use super::columns::{Columns, PanelWidth};
use super::drawing::{Drawing, Pinned, Point, Rect};
use super::font::Font;
use super::frame::{exact_level_axis, left_room, level_ticks, upright_tick_count, upright_ticks};
use super::legend::{Sample, legend};
use super::marker::{Style, dashed};
use super::page::{BODY, Page, SMALL};
use super::profile::{
    AXIS_NAME_HEIGHT, CAPTION_HEIGHT, COLUMN_GAP, PANEL_GAP, PLOT_HEIGHT, PLOT_WIDTHS, TICKS_HEIGHT,
};
use super::residuals::{REACH_95, ResidualMaps, ResidualsOf};
use crate::stability::RingMean;

/// Half the width of the foot of an error bar.
const FOOT: f64 = 2.5;

/// Names of the two directions, as a ring's means have them.
const PANELS: [&str; 2] = ["outward", "along the tangent"];

const NOTE: &str = "Mean residual (projection less keypoint) in rings about the principal point; bars: 95 % of means lie within, were \
    noise all. A curve of the outward residual that stays off zero asks for another radial term.";

/// The figure; none without a ring.
pub fn draw(maps: &ResidualMaps, font: &Font) -> Option<Drawing> {
    let heights = heights(maps)?;
    let width =
        PanelWidth { left: left_room(&heights, font), plot: PLOT_WIDTHS, right: COLUMN_GAP };
    let columns = Columns::new(2, 0.0, &width);
    let subtitle = "Mean residuals by distance from the principal point";
    let mut page = Page::new(font, columns.page_width, &maps.camera, subtitle);
    let of_members = |member: &ResidualsOf| (member.label.clone(), member.style);
    let (labels, styles): (Vec<String>, Vec<Style>) = maps.members.iter().map(of_members).unzip();
    if labels.iter().any(|label| !label.is_empty()) {
        legend(&mut page, &labels, &styles, Sample::MarkerOnLine);
    }
    let [wide, high] = maps.size.map(|length| length as f64);
    let radii = exact_level_axis(font, [0.0, 0.5 * wide.hypot(high)], PLOT_WIDTHS[1]);
    let top = page.y + CAPTION_HEIGHT;
    for ((axis, name), left) in PANELS.into_iter().enumerate().zip(columns.lefts) {
        let right = left + columns.plot_width;
        let plot = Rect { left, top, right, bottom: top + PLOT_HEIGHT };
        let at = [left, top - 0.5 * CAPTION_HEIGHT - 1.0];
        let caption = heights.caption(&format!("mean residual {name}"), "px");
        page.drawing.text(&caption, at, Pinned::Left, BODY, INK);
        level_ticks(&mut page, plot, &radii);
        upright_ticks(&mut page, plot, &heights);
        let zero = plot.bottom - heights.share(0.0) * PLOT_HEIGHT;
        page.drawing.hairline([left, zero], [right, zero], GREY);
        let below = plot.bottom + TICKS_HEIGHT + 0.5 * AXIS_NAME_HEIGHT;
        let at = [0.5 * (left + right), below];
        let name = "distance from the principal point [px]";
        page.drawing.text(name, at, Pinned::Center, SMALL, GREY);
        for (index, member) in maps.members.iter().enumerate() {
            // Bars of groups would cover each other.
            let aside = 3.0 * (index as f64 - 0.5 * (maps.members.len() - 1) as f64);
            curve(&mut page, member, axis, |radius, px| {
                let x = plot.left + radii.share(radius) * (plot.right - plot.left) + aside;
                let share = heights.share(px).clamp(0.0, 1.0);
                [x.clamp(plot.left, plot.right), plot.bottom - share * PLOT_HEIGHT]
            });
        }
    }
    page.y = top + PLOT_HEIGHT + TICKS_HEIGHT + AXIS_NAME_HEIGHT + PANEL_GAP;
    Some(page.finish(&[&[NOTE.to_owned()], &maps.runs_in_words[..]].concat()))
}

/// The upright axis of both panels: all means, and what bars need about a usual one.
fn heights(maps: &ResidualMaps) -> Option<Axis> {
    let rings = || maps.members.iter().flat_map(|member| &member.residuals.map.rings);
    let furthest = rings().flat_map(|ring| ring.mean.px).map(f64::abs).reduce(f64::max)?;
    let mut errors: Vec<f64> = rings().flat_map(|ring| ring.mean.std_error_px).collect();
    errors.sort_by(f64::total_cmp);
    let top = 1.06 * (furthest + REACH_95 * errors[errors.len() / 2]);
    let top = if top > 0.0 { top } else { 1.0 };
    Some(Axis::exact([-top, top], upright_tick_count(PLOT_HEIGHT)))
}

fn curve(page: &mut Page, member: &ResidualsOf, axis: usize, place: impl Fn(f64, f64) -> Point) {
    let rings = &member.residuals.map.rings;
    let middle = |ring: &RingMean| place(ring.radius_px, ring.mean.px[axis]);
    let points: Vec<Point> = rings.iter().map(middle).collect();
    if points.len() > 1 {
        dashed(&mut page.drawing, &points, &member.style, 1.0);
    }
    for ring in rings {
        let reach = REACH_95 * ring.mean.std_error_px[axis];
        let [low, high] = [-reach, reach].map(|by| place(ring.radius_px, ring.mean.px[axis] + by));
        page.drawing.line(&[low, high], member.style.color, 1.0);
        for [x, y] in [low, high] {
            page.drawing.line(&[[x - FOOT, y], [x + FOOT, y]], member.style.color, 1.0);
        }
        let at = middle(ring);
        member.style.marker.draw(&mut page.drawing, at, 3.0, member.style.color);
    }
}
