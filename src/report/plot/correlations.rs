//! How all parameters went with each other across the runs: a matrix a group, with its numbers.

use super::color::{Color, GREY, INK, PAPER, opaque};
use super::columns::{Columns, PanelWidth};
use super::drawing::{Drawing, Pinned, Rect};
use super::font::Font;
use super::labels::labels;
use super::notes::notes;
use super::number::fixed;
use super::page::{BODY, Page, SMALL};
use super::subject::Subject;
use crate::stability::Correlations;

const CELL: [f64; 2] = [44.0, 26.0];
const HEADING_HEIGHT: f64 = 24.0;
const NAMES_HEIGHT: f64 = 20.0;
const NAME_GAP: f64 = 8.0;
const COLUMN_GAP: f64 = 40.0;
const PANEL_GAP: f64 = 18.0;
/// The grounds of -1 and 1, equally dark: the sign is read from the number.
const NEGATIVE: Color = opaque(0xB3, 0x58, 0x06);
const POSITIVE: Color = opaque(0x22, 0x5E, 0xA8);
/// Ground darker than this has numbers in white.
const DARK: f64 = 60.0;

/// The figure; none where no two parameters can be compared.
pub fn draw(subject: &Subject, font: &Font) -> Option<Drawing> {
    let labels = labels(subject, font);
    let members = labels.iter().zip(&subject.members);
    let all = members.map(|(label, member)| (label, &member.population.correlations));
    let shown: Vec<(&String, &Correlations)> = all.filter(|(_, one)| has_pairs(one)).collect();
    let most = shown.iter().map(|(_, one)| one.parameters.len()).max()?;
    let names = shown.iter().flat_map(|(_, one)| &one.parameters);
    let left = names.map(|name| font.width(name, SMALL)).fold(0.0, f64::max) + NAME_GAP;
    let plot = most as f64 * CELL[0];
    // A heading may be wider than its matrix.
    let heading = shown.iter().map(|(label, _)| font.width(label, BODY)).fold(0.0, f64::max);
    let right = COLUMN_GAP + (heading - plot).max(0.0);
    let columns = Columns::new(shown.len(), 0.0, &PanelWidth { left, plot: [plot; 2], right });
    let least = 340.0_f64.max(columns.page_width);
    let subtitle = "Correlation of the parameters over the runs (Pearson)";
    let mut page = Page::new(font, least, &subject.words(), subtitle);
    for line in shown.chunks(columns.lefts.len()) {
        let top = page.y;
        for ((label, correlations), left) in line.iter().zip(&columns.lefts) {
            page.drawing.text(label, [*left, top + 0.5 * HEADING_HEIGHT], Pinned::Left, BODY, INK);
            matrix(&mut page, correlations, [*left, top + HEADING_HEIGHT + NAMES_HEIGHT]);
        }
        let rows = line.iter().map(|(_, one)| one.parameters.len()).max().unwrap_or(0);
        page.y = top + HEADING_HEIGHT + NAMES_HEIGHT + rows as f64 * CELL[1] + PANEL_GAP;
    }
    let mut below = Vec::new();
    if shown.iter().any(|(_, one)| one.matrix.iter().flatten().any(Option::is_none)) {
        below.push(
            "Without a number: fewer than three runs have both, or one does not vary.".to_owned(),
        );
    }
    below.extend(notes(subject, &subject.rows()));
    Some(page.finish(&below))
}

/// Whether there is a correlation of two different parameters.
fn has_pairs(correlations: &Correlations) -> bool {
    let rows = correlations.matrix.iter().enumerate();
    rows.flat_map(|(index, row)| &row[..index]).any(Option::is_some)
}

fn matrix(page: &mut Page, correlations: &Correlations, [left, top]: [f64; 2]) {
    let [width, height] = CELL;
    let names = &correlations.parameters;
    for (index, (name, row)) in names.iter().zip(&correlations.matrix).enumerate() {
        let offset = index as f64;
        let middle = top + (offset + 0.5) * height;
        page.drawing.text(name, [left - NAME_GAP, middle], Pinned::Right, SMALL, GREY);
        let column = page.font.shorten(name, SMALL, width - 4.0);
        let above = [left + (offset + 0.5) * width, top - 0.5 * NAMES_HEIGHT];
        page.drawing.text(&column, above, Pinned::Center, SMALL, GREY);
        for (other, r) in row.iter().enumerate() {
            let x = left + other as f64 * width;
            let y = top + offset * height;
            let cell = Rect { left: x, top: y, right: x + width, bottom: y + height };
            if let Some(r) = r {
                number(page, cell, *r, other == index);
            }
            page.drawing.outline(cell, GREY);
        }
    }
}

fn number(page: &mut Page, cell: Rect, r: f64, is_same: bool) {
    let full = if r < 0.0 { NEGATIVE } else { POSITIVE };
    let ground = if is_same { PAPER } else { PAPER.toward(full, r.abs().min(1.0)) };
    let ink = match (is_same, ground.lightness() < DARK) {
        (true, _) => GREY,
        (false, true) => PAPER,
        (false, false) => INK,
    };
    page.drawing.area(&cell.corners(), ground);
    let middle = [0.5 * (cell.left + cell.right), 0.5 * (cell.top + cell.bottom)];
    page.drawing.text(&fixed(r, 2), middle, Pinned::Center, SMALL, ink);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ground_is_as_dark_as_the_correlation_is_strong_and_numbers_stand_out() {
        for full in [NEGATIVE, POSITIVE] {
            let mut last = 101.0;
            for step in 0..=10 {
                let ground = PAPER.toward(full, f64::from(step) / 10.0).lightness();
                assert!(ground < last, "{ground} {last}");
                let ink = if ground < DARK { PAPER } else { INK };
                assert!((ground - ink.lightness()).abs() > 38.0, "{ground}");
                last = ground;
            }
        }
        assert!((NEGATIVE.lightness() - POSITIVE.lightness()).abs() < 8.0);
    }
}
