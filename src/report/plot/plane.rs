//! The image on the page: its frame in px, and cells of its grid in colours.

use std::collections::BTreeSet;

use super::axis::Axis;
use super::color::{Color, GREY, PAPER};
use super::drawing::{Drawing, Pinned, Point, Rect};
use super::font::Font;
use super::frame::{exact_level_axis, left_room, level_ticks, upright_tick_count, upright_ticks};
use super::page::{Page, SMALL};

/// Images higher than this times their width are drawn less high: none is.
const HIGHEST: f64 = 2.0;
const TICKS_HEIGHT: f64 = 22.0;
const NAME_HEIGHT: f64 = 16.0;
/// What the frame needs below the image.
pub const BELOW: f64 = TICKS_HEIGHT + NAME_HEIGHT;
/// Neighbouring cells overlap by this, or viewers that smooth edges show the paper between them.
const OVERLAP: f64 = 0.7;

/// An image of this size in px, this wide on the page.
pub struct Plane {
    size: Point,
    columns: usize,
    rows: usize,
    pub width: f64,
    pub height: f64,
    x: Axis,
    y: Axis,
}

/// Where a plane stands on the page.
pub struct Placed<'p> {
    plane: &'p Plane,
    pub plot: Rect,
}

impl Plane {
    /// The image with so many columns and rows of cells.
    pub fn new(
        font: &Font,
        [wide, high]: [u64; 2],
        [columns, rows]: [usize; 2],
        width: f64,
    ) -> Self {
        let size = [wide.max(1) as f64, high.max(1) as f64];
        let height = (width * size[1] / size[0]).clamp(width / HIGHEST.powi(3), HIGHEST * width);
        let x = exact_level_axis(font, [0.0, size[0]], width);
        let y = Axis::exact([0.0, size[1]], upright_tick_count(height)).downwards();
        Self { size, columns, rows, width, height, x, y }
    }

    /// What its labels need left of it.
    pub fn left_room(&self, font: &Font) -> f64 {
        left_room(&self.y, font)
    }

    pub fn placed(&self, [left, top]: Point) -> Placed<'_> {
        let plot = Rect { left, top, right: left + self.width, bottom: top + self.height };
        Placed { plane: self, plot }
    }
}

