//! A picture as a list of shapes, before anyone knows whether it becomes SVG or PNG.
//!
//! Lengths are CSS pixels, x to the right, y down. Knows nothing of cameras or statistics.

use super::color::Color;

/// A point of a drawing: x, y.
pub type Point = [f64; 2];

/// A picture: shapes, later ones over earlier ones.
#[derive(Debug, Clone)]
pub struct Drawing {
    pub width: f64,
    pub height: f64,
    pub shapes: Vec<Shape>,
}

/// One thing that is drawn.
#[derive(Debug, Clone)]
pub enum Shape {
    /// Connected segments.
    Line { points: Vec<Point>, color: Color, width: f64 },
    /// A filled polygon.
    Area { points: Vec<Point>, color: Color },
    /// A filled circle.
    Disc { center: Point, radius: f64, color: Color },
    /// A line of text.
    Text(Text),
}

/// A line of text.
#[derive(Debug, Clone)]
pub struct Text {
    pub text: String,
    /// Where it is pinned; vertically the middle of its lower-case letters.
    pub at: Point,
    pub pinned: Pinned,
    /// Font size, the em.
    pub size: f64,
    pub color: Color,
}

/// Which part of a text is at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pinned {
    Left,
    Center,
    Right,
}

/// An upright rectangle.
#[derive(Debug, Clone, Copy)]
pub struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rect {
    /// Whether two rectangles share more than a border.
    pub fn meets(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    pub fn corners(&self) -> [Point; 4] {
        let Self { left, top, right, bottom } = *self;
        [[left, top], [right, top], [right, bottom], [left, bottom]]
    }
}

impl Drawing {
    pub fn new(width: f64) -> Self {
        Self { width, height: 0.0, shapes: Vec::new() }
    }

    pub fn line(&mut self, points: &[Point], color: Color, width: f64) {
        self.shapes.push(Shape::Line { points: points.to_vec(), color, width });
    }

    /// A thin upright or level line, moved onto the middle of the screen's pixels: between two it would blur.
    pub fn hairline(&mut self, from: Point, to: Point, color: Color) {
        let crisp = |[x, y]: Point| [x.floor() + 0.5, y.floor() + 0.5];
        self.line(&[crisp(from), crisp(to)], color, 1.0);
    }

    /// The border of a rectangle, a hairline.
    pub fn outline(&mut self, rect: Rect, color: Color) {
        let [a, b, c, d] = rect.corners();
        for [from, to] in [[a, b], [b, c], [d, c], [a, d]] {
            self.hairline(from, to, color);
        }
    }

    pub fn area(&mut self, points: &[Point], color: Color) {
        self.shapes.push(Shape::Area { points: points.to_vec(), color });
    }

    pub fn disc(&mut self, center: Point, radius: f64, color: Color) {
        self.shapes.push(Shape::Disc { center, radius, color });
    }

    pub fn text(&mut self, text: &str, at: Point, pinned: Pinned, size: f64, color: Color) {
        self.shapes.push(Shape::Text(Text { text: text.to_owned(), at, pinned, size, color }));
    }
}

impl Shape {
    /// The least and greatest y that it may touch.
    pub fn rows(&self) -> [f64; 2] {
        match self {
            Self::Line { points, width, .. } => rows_of(points, *width),
            Self::Area { points, .. } => rows_of(points, 0.0),
            Self::Disc { center: [_, y], radius, .. } => [y - radius, y + radius],
            // No letter of a Latin font reaches further than an em from its middle.
            Self::Text(text) => [text.at[1] - text.size, text.at[1] + text.size],
        }
    }
}

fn rows_of(points: &[Point], margin: f64) -> [f64; 2] {
    points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [_, y]| {
        [low.min(y - margin), high.max(y + margin)]
    })
}
