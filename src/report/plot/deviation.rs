//! The run that is furthest off the others: where to, and how far, as arrows over the image.

use super::arrows::{FACTORS, arrow, round_below};
use super::color::{Color, GREY, INK, opaque};
use super::columns::{Columns, PanelWidth};
use super::drawing::{Drawing, Pinned};
use super::font::{Font, clean};
use super::number::significant;
use super::page::{BODY, Page, SMALL};
use super::plane::{BELOW, Placed, Plane};
use super::spreads::{SpreadOf, Spreads};
use crate::stability::spread::Spread;

pub const PLOT_WIDTHS: [f64; 2] = [560.0, 380.0];
pub const COLUMN_GAP: f64 = 26.0;
pub const HEADING_HEIGHT: f64 = 40.0;
pub const KEY_HEIGHT: f64 = 30.0;
pub const PANEL_GAP: f64 = 16.0;
/// The longest arrow as a multiple of their distance: longer ones would cover each other.
const LONGEST: f64 = 1.1;
/// Where the runs were compared.
pub const GROUND: Color = opaque(0xEE, 0xEE, 0xEE);

/// The figure; none where no run is off.
pub fn draw(spreads: &Spreads, font: &Font) -> Option<Drawing> {
    let is_off =
        |member: &&SpreadOf| member.spread.worst.px.iter().any(|px| px[0].hypot(px[1]) > 0.0);
    let shown: Vec<&SpreadOf> = spreads.members.iter().filter(is_off).collect();
    let plot_width = if shown.len() == 1 { PLOT_WIDTHS[0] } else { PLOT_WIDTHS[1] };
    let plane = Plane::new(font, spreads.size, shown.first()?.spread.grid(), plot_width);
    let width = PanelWidth { left: plane.left_room(font), plot: PLOT_WIDTHS, right: COLUMN_GAP };
    let columns = Columns::new(shown.len(), 0.0, &width);
    let subtitle = "The run furthest off the others, turned onto them: from where they see a point to where it does";
    let mut page = Page::new(font, columns.page_width, &spreads.camera, subtitle);
    for line in shown.chunks(columns.lefts.len()) {
        let top = page.y + HEADING_HEIGHT;
        for (member, left) in line.iter().zip(&columns.lefts) {
            panel(&mut page, member, &plane.placed([*left, top]));
        }
        page.y = top + plane.height + BELOW + KEY_HEIGHT + PANEL_GAP;
    }
    let key =
        "Each arrow has its middle where the deviation is. Grey: where the runs are compared.";
    Some(page.finish(&[&[key.to_owned()], &spreads.runs_in_words[..]].concat()))
}

fn panel(page: &mut Page, member: &SpreadOf, place: &Placed) {
    let spread = member.spread;
    let (left, top, bottom) = (place.plot.left, place.plot.top, place.plot.bottom);
    let width = place.plot.right - left;
    let lines =
        [member.label.clone(), words(spread)].map(|line| page.font.shorten(&line, BODY, width));
    for (line, above) in lines.iter().zip([30.0, 12.0]) {
        page.drawing.text(line, [left, top - above], Pinned::Left, BODY, INK);
    }
    place.ticks(page);
    let ground: Vec<(usize, usize)> = spread.cells.iter().map(|cell| (*cell, 0)).collect();
    place.cells(&mut page.drawing, &ground, |_| GROUND);
    place.border(page);
    let longest = spread.worst.px.iter().map(|px| px[0].hypot(px[1])).fold(0.0, f64::max);
    let apart = width * spread.worst.pitch as f64 / spread.columns as f64;
    let (factor, factor_label) = round_below(LONGEST * apart / place.scale() / longest, &FACTORS);
    for (cell, px) in spread.worst.cells.iter().zip(&spread.worst.px) {
        let by = px.map(|px| px * factor * place.scale());
        let [x, y] = place.middle(*cell);
        arrow(&mut page.drawing, [x - 0.5 * by[0], y - 0.5 * by[1]], by, INK);
    }
    let (reference, label) = round_below(longest, &[5.0, 2.0, 1.0]);
    let y = bottom + BELOW + 0.5 * KEY_HEIGHT;
    let length = reference * factor * place.scale();
    arrow(&mut page.drawing, [left, y], [length, 0.0], INK);
    let text = format!("{label} px; arrows are {factor_label} times as long as in the image");
    page.drawing.text(&text, [left + length + 10.0, y], Pinned::Left, SMALL, GREY);
}

/// The run and how far it is off.
fn words(spread: &Spread) -> String {
    let worst = &spread.worst;
    let is_worst = |run: &&crate::stability::spread::RunDeviation| {
        run.run == worst.run && run.camera_id == worst.camera_id
    };
    let off = spread.runs.iter().find(is_worst).map(|run| {
        let [rms, max] = [run.rms_px, run.max_px].map(|px| significant(px, 3));
        format!(": {rms} px RMS, at most {max} px")
    });
    clean(&worst.run) + &off.unwrap_or_default()
}