impl Placed<'_> {
    /// Ticks, labels, and the name of the axes.
    pub fn ticks(&self, page: &mut Page) {
        let Rect { left, right, bottom, .. } = self.plot;
        level_ticks(page, self.plot, &self.plane.x);
        upright_ticks(page, self.plot, &self.plane.y);
        let at = [0.5 * (left + right), bottom + TICKS_HEIGHT + 0.5 * NAME_HEIGHT];
        // Guides would show where no cell is drawn.
        page.drawing.area(&self.plot.corners(), PAPER);
        page.drawing.text("x and y in the image [px]", at, Pinned::Center, SMALL, GREY);
    }

    pub fn border(&self, page: &mut Page) {
        page.drawing.outline(self.plot, GREY);
    }

    /// A point counted in cells.
    pub fn of_cells(&self, [column, row]: Point) -> Point {
        let Rect { left, top, right, bottom } = self.plot;
        let (columns, rows) = (self.plane.columns as f64, self.plane.rows as f64);
        [left + (right - left) * column / columns, top + (bottom - top) * row / rows]
    }

    /// A pixel of the image.
    pub fn of_pixel(&self, [x, y]: Point) -> Point {
        let [wide, high] = self.plane.size;
        let [columns, rows] = [self.plane.columns, self.plane.rows].map(|count| count as f64);
        self.of_cells([x / wide * columns, y / high * rows])
    }

    /// The middle of a cell.
    pub fn middle(&self, cell: usize) -> Point {
        let [column, row] = self.column_and_row(cell);
        self.of_cells([column as f64 + 0.5, row as f64 + 0.5])
    }

    pub fn column_and_row(&self, cell: usize) -> [usize; 2] {
        [cell % self.plane.columns, cell / self.plane.columns]
    }

    /// How long a px of the image is on the page.
    pub fn scale(&self) -> f64 {
        self.plane.width / self.plane.size[0]
    }

    /// Cells in the colours of their steps; neighbours in a row or column that look the same are one rectangle.
    pub fn cells(
        &self,
        drawing: &mut Drawing,
        steps: &[(usize, usize)],
        color: impl Fn(usize) -> Color,
    ) {
        let drawn: BTreeSet<usize> = steps.iter().map(|(cell, _)| *cell).collect();
        for block in blocks(steps, self.plane.columns) {
            let [first, last] = [[block.first, block.top], [block.end, block.bottom]]
                .map(|at| self.of_cells(at.map(|count| count as f64)));
            let columns = self.plane.columns;
            let is_drawn = |column: usize, row: usize| {
                column < columns && drawn.contains(&(row * columns + column))
            };
            let mut rows = block.top..block.bottom;
            let mut across = block.first..block.end;
            let right = if rows.all(|row| is_drawn(block.end, row)) { OVERLAP } else { 0.0 };
            let below =
                if across.all(|column| is_drawn(column, block.bottom)) { OVERLAP } else { 0.0 };
            let rect = Rect {
                left: first[0],
                top: first[1],
                right: last[0] + right,
                bottom: last[1] + below,
            };
            drawing.area(&rect.corners(), color(block.step));
        }
    }

    /// Slanting lines through these cells.
    pub fn hatch(&self, drawing: &mut Drawing, cells: &[usize], color: Color) {
        for &cell in cells {
            let [column, row] = self.column_and_row(cell).map(|count| count as f64);
            let ends = [[column, row + 1.0], [column + 1.0, row]].map(|at| self.of_cells(at));
            drawing.line(&ends, color, 0.8);
        }
    }

    /// The border between these cells and all others.
    pub fn edge(&self, drawing: &mut Drawing, cells: &[usize], color: Color) {
        let columns = self.plane.columns;
        let is_in: BTreeSet<usize> = cells.iter().copied().collect();
        for upright in [false, true] {
            let (lines, along) =
                if upright { (columns, self.plane.rows) } else { (self.plane.rows, columns) };
            // Inside the image only: its border is drawn anyway.
            for line in 1..lines {
                let cell = |line: usize, at: usize| {
                    if upright { at * columns + line } else { line * columns + at }
                };
                let is_edge = |at: usize| {
                    is_in.contains(&cell(line - 1, at)) != is_in.contains(&cell(line, at))
                };
                for (start, end) in stretches(along, is_edge) {
                    let ends = [start, end].map(|at| {
                        let at = if upright { [line, at] } else { [at, line] };
                        self.of_cells(at.map(|count| count as f64))
                    });
                    drawing.line(&ends, color, 0.7);
                }
            }
        }
    }
}

/// The longest stretches from 0 to `count` where something holds.
fn stretches(count: usize, holds: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    for at in (0..count).filter(|&at| holds(at)) {
        match found.last_mut() {
            Some((_, end)) if *end == at => *end += 1,
            _ => found.push((at, at + 1)),
        }
    }
    found
}

/// Cells of one step that make a rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Block {
    step: usize,
    first: usize,
    end: usize,
    top: usize,
    bottom: usize,
}

