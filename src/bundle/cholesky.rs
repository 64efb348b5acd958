//! Cholesky's factorisation of a dense symmetric matrix, in place, by blocks of columns; all or only its leading columns.
//!
//! Row after row, lower triangle. Each number is computed by one thread in one order: the same bits for any number of threads.

use multiversion::multiversion;
use rayon::prelude::*;

use super::products::{add_scaled, scaled};

/// Columns eliminated at a time: a block of them and eight rows stay in the nearest cache.
const BLOCK: usize = 48;
/// Rows and columns of the tile that stays in registers.
const TILE: usize = 4;
/// Lanes of a tile.
const LANES: usize = 8;

/// A symmetric matrix, of which the lower triangle counts, and then its factor.
#[derive(Debug, Clone)]
pub(crate) struct Dense {
    size: usize,
    values: Vec<f64>,
    /// One over each pivot; zero where a direction is not determined.
    inverse_pivots: Vec<f64>,
    /// The columns that are eliminated, by groups of eight rows: row groups of BLOCK x LANES.
    panel: Vec<[f64; LANES]>,
    /// Which groups have a number other than zero there: images that share no point leave most of a long sequence empty.
    is_filled: Vec<bool>,
}

impl Dense {
    pub(crate) fn new(size: usize) -> Self {
        Self {
            size,
            values: vec![0.0; size * size],
            inverse_pivots: vec![0.0; size],
            panel: vec![[0.0; LANES]; size.div_ceil(LANES) * BLOCK],
            is_filled: vec![false; size.div_ceil(LANES)],
        }
    }

    /// The row of this index, as far as its diagonal.
    #[inline(always)]
    pub(crate) fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.size..=row * self.size + row]
    }

    /// The row of this index, as far as its diagonal.
    #[inline(always)]
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.values[row * self.size..=row * self.size + row]
    }

    /// The row of this index in full; what is right of its diagonal counts for nothing.
    #[inline(always)]
    pub(crate) fn whole_row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.values[row * self.size..][..self.size]
    }

    /// Eliminates the first columns; what is left of the others is their Schur complement. A pivot up to `null` means a direction
    /// that is not determined: it is left out, and counted; none when `null` is none and there is such a pivot.
    pub(crate) fn factor(
        &mut self,
        columns: std::ops::Range<usize>,
        null: Option<f64>,
    ) -> Option<usize> {
        let mut nullity = 0;
        let mut start = columns.start;
        while start < columns.end {
            let end = (start + BLOCK).min(columns.end);
            nullity += self.factor_corner(start, end, null)?;
            self.eliminate_below(start, end);
            start = end;
        }
        Some(nullity)
    }

    /// The block on the diagonal.
    fn factor_corner(&mut self, start: usize, end: usize, null: Option<f64>) -> Option<usize> {
        let mut nullity = 0;
        for row in start..end {
            for column in start..=row {
                let (left, right) =
                    (&self.row(row)[start..column], &self.row(column)[start..column]);
                let sum: f64 = left.iter().zip(right).map(|(a, b)| a * b).sum();
                let rest = self.row(row)[column] - sum;
                if column < row {
                    self.row_mut(row)[column] = rest * self.inverse_pivots[column];
                } else if rest > null.unwrap_or(0.0) {
                    let pivot = rest.sqrt();
                    self.row_mut(row)[row] = pivot;
                    self.inverse_pivots[row] = 1.0 / pivot;
                } else {
                    null?;
                    nullity += 1;
                    self.inverse_pivots[row] = 0.0;
                    self.row_mut(row)[row] = 0.0;
                }
            }
        }
        Some(nullity)
    }

    /// What the block's columns are below it, and what that takes from all that is to the right.
    fn eliminate_below(&mut self, start: usize, end: usize) {
        let (size, width) = (self.size, end - start);
        let Self { values, inverse_pivots, panel, is_filled, .. } = self;
        let (corner, below) = values.split_at_mut(end * size);
        let corner = &corner[start * size + start..];
        let pivots = &inverse_pivots[start..end];
        let groups = below.par_chunks_mut(LANES * size).zip(panel.par_chunks_mut(BLOCK));
        groups.zip(is_filled.par_iter_mut()).for_each(|((rows, tile), is_filled)| {
            let mut columns = rows.chunks_exact(size).flat_map(|row| &row[start..end]);
            *is_filled = columns.any(|value| value.abs() > 0.0 || value.is_nan());
            if *is_filled {
                for (lane, row) in rows.chunks_exact(size).enumerate() {
                    (0..width).for_each(|column| tile[column][lane] = row[start + column]);
                }
                solve_tile(tile, corner, size, pivots);
                for (lane, row) in rows.chunks_exact_mut(size).enumerate() {
                    (0..width).for_each(|column| row[start + column] = tile[column][lane]);
                }
            }
        });
        let panel = Panel { tiles: panel, is_filled, width };
        below.par_chunks_mut(LANES * size).enumerate().for_each(|(group, rows)| {
            if panel.is_filled[group] {
                update_rows(rows, size, end, group, &panel);
            }
        });
    }
}

