//! Where the residuals of a camera lean to, cell by cell, as arrows over the image.

use super::arrows::{FACTORS, arrow, round_below};
use super::color::{Color, GREY, INK, opaque};
use super::columns::{Columns, PanelWidth};
use super::deviation::{COLUMN_GAP, GROUND, HEADING_HEIGHT, KEY_HEIGHT, PANEL_GAP, PLOT_WIDTHS};
use super::drawing::{Drawing, Pinned, Rect};
use super::font::Font;
use super::number::significant;
use super::page::{BODY, Page, SMALL};
use super::plane::{BELOW, Placed, Plane};
use super::residuals::{ResidualMaps, ResidualsOf};
use crate::stability::{CellMean, ResidualMap};

/// The longest arrow as a multiple of the cells' width.
const LONGEST: f64 = 1.0;
/// A mean that noise alone shows more often than this is no sign of anything.
const BY_NOISE: f64 = 0.05;
/// Arrows that noise alone would show.
const FAINT: Color = opaque(0xA6, 0xA6, 0xA6);

/// The figure; none without a map.
pub fn draw(maps: &ResidualMaps, font: &Font) -> Option<Drawing> {
    let has_cells = |member: &&ResidualsOf| !member.residuals.map.cells.is_empty();
    let shown: Vec<&ResidualsOf> = maps.members.iter().filter(has_cells).collect();
    let plot_width = if shown.len() == 1 { PLOT_WIDTHS[0] } else { PLOT_WIDTHS[1] };
    let map = &shown.first()?.residuals.map;
    let plane = Plane::new(font, maps.size, [map.columns, map.rows], plot_width);
    let width = PanelWidth { left: plane.left_room(font), plot: PLOT_WIDTHS, right: COLUMN_GAP };
    let columns = Columns::new(shown.len(), 0.0, &width);
    let subtitle = "Mean residuals in cells of the image: from where keypoints are to where the model projects them";
    let mut page = Page::new(font, columns.page_width, &maps.camera, subtitle);
    for line in shown.chunks(columns.lefts.len()) {
        let top = page.y + HEADING_HEIGHT;
        for (member, left) in line.iter().zip(&columns.lefts) {
            panel(&mut page, member, &plane.placed([*left, top]));
        }
        page.y = top + plane.height + BELOW + KEY_HEIGHT + PANEL_GAP;
    }
    let key = "Each arrow has its middle in the middle of its cell. Black: longer than noise makes 95 % of them. \
        Grey ground: enough was observed. With the right lens model about one arrow in twenty is black, and black ones point anywhere.";
    Some(page.finish(&[&[key.to_owned()], &maps.runs_in_words[..]].concat()))
}

fn panel(page: &mut Page, member: &ResidualsOf, place: &Placed) {
    let (left, top, bottom) = (place.plot.left, place.plot.top, place.plot.bottom);
    let width = place.plot.right - left;
    let lines = headings(member).map(|line| page.font.shorten(&line, BODY, width));
    for (line, above) in lines.iter().zip([30.0, 12.0]) {
        page.drawing.text(line, [left, top - above], Pinned::Left, BODY, INK);
    }
    place.ticks(page);
    let map = &member.residuals.map;
    for cell in &map.cells {
        page.drawing.area(&bounds(map, cell, place).corners(), GROUND);
    }
    place.border(page);
    let length = |cell: &CellMean| cell.mean.px[0].hypot(cell.mean.px[1]);
    let longest = map.cells.iter().map(length).fold(f64::MIN_POSITIVE, f64::max);
    let apart = map.cell_px[0] * place.scale();
    let (factor, factor_label) = round_below(LONGEST * apart / place.scale() / longest, &FACTORS);
    for cell in &map.cells {
        let by = cell.mean.px.map(|px| px * factor * place.scale());
        let [x, y] = place.of_pixel(cell.middle);
        let color = if cell.mean.p < BY_NOISE { INK } else { FAINT };
        arrow(&mut page.drawing, [x - 0.5 * by[0], y - 0.5 * by[1]], by, color);
    }
    let (reference, label) = round_below(longest, &[5.0, 2.0, 1.0]);
    let y = bottom + BELOW + 0.5 * KEY_HEIGHT;
    let length = reference * factor * place.scale();
    arrow(&mut page.drawing, [left, y], [length, 0.0], INK);
    let text = format!("{label} px; arrows are {factor_label} times as long as in the image");
    page.drawing.text(&text, [left + length + 10.0, y], Pinned::Left, SMALL, GREY);
}

/// What the image has of a cell, on the page.
fn bounds(map: &ResidualMap, cell: &CellMean, place: &Placed) -> Rect {
    let at = [cell.cell % map.columns, cell.cell / map.columns];
    let first = [0, 1].map(|axis| at[axis] as f64 * map.cell_px[axis]);
    // The middle is that of what the image has.
    let last = [0, 1].map(|axis| 2.0 * cell.middle[axis] - first[axis]);
    let [[left, top], [right, bottom]] = [first, last].map(|at| place.of_pixel(at));
    Rect { left, top, right, bottom }
}

fn headings(member: &ResidualsOf) -> [String; 2] {
    let map = &member.residuals.map;
    let label = if member.label.is_empty() { String::new() } else { format!("{}: ", member.label) };
    let [effect, sigma] =
        [member.residuals.effect_px, member.residuals.sigma_px].map(|px| significant(px, 2));
    [
        format!("{label}{} runs together, {} × {} cells", map.n, map.columns, map.rows),
        format!("pattern {effect} px RMS, noise of a keypoint {sigma} px"),
    ]
}
