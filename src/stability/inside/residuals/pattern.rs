//! A pattern in what an adjustment leaves: mean residuals by cell of the image, and along radius and tangent by ring.
//!
//! s = Z^T r, with a column of Z for x and for y in each cell, for radius and for tangent in each ring. What moved takes its part of
//! any pattern: Cov s = sigma^2 V, V = Z^T (1 - H) Z. Of independent noise standard errors and test are therefore exact.

use nalgebra::{DMatrix, DVector, Vector3};

use super::means::{CellMean, Cells, Mean, RingMean};
use super::{Means, ResidualsInRun, Tails};
use crate::bundle::{CameraOutcome, Entry, Observation, Outcome, Probe};
use crate::stats::f_tail;

/// Rings from the principal point to the corner furthest from the image's centre.
const RINGS: usize = 10;
/// A mean of fewer residuals is not yet normal, whatever its noise.
const FEWEST: usize = 10;
/// Cells are so large that half of those with an observation have this many: the standard error of their mean is then a fifth of the
/// noise or less.
const MEDIAN: usize = 30;
/// Products of the columns with all poses are kept at a time: more numbers than this would outweigh a large adjustment itself.
const MOST_PRODUCTS: usize = 4_000_000;

/// The columns of one camera's pattern.
pub(in super::super) struct Pattern<'a> {
    pub camera: &'a CameraOutcome,
    cells: Cells,
    centre: [f64; 2],
    ring_px: f64,
    /// Observations in each ring and each cell, and their first column where there are enough.
    of_rings: Vec<(usize, Option<usize>)>,
    of_cells: Vec<(usize, Option<usize>)>,
    /// The pattern's own share of all columns.
    columns: std::ops::Range<usize>,
}

/// The patterns of all cameras, their columns from this one on, and no more than so many.
pub(in super::super) fn patterns<'a>(
    outcome: &'a Outcome,
    observations: &[Observation],
    first: usize,
    most: usize,
) -> Vec<Pattern<'a>> {
    let used = outcome.cameras.iter().filter(|camera| camera.images > 0).collect::<Vec<_>>();
    let most = most.saturating_sub(first).min(MOST_PRODUCTS / (6 * outcome.images).max(1));
    let share = most / used.len().max(1);
    let mut next = first;
    let mut all = Vec::new();
    for camera in used {
        let own = observations.iter().filter(|seen| seen.camera == camera.id);
        let pixels: Vec<[f64; 2]> = own.map(projected).collect();
        if let Some(pattern) = Pattern::new(camera, &pixels, next, share) {
            next = pattern.columns.end;
            all.push(pattern);
        }
    }
    all
}

