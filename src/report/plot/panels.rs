//! Small panels of one size, a heuristic each, in rows across a page.

use super::color::INK;
use super::drawing::{Drawing, Pinned, Point};
use super::font::Font;
use super::page::{BODY, MARGIN, Page};

const CAPTION_HEIGHT: f64 = 22.0;
const GAP: f64 = 22.0;
const IN_A_ROW: usize = 4;

/// A page of panels with these captions; `below` draws what explains them, `panel` each of them at its corner.
pub struct Panels<'a> {
    pub title: &'a str,
    pub subtitle: &'a str,
    pub captions: &'a [String],
    /// Width and height of each.
    pub size: Point,
}

impl Panels<'_> {
    /// The page.
    pub fn draw(
        &self,
        font: &Font,
        mut panel: impl FnMut(&mut Page, usize, Point),
        below: impl FnOnce(&mut Page),
        notes: &[String],
    ) -> Drawing {
        let [width, height] = self.size;
        let across = IN_A_ROW.min(self.captions.len()).max(1);
        let page_width = 2.0 * MARGIN + across as f64 * (width + GAP) - GAP;
        let mut page = Page::new(font, page_width, self.title, self.subtitle);
        for (line, captions) in self.captions.chunks(across).enumerate() {
            for (column, caption) in captions.iter().enumerate() {
                let left = MARGIN + column as f64 * (width + GAP);
                let at = [left, page.y + 0.5 * CAPTION_HEIGHT];
                page.drawing.text(caption, at, Pinned::Left, BODY, INK);
                let corner = [left, page.y + CAPTION_HEIGHT];
                panel(&mut page, line * across + column, corner);
            }
            page.y += CAPTION_HEIGHT + height + GAP;
        }
        below(&mut page);
        page.finish(notes)
    }
}
