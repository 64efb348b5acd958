//! Cholesky's factorisation of a sparse symmetric matrix of square tiles: all of it, or only of its leading columns.
//!
//! A few columns at a time, each tile takes what the columns before give. A full matrix is the case in which all tiles
//! are there. Each number is computed by one thread in one order: the same bits for any number of threads.

use std::ops::Range;

use multiversion::multiversion;
use rayon::prelude::*;

use super::order::Graph;
use super::products::{add_scaled, scaled};

/// Rows and columns of a tile: two of them and a part of a third stay in a core's own cache. A multiple of the six unknowns of a pose.
pub(super) const TILE: usize = 48;
/// Rows and columns of what stays in registers while a product is summed: twelve of the sixteen that there are.
const LANES: usize = 8;
const COLUMNS: usize = 6;

/// Columns of tiles that take from those before them together, so that what is given is fetched once for all of them.
const PANEL: usize = 4;
/// Columns of which the tiles that give to a panel stay in a core's own cache.
const GIVERS: usize = 12;

/// Column by column.
type Tile = [[f64; TILE]; TILE];

/// Which tiles there are.
#[derive(Debug, Clone, Default)]
pub(super) struct Pattern {
    /// Of each column the rows from the diagonal on, ascending.
    rows: Vec<Vec<usize>>,
    /// Where a tile is in its column; the pairs (0, 0), (0, 1), (1, 1), (0, 2), ...
    places: Vec<u32>,
}

const NO_TILE: u32 = u32::MAX;

impl Pattern {
    /// Those of the factor of a matrix which has a tile wherever two nodes are neighbours.
    pub(super) fn of(mut graph: Graph) -> Self {
        let count = graph.nodes();
        let mut made = Self {
            rows: Vec::with_capacity(count),
            places: vec![NO_TILE; count * (count + 1) / 2],
        };
        for column in 0..count {
            let below = graph.eliminate(column);
            let rows = std::iter::once(column).chain(below);
            let rows: Vec<usize> = rows.collect();
            for (&row, place) in rows.iter().zip(0..) {
                made.places[row * (row + 1) / 2 + column] = place;
            }
            made.rows.push(rows);
        }
        made
    }

    /// How many bytes the matrix takes.
    pub(super) fn bytes(&self) -> usize {
        let tiles: usize = self.rows.iter().map(Vec::len).sum();
        size_of::<Tile>() * tiles + size_of::<u32>() * self.places.len()
    }

    /// The rows of a column, from the diagonal on.
    #[cfg(test)]
    pub(super) fn column(&self, column: usize) -> &[usize] {
        &self.rows[column]
    }

    /// Where the tile of this row and column, row >= column, is in its column.
    fn place(&self, row: usize, column: usize) -> Option<usize> {
        let place = self.places[row * (row + 1) / 2 + column];
        (place != NO_TILE).then_some(place as usize)
    }

    /// Whether some of these columns take something from the one before them.
    fn gives(&self, giver: usize, columns: &Range<usize>) -> bool {
        columns.clone().any(|column| self.place(column, giver).is_some())
    }

    /// Takes what a column gives from tiles of one row.
    fn give(&self, giver: usize, tiles: &[Tile], targets: &mut [Target<'_>]) {
        let Some(left) = targets.first().and_then(|one| self.place(one.row, giver)) else { return };
        for target in targets {
            if let Some(right) = self.place(target.column, giver) {
                take_product(target.tile, &tiles[left], &tiles[right]);
            }
        }
    }
}

/// A tile that takes what other columns give.
struct Target<'a> {
    row: usize,
    column: usize,
    tile: &'a mut Tile,
}

/// A symmetric matrix, of which the lower triangle counts, and then its factor.
#[derive(Debug, Clone)]
pub(super) struct Tiles {
    pattern: Pattern,
    columns: Vec<Vec<Tile>>,
    /// One over each pivot; zero where a direction is not determined.
    inverse_pivots: Vec<[f64; TILE]>,
}

impl Tiles {
    pub(super) fn new(pattern: Pattern) -> Self {
        let column = |rows: &Vec<usize>| vec![[[0.0; TILE]; TILE]; rows.len()];
        Self {
            columns: pattern.rows.iter().map(column).collect(),
            inverse_pivots: vec![[0.0; TILE]; pattern.rows.len()],
            pattern,
        }
    }

    pub(super) fn clear(&mut self) {
        self.columns.par_iter_mut().for_each(|tiles| tiles.fill([[0.0; TILE]; TILE]));
    }

    /// How many rows there are.
    pub(super) fn size(&self) -> usize {
        TILE * self.columns.len()
    }

    /// How many columns of tiles there are.
    pub(super) fn tiles(&self) -> usize {
        self.columns.len()
    }