/// How many columns there are, with those before the patterns.
pub(in super::super) fn end(patterns: &[Pattern<'_>], first: usize) -> usize {
    patterns.last().map_or(first, |pattern| pattern.columns.end)
}

/// Where the point is projected to: unlike where it was measured, that is independent of the residual.
fn projected(seen: &Observation) -> [f64; 2] {
    [0, 1].map(|axis| seen.pixel[axis] + seen.residual[axis])
}

impl<'a> Pattern<'a> {
    /// In the finest cells that have observations enough and need no more columns than these; none where no cells do.
    fn new(
        camera: &'a CameraOutcome,
        pixels: &[[f64; 2]],
        first: usize,
        most: usize,
    ) -> Option<Self> {
        let [wide, high] = [camera.after.width, camera.after.height].map(|side| side as f64);
        let is_fine = |cells: &Cells| {
            let mut counts: Vec<usize> =
                cells.counts(pixels).into_iter().filter(|&count| count > 0).collect();
            counts.sort_unstable();
            let is_enough = counts.get(counts.len() / 2).is_some_and(|&count| count >= MEDIAN);
            is_enough && 2 * (cells.count() + RINGS) <= most
        };
        let cells = Cells::sizes(camera.after.width, camera.after.height).find(is_fine)?;
        let lens = &camera.after.intrinsics;
        // Some models look along -z.
        let axis =
            [1.0, -1.0].into_iter().find_map(|z| lens.project(&Vector3::new(0.0, 0.0, z)).ok());
        let mut pattern = Self {
            camera,
            of_cells: cells.counts(pixels).into_iter().map(|count| (count, None)).collect(),
            cells,
            centre: axis.map_or([wide / 2.0, high / 2.0], Into::into),
            ring_px: wide.hypot(high) / 2.0 / RINGS as f64,
            of_rings: vec![(0, None); RINGS],
            columns: first..first,
        };
        for pixel in pixels {
            if let Some((ring, _)) = pattern.ring(*pixel) {
                pattern.of_rings[ring].0 += 1;
            }
        }
        let means = pattern.of_rings.iter_mut().chain(&mut pattern.of_cells);
        for (_, column) in means.filter(|(count, _)| *count >= FEWEST) {
            *column = Some(pattern.columns.end);
            pattern.columns.end += 2;
        }
        Some(pattern)
    }

    /// The ring of a pixel, and the way outward there.
    fn ring(&self, pixel: [f64; 2]) -> Option<(usize, [f64; 2])> {
        let [x, y] = [0, 1].map(|axis| pixel[axis] - self.centre[axis]);
        let radius = x.hypot(y);
        // A count from 0 on; what is too large for one saturates and is no ring.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let ring = (radius / self.ring_px) as usize;
        (radius > 0.0 && ring < RINGS).then(|| (ring, [x / radius, y / radius]))
    }

    /// What an observation has in the pattern's columns.
    pub fn add_entries(&self, seen: &Observation, entries: &mut Vec<Entry>) {
        if seen.camera != self.camera.id {
            return;
        }
        let pixel = projected(seen);
        if let Some((ring, [x, y])) = self.ring(pixel)
            && let Some(column) = self.of_rings[ring].1
        {
            entries.extend([(column, [x, y]), (column + 1, [-y, x])]);
        }
        if let Some(cell) = self.cells.at(pixel)
            && let Some(column) = self.of_cells[cell].1
        {
            entries.extend([(column, [1.0, 0.0]), (column + 1, [0.0, 1.0])]);
        }
    }

    /// What the probe says of it, beside the camera's residuals: their sum of squares, and how many of them are free.
    pub(super) fn found(
        &self,
        probe: &Probe,
        [squares, freedom]: [f64; 2],
        tails: Option<Tails>,
    ) -> Option<ResidualsInRun> {
        let (start, size) = (self.columns.start, self.columns.len());
        let score = probe.score.rows(start, size).into_owned();
        let own = probe.own.rows(start, size).into_owned();
        let information = probe.information.view((start, start), (size, size)).into_owned();
        let (statistic, rank) = square_in(information, score, &own);
        let (degrees, left) = (rank as f64, freedom - rank as f64);
        let variance = (squares - statistic) / left;
        if rank == 0 || left <= 0.0 || variance <= 0.0 {
            return None;
        }
        let ratio = statistic / degrees / variance;
        let mean = |(count, column): (usize, Option<usize>)| {
            let at = column?;
            let sums = [probe.score[at], probe.score[at + 1]];
            let information = [0, 1].map(|axis| probe.information[(at + axis, at + axis)]);
            Some(Mean::new(count, sums, information.map(|unit| variance * unit.max(0.0))))
        };
        let cell_means: Vec<CellMean> = (0..self.of_cells.len())
            .filter_map(|cell| Some(self.cells.mean(cell, mean(self.of_cells[cell])?)))
            .collect();
        let ring = |at: usize| {
            let radius_px = (at as f64 + 0.5) * self.ring_px;
            Some(RingMean { radius_px, mean: mean(self.of_rings[at])? })
        };
        let rings: Vec<RingMean> = (0..RINGS).filter_map(ring).collect();
        let by_cells = systematic(cell_means.iter().map(|cell| &cell.mean));
        let by_rings = systematic(rings.iter().map(|ring| &ring.mean));
        Some(ResidualsInRun {
            camera_id: self.camera.id.0,
            observations: self.of_cells.iter().map(|(count, _)| count).sum(),
            sigma_px: variance.sqrt(),
            statistic: ratio,
            degrees: [degrees, left],
            p: f_tail(ratio, [degrees, left])?,
            effect_px: by_cells.max(by_rings),
            cells: [self.cells.columns(), self.cells.rows()],
            tails,
            means: Means { cell_px: self.cells.cell_px(), cells: cell_means, rings },
        })
    }
}

/// RMS length of mean residuals over the observations, less what noise alone would show.
fn systematic<'m>(means: impl Iterator<Item = &'m Mean>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for mean in means {
        let n = mean.count as f64;
        let squares = [0, 1].map(|axis| mean.px[axis].powi(2) - mean.std_error_px[axis].powi(2));
        sum += n * (squares[0] + squares[1]);
        count += n;
    }
    if count > 0.0 { (sum / count).max(0.0).sqrt() } else { 0.0 }
}

/// s^T V^+ s and the rank of V, column by column; one that those before it or what moved can imitate is left out.
fn square_in(mut v: DMatrix<f64>, mut s: DVector<f64>, own: &DVector<f64>) -> (f64, usize) {
    /// Of a column's own square: what is left of less is rounding, or the adjustment's last step.
    const OPEN: f64 = 1e-6;
    let (mut sum, mut rank) = (0.0, 0);
    let size = s.len();
    for at in 0..size {
        let pivot = v[(at, at)];
        if pivot <= OPEN * own[at] {
            continue;
        }
        rank += 1;
        sum += s[at] * s[at] / pivot;
        for column in at + 1..size {
            let share = v[(column, at)] / pivot;
            s[column] -= share * s[at];
            for row in column..size {
                v[(row, column)] -= share * v[(row, at)];
            }
        }
    }
    (sum, rank)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_in_a_singular_covariance_is_that_in_its_range() {
        // V = A A^T of rank 2, s = A t: s^T V^+ s = |t|^2, whatever columns repeat others.
        let a = DMatrix::from_row_slice(4, 2, &[1.0, 0.0, 2.0, 0.0, 1.0, 1.0, 0.0, -3.0]);
        let t = DVector::from_row_slice(&[0.7, -1.1]);
        let v = &a * a.transpose();
        let own = v.diagonal();
        let (sum, rank) = square_in(v, &a * &t, &own);
        assert_eq!(rank, 2);
        assert!((sum - t.norm_squared()).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn noise_is_taken_out_of_a_pattern() {
        let mean = |px| Mean { count: 10, px, std_error_px: [0.3, 0.4], p: 0.5 };
        // (0.25 + 1.25) / 2 - 0.25
        let found = systematic([mean([0.5, 0.0]), mean([0.5, 1.0])].iter());
        assert!((found - 0.5_f64.sqrt()).abs() < 1e-12, "{found}");
        assert!(systematic([mean([0.1, 0.0])].iter()).abs() < 1e-300);
    }
}
