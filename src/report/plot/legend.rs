//! Which mark belongs to which group, in columns above the panels, where nothing else is drawn.

use super::color::INK;
use super::drawing::Pinned;
use super::labels::widest;
use super::marker::{Style, dashed};
use super::page::{BODY, MARGIN, Page};

const ROW_HEIGHT: f64 = 19.0;
const GAP: f64 = 24.0;

/// What stands before a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sample {
    Marker,
    MarkerOnLine,
}

/// The legend, at the page's cursor.
pub fn legend(page: &mut Page, labels: &[String], styles: &[Style], sample: Sample) {
    let sample_width = if sample == Sample::Marker { 12.0 } else { 34.0 };
    let entry_width = sample_width + 6.0 + widest(labels, page.font);
    let room = page.drawing.width - 2.0 * MARGIN;
    let mut at = [MARGIN, page.y + 0.5 * ROW_HEIGHT];
    for (label, style) in labels.iter().zip(styles) {
        if at[0] > MARGIN && at[0] + entry_width > MARGIN + room {
            at = [MARGIN, at[1] + ROW_HEIGHT];
        }
        let [x, y] = at;
        if sample == Sample::MarkerOnLine {
            dashed(&mut page.drawing, &[[x, y], [x + sample_width, y]], style, 1.4);
        }
        style.marker.draw(&mut page.drawing, [x + 0.5 * sample_width, y], 3.5, style.color);
        page.drawing.text(label, [x + sample_width + 6.0, y], Pinned::Left, BODY, INK);
        at[0] += entry_width + GAP;
    }
    page.y = at[1] + 0.5 * ROW_HEIGHT + 6.0;
}