/// The columns that are eliminated.
struct Panel<'a> {
    tiles: &'a [[f64; LANES]],
    is_filled: &'a [bool],
    width: usize,
}

/// Forward substitution for eight rows at a time.
#[multiversion(targets("x86_64+avx2+fma"))]
fn solve_tile(tile: &mut [[f64; LANES]], corner: &[f64], size: usize, inverse_pivots: &[f64]) {
    for (column, pivot) in inverse_pivots.iter().enumerate() {
        let (known, rest) = tile.split_at_mut(column);
        let mut target = rest[0];
        for (l, known) in corner[column * size..].iter().zip(known) {
            add_scaled::<LANES, false>(&mut target, -l, known);
        }
        rest[0] = scaled(*pivot, &target);
    }
}

/// rows -= rows of the panel times its transpose, as far as the diagonal and a little beyond it.
#[multiversion(targets("x86_64+avx2+fma"))]
fn update_rows(rows: &mut [f64], size: usize, end: usize, group: usize, panel: &Panel<'_>) {
    if multiversion::target::target_cfg_f!(target_feature = "fma") {
        update::<true>(rows, size, end, group, panel);
    } else {
        update::<false>(rows, size, end, group, panel);
    }
}

#[inline(always)]
fn update<const FUSED: bool>(
    rows: &mut [f64],
    size: usize,
    end: usize,
    group: usize,
    panel: &Panel<'_>,
) {
    let left = &panel.tiles[group * BLOCK..][..panel.width];
    for other in (0..=group).filter(|&other| panel.is_filled[other]) {
        let right = &panel.tiles[other * BLOCK..][..panel.width];
        let first = end + other * LANES;
        for half in 0..LANES / TILE {
            let mut sums = [[0.0; LANES]; TILE];
            for (left, right) in left.iter().zip(right) {
                for (row, sum) in sums.iter_mut().enumerate() {
                    add_scaled::<LANES, FUSED>(sum, left[half * TILE + row], right);
                }
            }
            for (row, sum) in rows.chunks_exact_mut(size).skip(half * TILE).zip(&sums) {
                for (value, sum) in row[first..].iter_mut().zip(sum) {
                    *value -= sum;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// A positive definite matrix of this size, ill-conditioned enough to show faults.
    fn example(size: usize) -> DMatrix<f64> {
        let factor = DMatrix::from_fn(size, size, |row, column| {
            ((row * 7 + column * 13) as f64 * 0.37).sin()
                / (1.0 + (row as f64 - column as f64).abs())
        });
        &factor * factor.transpose() + DMatrix::identity(size, size) * 1e-3
    }

    fn filled(matrix: &DMatrix<f64>) -> Dense {
        let mut dense = Dense::new(matrix.nrows());
        for row in 0..matrix.nrows() {
            for column in 0..=row {
                dense.row_mut(row)[column] = matrix[(row, column)];
            }
        }
        dense
    }

    #[test]
    fn what_is_left_is_the_schur_complement() {
        let (size, first) = (103, 90);
        let matrix = example(size);
        let mut dense = filled(&matrix);
        assert_eq!(dense.factor(0..first, Some(1e-14)), Some(0));
        let part = |rows: std::ops::Range<usize>, columns: std::ops::Range<usize>| {
            matrix.view((rows.start, columns.start), (rows.len(), columns.len())).into_owned()
        };
        let corner = part(0..first, 0..first).try_inverse().unwrap();
        let side = part(first..size, 0..first);
        let schur = part(first..size, first..size) - &side * corner * side.transpose();
        for row in first..size {
            for column in first..=row {
                let wanted = schur[(row - first, column - first)];
                assert!((dense.row(row)[column] - wanted).abs() < 1e-11, "{row} {column}");
            }
        }
    }

    #[test]
    fn directions_that_are_not_determined_are_counted_and_left_out() {
        // Of rank 60: three rows repeat others.
        let matrix = example(60).resize(63, 63, 0.0);
        let map = |index: usize| if index < 60 { index } else { index - 30 };
        let matrix = DMatrix::from_fn(63, 63, |row, column| matrix[(map(row), map(column))]);
        let mut dense = filled(&matrix);
        assert_eq!(dense.factor(0..63, Some(1e-12)), Some(3));
        assert!((60..63).all(|row| dense.row(row)[row].abs() < 1e-300));
    }
}