    /// Adds a block within one tile of the lower triangle, its first entry in this row and column; the block comes column by column.
    #[inline(always)]
    pub(super) fn add_columns<'a>(
        &mut self,
        row: usize,
        column: usize,
        block: impl Iterator<Item = &'a [f64]>,
    ) {
        let Some(tile) = self.tile_mut(row, column) else { return };
        for (values, block) in tile[column % TILE..].iter_mut().zip(block) {
            for (sum, value) in values[row % TILE..].iter_mut().zip(block) {
                *sum += value;
            }
        }
    }

    /// The same for a block that comes row by row.
    #[inline(always)]
    pub(super) fn add_rows<'a>(
        &mut self,
        row: usize,
        column: usize,
        block: impl Iterator<Item = &'a [f64]>,
    ) {
        let Some(tile) = self.tile_mut(row, column) else { return };
        for (at, block) in block.enumerate() {
            for (values, value) in tile[column % TILE..].iter_mut().zip(block) {
                values[row % TILE + at] += value;
            }
        }
    }

    /// The tile with this entry.
    #[inline(always)]
    fn tile_mut(&mut self, row: usize, column: usize) -> Option<&mut Tile> {
        let place = self.pattern.place(row / TILE, column / TILE)?;
        self.columns[column / TILE].get_mut(place)
    }

    /// An entry of the lower triangle.
    pub(super) fn entry(&self, row: usize, column: usize) -> f64 {
        let place = self.pattern.place(row / TILE, column / TILE);
        place.map_or(0.0, |at| self.columns[column / TILE][at][column % TILE][row % TILE])
    }

    /// Multiplies each entry by the scales of its row and column, and gives the diagonal what `diagonal` makes of it.
    pub(super) fn scale(&mut self, scales: &[f64], diagonal: impl Fn(usize, f64) -> f64 + Sync) {
        let (scales, _) = scales.as_chunks::<TILE>();
        let columns = self.columns.par_iter_mut().zip(&self.pattern.rows).enumerate();
        columns.for_each(|(column, (tiles, rows))| {
            for (tile, &row) in tiles.iter_mut().zip(rows) {
                for (values, own) in tile.iter_mut().zip(&scales[column]) {
                    for (value, scale) in values.iter_mut().zip(&scales[row]) {
                        *value *= own * scale;
                    }
                }
            }
            for (at, values) in tiles[0].iter_mut().enumerate() {
                values[at] = diagonal(TILE * column + at, values[at]);
            }
        });
    }

    /// Eliminates these columns of tiles, which come after those that are eliminated; what is left of the columns after them is
    /// their Schur complement. A pivot up to `null` means a direction that is not determined: it is left out, and counted; none
    /// when `null` is none and there is such a pivot.
    pub(super) fn factor(&mut self, eliminated: Range<usize>, null: Option<f64>) -> Option<usize> {
        let Range { start, end } = eliminated;
        let mut nullity = 0;
        for first in (start..self.columns.len()).step_by(PANEL) {
            let panel = first..(first + PANEL).min(self.columns.len());
            let known = first.min(end);
            self.take_from(panel.clone(), start..known);
            for column in panel {
                self.take_from(column..column + 1, known..column.min(end));
                if column < end {
                    nullity += self.finish(column, null)?;
                }
            }
        }
        Some(nullity)
    }

    /// Takes from the tiles of some columns what eliminated columns before them give.
    fn take_from(&mut self, panel: Range<usize>, givers: Range<usize>) {
        let Self { pattern, columns, .. } = self;
        let (before, rest) = columns.split_at_mut(panel.start);
        let givers: Vec<usize> = givers.filter(|&giver| pattern.gives(giver, &panel)).collect();
        let mut targets = Vec::new();
        for (column, tiles) in panel.zip(rest) {
            let rows = pattern.rows[column].iter();
            targets.extend(rows.zip(tiles).map(|(&row, tile)| Target { row, column, tile }));
        }
        targets.sort_by_key(|target| target.row);
        let mut rows: Vec<&mut [Target<'_>]> =
            targets.chunk_by_mut(|a, b| a.row == b.row).collect();
        for givers in givers.chunks(GIVERS) {
            rows.par_iter_mut().for_each(|targets| {
                givers.iter().for_each(|&giver| pattern.give(giver, &before[giver], targets));
            });
        }
    }

    /// Factors the tile on the diagonal, and eliminates it from those below.
    fn finish(&mut self, column: usize, null: Option<f64>) -> Option<usize> {
        let pivots = &mut self.inverse_pivots[column];
        let (corner, below) = self.columns[column].split_at_mut(1);
        let nullity = factor_corner(&mut corner[0], pivots, null)?;
        let (corner, pivots) = (&corner[0], &*pivots);
        below.par_iter_mut().for_each(|tile| eliminate_corner(tile, corner, pivots));
        Some(nullity)
    }

    /// Solves L L^T x = right; what is not determined stays zero.
    pub(super) fn solve(&self, right: &mut [f64]) {
        let (right, _) = right.as_chunks_mut::<TILE>();
        for (column, rows) in self.pattern.rows.iter().enumerate() {
            let tiles = &self.columns[column];
            solve_corner(&tiles[0], &self.inverse_pivots[column], &mut right[column]);
            let known = right[column];
            for (tile, &row) in tiles.iter().zip(rows).skip(1) {
                take_times(&mut right[row], tile, &known);
            }
        }
        for (column, rows) in self.pattern.rows.iter().enumerate().rev() {
            let tiles = &self.columns[column];
            let mut own = right[column];
            for (tile, &row) in tiles.iter().zip(rows).skip(1) {
                take_transposed_times(&mut own, tile, &right[row]);
            }
            solve_transposed_corner(&tiles[0], &self.inverse_pivots[column], &mut own);
            right[column] = own;
        }
    }
}

