//! Mean residuals, and the cells of the image that they are over.

use schemars::JsonSchema;
use serde::Serialize;

use crate::camera::Grid;

/// The mean of residuals (projection less measurement), along two directions at right angles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Mean {
    /// How many observations.
    pub count: usize,
    /// The mean along each direction, in px.
    pub px: [f64; 2],
    /// Their standard errors, in px, by what the adjustment lets through of noise.
    pub std_error_px: [f64; 2],
    /// Probability that noise alone is so far from zero or farther, the two directions taken as independent.
    pub p: f64,
}

impl Mean {
    /// Of the sums of so many residuals, with their variances.
    pub(super) fn new(count: usize, sums: [f64; 2], variances: [f64; 2]) -> Self {
        let n = count as f64;
        let parts = [0, 1].map(|axis| (sums[axis].powi(2), variances[axis]));
        let square = parts.iter().filter(|(_, v)| *v > 0.0).map(|(s, v)| s / v).sum::<f64>();
        Self {
            count,
            px: sums.map(|sum| sum / n),
            std_error_px: variances.map(|variance| variance.sqrt() / n),
            // The upper tail of chi-square with two degrees.
            p: (-0.5 * square).exp(),
        }
    }

    /// All of these means together, of runs that share this part of what they observed.
    pub(super) fn together(means: &[Self], shared: f64) -> Self {
        let sum = |of: &dyn Fn(&Self) -> f64| means.iter().map(of).sum::<f64>();
        let sums = [0, 1].map(|axis| sum(&|one| one.count as f64 * one.px[axis]));
        let alike = 1.0 + (means.len() as f64 - 1.0) * shared;
        let variances = [0, 1]
            .map(|axis| alike * sum(&|one| (one.count as f64 * one.std_error_px[axis]).powi(2)));
        Self::new(means.iter().map(|one| one.count).sum(), sums, variances)
    }
}

/// The mean residual in one cell, along x and y.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct CellMean {
    /// The cell, counted row by row from the top left.
    pub cell: usize,
    /// The pixel in the middle of what the image has of it.
    pub middle: [f64; 2],
    /// Along x and y.
    #[serde(flatten)]
    pub mean: Mean,
}

/// The mean residual in a ring about the principal point, outward and along the tangent (from x towards y).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct RingMean {
    /// The middle of the ring's radii, in px.
    pub radius_px: f64,
    /// Outward and along the tangent.
    #[serde(flatten)]
    pub mean: Mean,
}

/// Cells of the image, each so many by so many of those of the grid in which spreads are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cells {
    grid: Grid,
    size: [f64; 2],
    block: usize,
}

impl Cells {
    /// Over an image, from twelve in a row, the standard, to two.
    pub(super) fn sizes(width: u64, height: u64) -> impl Iterator<Item = Self> {
        let (grid, size) = (Grid::new(width, height), [width, height].map(|side| side as f64));
        [5, 6, 10, 15, 20, 30].into_iter().map(move |block| Self { grid, size, block })
    }

    pub(super) fn columns(&self) -> usize {
        self.grid.columns().div_ceil(self.block)
    }

    pub(super) fn rows(&self) -> usize {
        self.grid.rows().div_ceil(self.block)
    }

    pub(super) fn count(&self) -> usize {
        self.columns() * self.rows()
    }

    /// Width and height of a cell in px; the last ones of a row or column may be cut off.
    pub(super) fn cell_px(&self) -> [f64; 2] {
        let fine = [self.grid.columns(), self.grid.rows()];
        [0, 1].map(|axis| self.block as f64 * self.size[axis] / fine[axis] as f64)
    }

    /// The cell of a pixel; none outside the image.
    pub(super) fn at(&self, pixel: [f64; 2]) -> Option<usize> {
        let fine = self.grid.cell_at(pixel)?;
        let [column, row] = [fine % self.grid.columns(), fine / self.grid.columns()];
        Some(row / self.block * self.columns() + column / self.block)
    }

    /// How many of these pixels are in each cell.
    pub(super) fn counts(&self, pixels: &[[f64; 2]]) -> Vec<usize> {
        let mut counts = vec![0; self.count()];
        pixels.iter().filter_map(|pixel| self.at(*pixel)).for_each(|cell| counts[cell] += 1);
        counts
    }

    pub(super) fn mean(&self, cell: usize, mean: Mean) -> CellMean {
        let at = [cell % self.columns(), cell / self.columns()].map(|index| index as f64);
        let side = self.cell_px();
        let middle = [0, 1].map(|axis| {
            let end = ((at[axis] + 1.0) * side[axis]).min(self.size[axis]);
            0.5 * (at[axis] * side[axis] + end)
        });
        CellMean { cell, middle, mean }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_hold_the_pixels_around_their_middles_and_cover_the_image_once() {
        for (width, height) in [(640, 480), (752, 480), (480, 640), (1000, 30)] {
            for cells in Cells::sizes(width, height) {
                let mean = Mean::new(1, [0.0; 2], [1.0; 2]);
                let middles = (0..cells.count()).map(|cell| cells.mean(cell, mean).middle);
                let found: Vec<Option<usize>> = middles.map(|at| cells.at(at)).collect();
                assert_eq!(found, (0..cells.count()).map(Some).collect::<Vec<_>>());
                let [x, y] = cells.cell_px();
                let covered = x * cells.columns() as f64 >= width as f64 - 1e-9
                    && y * cells.rows() as f64 >= height as f64 - 1e-9;
                assert!(covered, "{width} x {height}");
            }
        }
        assert_eq!(Cells::sizes(640, 480).next().map(|c| [c.columns(), c.rows()]), Some([12, 9]));
    }

    #[test]
    fn runs_that_share_all_know_no_more_than_one() {
        let one = Mean::new(20, [10.0, -4.0], [9.0, 1.0]);
        let shared = Mean::together(&[one; 4], 1.0);
        let apart = Mean::together(&[one; 4], 0.0);
        for axis in 0..2 {
            assert!((shared.px[axis] - one.px[axis]).abs() < 1e-15);
            assert!((shared.std_error_px[axis] - one.std_error_px[axis]).abs() < 1e-15);
            assert!((apart.std_error_px[axis] - 0.5 * one.std_error_px[axis]).abs() < 1e-15);
        }
        assert_eq!(shared.count, 80);
        // chi-square of two degrees: exp(-(100 / 9 + 16) / 2)
        assert!((one.p / (-0.5 * (100.0 / 9.0 + 16.0_f64)).exp() - 1.0).abs() < 1e-12);
    }
}
