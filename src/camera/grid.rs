//! An image as a grid of cells, at whose centres lenses are compared.

use nalgebra::Vector2;

const COLUMNS: usize = 60;
/// Ten times as high as wide: cells of images beyond that are high too, or a mistaken size would never end.
const MOST_ROWS: usize = 10 * COLUMNS;

/// 60 columns of cells over an image, about square. The image spans 0 to its width and 0 to its height, as the centre of its
/// first pixel is (0.5, 0.5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    cell: Vector2<f64>,
    rows: usize,
}

impl Grid {
    /// Over an image of this size in px.
    pub fn new(width: u64, height: u64) -> Self {
        let [wide, high, columns] = [u128::from(width.max(1)), u128::from(height), COLUMNS as u128];
        let rows = (2 * columns * high + wide) / (2 * wide);
        let rows = usize::try_from(rows).map_or(MOST_ROWS, |rows| rows.clamp(1, MOST_ROWS));
        let cell = Vector2::new(width as f64 / COLUMNS as f64, height as f64 / rows as f64);
        Self { cell, rows }
    }

    /// Cells in a row.
    pub fn columns(&self) -> usize {
        COLUMNS
    }

    /// Cells in a column.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many cells.
    pub fn cell_count(&self) -> usize {
        COLUMNS * self.rows
    }

    /// The centre of a cell; cells count row by row from the top left.
    pub fn pixel(&self, index: usize) -> Vector2<f64> {
        let at = Vector2::new((index % COLUMNS) as f64, (index / COLUMNS) as f64);
        at.add_scalar(0.5).component_mul(&self.cell)
    }

    /// The cell that a pixel lies in; none outside the image.
    pub fn cell_at(&self, [x, y]: [f64; 2]) -> Option<usize> {
        let at = [x / self.cell.x, y / self.cell.y];
        let is_inside = at[0] >= 0.0 && at[1] >= 0.0;
        // Whole numbers from 0 on; what is too large for one saturates and lies outside.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let [column, row] = at.map(|at| at.floor() as usize);
        (is_inside && column < COLUMNS && row < self.rows).then(|| row * COLUMNS + column)
    }

    /// The centres of all cells, in order.
    pub fn pixels(&self) -> impl Iterator<Item = Vector2<f64>> {
        let grid = *self;
        (0..self.cell_count()).map(move |index| grid.pixel(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_square_where_the_size_allows_and_nearly_so_elsewhere() {
        for (width, height, rows) in
            [(640, 480, 45), (752, 480, 38), (1024, 1024, 60), (480, 640, 80), (6000, 10, 1)]
        {
            let grid = Grid::new(width, height);
            assert_eq!((grid.columns(), grid.rows()), (60, rows), "{width} x {height}");
            assert_eq!(grid.pixels().count(), grid.cell_count());
        }
    }

    #[test]
    fn centres_lie_half_a_cell_inside_the_image_and_row_after_row() {
        let grid = Grid::new(1200, 900);
        assert_eq!(grid.pixel(0), Vector2::new(10.0, 10.0));
        assert_eq!(grid.pixel(1), Vector2::new(30.0, 10.0));
        assert_eq!(grid.pixel(60), Vector2::new(10.0, 30.0));
        assert_eq!(grid.pixels().last(), Some(Vector2::new(1190.0, 890.0)));
        let mean = grid.pixels().sum::<Vector2<f64>>() / grid.cell_count() as f64;
        assert!((mean - Vector2::new(600.0, 450.0)).norm() < 1e-9, "{mean}");
    }

    #[test]
    fn every_centre_lies_in_its_cell_and_what_is_outside_in_none() {
        let grid = Grid::new(752, 480);
        for (index, pixel) in grid.pixels().enumerate() {
            assert_eq!(grid.cell_at([pixel.x, pixel.y]), Some(index));
        }
        for outside in [[-0.1, 5.0], [5.0, -0.1], [752.0, 5.0], [5.0, 480.0], [f64::NAN, 5.0]] {
            assert_eq!(grid.cell_at(outside), None, "{outside:?}");
        }
    }

    #[test]
    fn a_mistaken_size_makes_no_endless_grid() {
        for (width, height) in [(1, u64::MAX), (u64::MAX, 1), (0, 0)] {
            let grid = Grid::new(width, height);
            assert!((60..=36_000).contains(&grid.cell_count()), "{width} x {height}");
            assert!(grid.pixels().all(|pixel| pixel.iter().all(|value| value.is_finite())));
        }
    }
}