/// target -= left right^T
#[multiversion(targets("x86_64+avx2+fma"))]
fn take_product(target: &mut Tile, left: &Tile, right: &Tile) {
    if multiversion::target::target_cfg_f!(target_feature = "fma") {
        product::<true>(target, left, right);
    } else {
        product::<false>(target, left, right);
    }
}

#[inline(always)]
fn product<const FUSED: bool>(target: &mut Tile, left: &Tile, right: &Tile) {
    for group in 0..TILE / LANES {
        for first in (0..TILE).step_by(COLUMNS) {
            let mut sums = [[0.0; LANES]; COLUMNS];
            for (left, right) in left.iter().zip(right) {
                let left = &left.as_chunks::<LANES>().0[group];
                for (column, sum) in sums.iter_mut().enumerate() {
                    add_scaled::<LANES, FUSED>(sum, right[first + column], left);
                }
            }
            for (values, sum) in target[first..first + COLUMNS].iter_mut().zip(&sums) {
                let values = &mut values.as_chunks_mut::<LANES>().0[group];
                for (value, sum) in values.iter_mut().zip(sum) {
                    *value -= sum;
                }
            }
        }
    }
}

/// The factor of the tile itself, in its lower triangle; what is above it means nothing.
#[multiversion(targets("x86_64+avx2+fma"))]
fn factor_corner(
    tile: &mut Tile,
    inverse_pivots: &mut [f64; TILE],
    null: Option<f64>,
) -> Option<usize> {
    let mut nullity = 0;
    for at in 0..TILE {
        let (own, later) = tile[at..].split_at_mut(1);
        let rest = own[0][at];
        let mut inverse = 0.0;
        if rest > null.unwrap_or(0.0) {
            inverse = 1.0 / rest.sqrt();
        } else {
            null?;
            nullity += 1;
        }
        inverse_pivots[at] = inverse;
        own[0] = scaled(inverse, &own[0]);
        for (place, values) in later.iter_mut().enumerate() {
            add_scaled::<TILE, false>(values, -own[0][at + 1 + place], &own[0]);
        }
    }
    Some(nullity)
}

/// tile L^-T, L the corner.
#[multiversion(targets("x86_64+avx2+fma"))]
fn eliminate_corner(tile: &mut Tile, corner: &Tile, inverse_pivots: &[f64; TILE]) {
    for at in 0..TILE {
        let (known, rest) = tile.split_at_mut(at);
        let mut target = rest[0];
        for (values, l) in known.iter().zip(corner) {
            add_scaled::<TILE, false>(&mut target, -l[at], values);
        }
        rest[0] = scaled(inverse_pivots[at], &target);
    }
}

/// L^-1 right, L the corner.
fn solve_corner(corner: &Tile, inverse_pivots: &[f64; TILE], right: &mut [f64; TILE]) {
    for at in 0..TILE {
        right[at] *= inverse_pivots[at];
        let known = right[at];
        for (value, l) in right[at + 1..].iter_mut().zip(&corner[at][at + 1..]) {
            *value -= l * known;
        }
    }
}

/// L^-T right, L the corner.
fn solve_transposed_corner(corner: &Tile, inverse_pivots: &[f64; TILE], right: &mut [f64; TILE]) {
    for at in (0..TILE).rev() {
        let below = corner[at][at + 1..].iter().zip(&right[at + 1..]);
        let known: f64 = below.map(|(l, x)| l * x).sum();
        right[at] = (right[at] - known) * inverse_pivots[at];
    }
}

/// target -= tile right
#[multiversion(targets("x86_64+avx2+fma"))]
fn take_times(target: &mut [f64; TILE], tile: &Tile, right: &[f64; TILE]) {
    for (values, by) in tile.iter().zip(right) {
        add_scaled::<TILE, false>(target, -by, values);
    }
}

/// target -= tile^T right
#[multiversion(targets("x86_64+avx2+fma"))]
fn take_transposed_times(target: &mut [f64; TILE], tile: &Tile, right: &[f64; TILE]) {
    for (value, column) in target.iter_mut().zip(tile) {
        let mut sums = [0.0; LANES];
        let groups = column.as_chunks::<LANES>().0.iter().zip(right.as_chunks::<LANES>().0);
        for (column, right) in groups {
            for lane in 0..LANES {
                sums[lane] += column[lane] * right[lane];
            }
        }
        *value -= sums.iter().sum::<f64>();
    }
}

#[cfg(test)]
mod tests;
