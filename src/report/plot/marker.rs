//! How the points of a group look: a shape, a colour and a dash, told apart in black and white too.

use super::color::{Color, GROUPS, PAPER};
use super::drawing::{Drawing, Point};

/// How a group is drawn, the same in all figures of an analysis.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    pub color: Color,
    pub marker: Marker,
    /// Lengths drawn and left out in turn; empty: unbroken.
    pub dash: &'static [f64],
}

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Marker {
    outline: Outline,
    is_open: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outline {
    Circle,
    Square,
    Up,
    Diamond,
    Down,
}

const OUTLINES: [Outline; 5] =
    [Outline::Circle, Outline::Square, Outline::Up, Outline::Diamond, Outline::Down];
const DASHES: [&[f64]; 4] = [&[], &[6.0, 3.0], &[1.5, 2.5], &[8.0, 3.0, 1.5, 3.0]];

impl Style {
    /// The style of the group of this index: 70 groups pass before colour and shape repeat.
    pub fn of_group(index: usize) -> Self {
        let shape = index % (2 * OUTLINES.len());
        Self {
            color: GROUPS[index % GROUPS.len()],
            marker: Marker {
                outline: OUTLINES[shape % OUTLINES.len()],
                is_open: shape >= OUTLINES.len(),
            },
            dash: DASHES[index % DASHES.len()],
        }
    }
}

impl Marker {
    /// Draws the marker; all have about the area of a disc of this radius.
    pub fn draw(self, drawing: &mut Drawing, at: Point, radius: f64, color: Color) {
        self.fill(drawing, at, radius, color);
        if self.is_open {
            self.fill(drawing, at, 0.55 * radius, PAPER);
        }
    }

    fn fill(self, drawing: &mut Drawing, at: Point, radius: f64, color: Color) {
        let unit: &[Point] = match self.outline {
            Outline::Circle => return drawing.disc(at, radius, color),
            Outline::Square => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
            Outline::Up => &[[0.0, -1.3], [1.2, 0.8], [-1.2, 0.8]],
            Outline::Diamond => &[[0.0, -1.35], [1.35, 0.0], [0.0, 1.35], [-1.35, 0.0]],
            Outline::Down => &[[0.0, 1.3], [1.2, -0.8], [-1.2, -0.8]],
        };
        let points: Vec<Point> =
            unit.iter().map(|[x, y]| [at[0] + radius * x, at[1] + radius * y]).collect();
        drawing.area(&points, color);
    }
}

/// A cross: an outlier.
pub fn cross(drawing: &mut Drawing, [x, y]: Point, radius: f64, color: Color) {
    drawing.line(&[[x - radius, y - radius], [x + radius, y + radius]], color, 1.5);
    drawing.line(&[[x - radius, y + radius], [x + radius, y - radius]], color, 1.5);
}

/// A slim arrow head at the border of a plot: a value lies beyond it, this way.
pub fn arrow(drawing: &mut Drawing, [x, y]: Point, [dx, dy]: Point, color: Color) {
    const LENGTH: f64 = 8.0;
    const HALF_WIDTH: f64 = 4.0;
    let side = |sign: f64| {
        [x - LENGTH * dx - sign * HALF_WIDTH * dy, y - LENGTH * dy + sign * HALF_WIDTH * dx]
    };
    drawing.area(&[[x, y], side(1.0), side(-1.0)], color);
}

/// The line through these points, in dashes.
pub fn dashed(drawing: &mut Drawing, points: &[Point], style: &Style, width: f64) {
    if style.dash.is_empty() {
        return drawing.line(points, style.color, width);
    }
    let (mut index, mut left) = (0, style.dash[0]);
    let mut piece = vec![points[0]];
    for ends in points.windows(2) {
        let [[x0, y0], [x1, y1]] = [ends[0], ends[1]];
        let length = (x1 - x0).hypot(y1 - y0);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let share = done / length;
            let turn = [x0 + share * (x1 - x0), y0 + share * (y1 - y0)];
            piece.push(turn);
            let drawn = std::mem::replace(&mut piece, vec![turn]);
            if index % 2 == 0 {
                drawing.line(&drawn, style.color, width);
            }
            index += 1;
            left = style.dash[index % style.dash.len()];
        }
        left -= length - done;
        piece.push([x1, y1]);
    }
    if index % 2 == 0 && piece.len() > 1 {
        drawing.line(&piece, style.color, width);
    }
}