/// Rectangles that cover the cells, which come in order, each once.
fn blocks(steps: &[(usize, usize)], columns: usize) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    // Blocks of the row above and of this one.
    let (mut above, mut here): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut row = 0;
    let runs =
        steps.chunk_by(|a, b| a.1 == b.1 && a.0 + 1 == b.0 && a.0 / columns == b.0 / columns);
    for run in runs {
        let (cell, step) = run[0];
        let (first, top) = (cell % columns, cell / columns);
        if top != row {
            above = std::mem::take(&mut here);
            above.retain(|&index| found[index].bottom == top);
            row = top;
        }
        let end = first + run.len();
        let is_same = |index: &&usize| {
            let block = found[**index];
            (block.step, block.first, block.end) == (step, first, end)
        };
        match above.iter().find(is_same) {
            Some(&index) => {
                found[index].bottom += 1;
                here.push(index);
            }
            None => {
                here.push(found.len());
                found.push(Block { step, first, end, top, bottom: top + 1 });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::drawing::Shape;
    use super::super::test_data::spread_over;
    use super::*;

    #[test]
    fn every_cell_has_its_colour_and_nothing_else_is_painted() {
        let font = Font::load().unwrap();
        let spread = spread_over([640, 480], |[x, y]| Some((x + y) / 100.0));
        let plane = Plane::new(&font, [640, 480], spread.grid(), 380.0);
        let place = plane.placed([50.0, 70.0]);
        // Bands, with holes and a ragged edge.
        let is_in = |cell: &usize| cell % 7 != 3 && cell % 60 < 50 - cell / 60 % 4;
        let steps: Vec<(usize, usize)> =
            (0..2700).filter(is_in).map(|cell| (cell, (cell % 60 + cell / 60) / 9)).collect();
        let mut drawing = Drawing::new(500.0);
        let shade = |step: usize| PAPER.toward(GREY, step as f64 / 12.0);
        place.cells(&mut drawing, &steps, shade);
        let on_top = |[x, y]: Point| {
            let covers = |shape: &&Shape| match shape {
                Shape::Area { points, .. } => {
                    let ([left, top], [right, bottom]) = (points[0], points[2]);
                    (left..right).contains(&x) && (top..bottom).contains(&y)
                }
                _ => false,
            };
            drawing.shapes.iter().rfind(covers).map(|shape| match shape {
                Shape::Area { color, .. } => *color,
                _ => unreachable!(),
            })
        };
        let wanted: std::collections::BTreeMap<usize, usize> = steps.iter().copied().collect();
        for cell in 0..2700 {
            let want = wanted.get(&cell).map(|step| shade(*step));
            assert_eq!(on_top(place.middle(cell)), want, "{cell}");
        }
        assert!(drawing.shapes.len() < steps.len() / 2, "{}", drawing.shapes.len());
    }

    #[test]
    fn an_edge_surrounds_its_cells_and_leaves_the_border_of_the_image() {
        let font = Font::load().unwrap();
        let spread = spread_over([640, 480], |_| Some(1.0));
        let plane = Plane::new(&font, [640, 480], spread.grid(), 600.0);
        let mut drawing = Drawing::new(700.0);
        // Cells of 10 x 10: two by two in the corner of the image, and one alone.
        plane.placed([0.0, 0.0]).edge(&mut drawing, &[0, 1, 60, 61, 1000], GREY);
        let length = |shape: &Shape| match shape {
            Shape::Line { points: p, .. } => (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]),
            _ => unreachable!(),
        };
        let total: f64 = drawing.shapes.iter().map(length).sum();
        assert!((total - (20.0 + 20.0 + 40.0)).abs() < 1e-9, "{total}");
        assert_eq!(drawing.shapes.len(), 6);
    }

    #[test]
    fn blocks_cover_every_cell_once_with_its_step() {
        // 10 columns: a square of one step, a row that is longer, a hole, another step, and a row end that must not join.
        let steps: Vec<(usize, usize)> = [
            (2, 1),
            (3, 1),
            (12, 1),
            (13, 1),
            (22, 1),
            (23, 1),
            (24, 1),
            (26, 1),
            (27, 2),
            (29, 2),
            (30, 2),
            (42, 1),
            (43, 1),
        ]
        .to_vec();
        let found = blocks(&steps, 10);
        let mut covered: Vec<(usize, usize)> = found
            .iter()
            .flat_map(|block| {
                let rows = block.top..block.bottom;
                rows.flat_map(move |row| {
                    (block.first..block.end).map(move |column| (row * 10 + column, block.step))
                })
            })
            .collect();
        covered.sort_unstable();
        assert_eq!(covered, steps);
        assert_eq!(found[0], Block { step: 1, first: 2, end: 4, top: 0, bottom: 2 });
        assert_eq!(found.len(), 7);
    }
}
