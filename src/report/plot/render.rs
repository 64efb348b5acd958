//! A drawing onto a backend of plotters, which counts in whole pixels: finer ones than the page's.

use ab_glyph::{Font as _, GlyphId, PxScale, point};
use plotters::backend::DrawingBackend;
use plotters_backend::text_anchor::{HPos, Pos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind, FontFamily,
};

use super::color::Color;
use super::drawing::{Drawing, Pinned, Point, Shape, Text};
use super::font::{FAMILY, Font};

/// How a drawing maps onto a backend.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Pixels of the backend in one of the drawing.
    pub scale: u32,
    /// The part of the drawing that is seen, from top to bottom.
    pub rows: [f64; 2],
}

/// Draws the shapes that are in view.
pub fn render<B: DrawingBackend>(
    drawing: &Drawing,
    font: &Font,
    view: View,
    backend: &mut B,
) -> Result<(), DrawingErrorKind<B::ErrorType>> {
    let [top, bottom] = view.rows;
    let is_seen = |shape: &&Shape| shape.rows()[0] <= bottom && shape.rows()[1] >= top;
    for shape in drawing.shapes.iter().filter(is_seen) {
        match shape {
            Shape::Line { points, color, width } => {
                let stroke = Stroke { color: *color, width: view.length(*width) };
                backend.draw_path(points.iter().map(|&at| view.pixel(at)), &stroke)?;
            }
            // plotters goes through a polygon pixel by pixel, those out of view too.
            Shape::Area { points, color } => match corners(points) {
                Some([one, other]) => {
                    backend.draw_rect(view.pixel(one), view.pixel(other), color, true)?;
                }
                None => backend.fill_polygon(points.iter().map(|&at| view.pixel(at)), color)?,
            },
            Shape::Disc { center, radius, color } => {
                backend.draw_circle(view.pixel(*center), view.length(*radius), color, true)?;
            }
            Shape::Text(text) => {
                let style = TextStyle { font, text, em: text.size * f64::from(view.scale) };
                backend.draw_text(&text.text, &style, view.pixel(text.at))?;
            }
        }
    }
    Ok(())
}

/// Two opposite corners, if it is a rectangle along the axes.
#[allow(clippy::float_cmp)] // the sides of a rectangle are made of the same numbers
fn corners(points: &[Point]) -> Option<[Point; 2]> {
    let [a, b, c, d] = points else { return None };
    let turns = |x: usize, y: usize| a[x] == b[x] && b[y] == c[y] && c[x] == d[x] && d[y] == a[y];
    (turns(0, 1) || turns(1, 0)).then_some([*a, *c])
}

impl View {
    fn pixel(&self, [x, y]: Point) -> BackendCoord {
        let scale = f64::from(self.scale);
        (whole(x * scale), whole((y - self.rows[0]) * scale))
    }

    fn length(&self, length: f64) -> u32 {
        whole(length * f64::from(self.scale)).max(1).unsigned_abs()
    }
}

struct Stroke {
    color: Color,
    width: u32,
}

impl BackendStyle for Stroke {
    fn color(&self) -> BackendColor {
        self.color.color()
    }

    fn stroke_width(&self) -> u32 {
        self.width
    }
}

/// Text in our own font. plotters' own text drops the room left of each letter, and panics on a font it does not know.
struct TextStyle<'a> {
    font: &'a Font,
    text: &'a Text,
    em: f64,
}

impl BackendTextStyle for TextStyle<'_> {
    type FontError = std::convert::Infallible;

    fn color(&self) -> BackendColor {
        self.text.color.color()
    }

    fn size(&self) -> f64 {
        // plotters counts 1.24 of its units to the em.
        1.24 * self.em
    }

    fn anchor(&self) -> Pos {
        let horizontal = match self.text.pinned {
            Pinned::Left => HPos::Left,
            Pinned::Center => HPos::Center,
            Pinned::Right => HPos::Right,
        };
        Pos::new(horizontal, VPos::Center)
    }

    fn family(&self) -> FontFamily<'_> {
        FontFamily::Name(FAMILY)
    }

    /// As wide as the text; without height, so that its point stays at the height where `draw` wants it.
    fn layout_box(&self, text: &str) -> Result<(BackendCoord, BackendCoord), Self::FontError> {
        let width: f64 = text.chars().map(|letter| self.font.advance(letter)).sum();
        Ok(((0, 0), (whole(width * self.em), 0)))
    }

    fn draw<E, Draw: FnMut(i32, i32, BackendColor) -> Result<(), E>>(
        &self,
        text: &str,
        (left, middle): BackendCoord,
        mut draw: Draw,
    ) -> Result<Result<(), E>, Self::FontError> {
        /// Height of a lower-case letter in em; plotters' SVG lowers the base line by half of it too.
        const EX: f64 = 0.528;
        let face = &self.font.face;
        let scale = PxScale::from(single(self.em) * face.height_unscaled() / self.font.units);
        let base = f64::from(middle) + 0.5 * EX * self.em;
        let mut pen = f64::from(left);
        for letter in text.chars() {
            let id: GlyphId = face.glyph_id(letter);
            let glyph = id.with_scale_and_position(scale, point(single(pen), single(base)));
            pen += self.font.advance(letter) * self.em;
            let Some(outline) = face.outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            let (x0, y0) = (whole(f64::from(corner.x)), whole(f64::from(corner.y)));
            let mut result = Ok(());
            outline.draw(|x, y, coverage| {
                if result.is_ok() && coverage > 0.0 {
                    let color = self.text.color.color().mix(f64::from(coverage.min(1.0)));
                    result =
                        draw(x0.saturating_add_unsigned(x), y0.saturating_add_unsigned(y), color);
                }
            });
            if result.is_err() {
                return Ok(result);
            }
        }
        Ok(Ok(()))
    }
}

#[allow(clippy::cast_possible_truncation)] // `as` saturates, and no drawing is that large
fn whole(value: f64) -> i32 {
    value.round() as i32
}

#[allow(clippy::cast_possible_truncation)] // a glyph is placed in pixels, for which f32 is fine enough
fn single(value: f64) -> f32 {
    value as f32
}
