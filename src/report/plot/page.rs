//! The page round the panels: title, notes, and a cursor that goes down.

use super::color::{Color, GREY, INK, PAPER};
use super::drawing::{Drawing, Pinned, Rect, Shape};
use super::font::Font;

/// Font sizes; 11 px is the least that reads well.
pub const TITLE: f64 = 15.0;
pub const BODY: f64 = 12.0;
pub const SMALL: f64 = 11.0;

/// Blank round the page.
pub const MARGIN: f64 = 24.0;

/// A page that is being filled from top to bottom.
pub struct Page<'f> {
    pub drawing: Drawing,
    pub font: &'f Font,
    /// Where the next thing begins.
    pub y: f64,
}

impl<'f> Page<'f> {
    pub fn new(font: &'f Font, width: f64, title: &str, subtitle: &str) -> Self {
        let mut page = Self { drawing: Drawing::new(width.ceil()), font, y: MARGIN };
        page.paragraph(title, TITLE, INK);
        page.paragraph(subtitle, BODY, GREY);
        page.y += 10.0;
        page
    }

    /// The page with these notes below its panels.
    pub fn finish(mut self, notes: &[String]) -> Drawing {
        for note in notes {
            self.paragraph(note, SMALL, GREY);
        }
        let height = (self.y + MARGIN - 6.0).ceil();
        self.drawing.height = height;
        let paper = Rect { left: 0.0, top: 0.0, right: self.drawing.width, bottom: height };
        self.drawing
            .shapes
            .insert(0, Shape::Area { points: paper.corners().to_vec(), color: PAPER });
        self.drawing
    }

    fn paragraph(&mut self, text: &str, size: f64, color: Color) {
        let line_height = (1.4 * size).round();
        for line in self.font.wrap(text, size, self.drawing.width - 2.0 * MARGIN) {
            let middle = self.y + 0.5 * line_height;
            self.drawing.text(&line, [MARGIN, middle], Pinned::Left, size, color);
            self.y += line_height;
        }
    }
}
