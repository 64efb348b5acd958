//! What is left of the observations of a camera: a pattern over the image, and points that fit far worse than most.

mod means;
mod pattern;
mod tails;
#[cfg(test)]
mod tests;

pub use means::{CellMean, Mean, RingMean};
pub(super) use pattern::{Pattern, end, patterns};
pub(in crate::stability) use tails::TAIL;
pub use tails::Tails;
pub(super) use tails::Tracks;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::population::{median_of, together};
use crate::bundle::{Observation, Probe};
use crate::stability::run::CameraInRun;
use crate::stability::{Overlap, Run};

/// What the residuals of one camera of one run show.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ResidualsInRun {
    /// The camera's CAMERA_ID.
    pub camera_id: u32,
    /// Its observations in the cells.
    pub observations: usize,
    /// The noise of one coordinate, in px, the pattern left aside.
    pub sigma_px: f64,
    /// The mean square of the pattern in units of what noise shows: F with the degrees below where there is none.
    pub statistic: f64,
    /// Of the pattern, and of what is left beside it.
    pub degrees: [f64; 2],
    /// Probability of so much or more by independent noise.
    pub p: f64,
    /// RMS length of the mean residuals over the image, noise removed: by cells or by rings, the greater.
    pub effect_px: f64,
    /// Cells in a row and in a column.
    pub cells: [usize; 2],
    /// How alike in size the residuals are; none where no noise is left.
    pub tails: Option<Tails>,
    /// The map and the rings, which the population has of all runs together.
    #[serde(skip)]
    #[schemars(skip)]
    means: Means,
}

#[derive(Debug, Clone, PartialEq)]
struct Means {
    cell_px: [f64; 2],
    cells: Vec<CellMean>,
    rings: Vec<RingMean>,
}

/// What one run says.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RunResiduals {
    /// The run.
    pub run: String,
    /// Its residuals.
    #[serde(flatten)]
    pub residuals: ResidualsInRun,
}

/// What the residuals of a camera show, over its runs. Residuals are projection less measurement.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Residuals {
    /// How many runs.
    pub n: usize,
    /// Whether they have a pattern: twice the median of the runs' p-values, a p-value however much the runs share
    /// (Rueschendorf 1982).
    pub p: f64,
    /// How large it is: median over the runs of its RMS over the image, in px, noise removed.
    pub effect_px: f64,
    /// Median over the runs of the noise of one coordinate, in px.
    pub sigma_px: f64,
    /// How alike in size residuals are: medians over the runs, the p-value as above; none where half of the runs have none.
    pub tails: Option<Tails>,
    /// Mean residuals over the image.
    pub map: ResidualMap,
    /// The runs alone.
    pub runs: Vec<RunResiduals>,
}

/// Mean residuals of runs together: each observation counts as much, and standard errors allow for what the runs share.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ResidualMap {
    /// How many runs: those with the most common size of cells.
    pub n: usize,
    /// Cells in a row.
    pub columns: usize,
    /// Cells in a column.
    pub rows: usize,
    /// Width and height of a cell, in px: the image's right and lower border may cut the last ones.
    pub cell_px: [f64; 2],
    /// The cells that have observations enough.
    pub cells: Vec<CellMean>,
    /// The same by distance from the principal point.
    pub rings: Vec<RingMean>,
}

/// What each camera's residuals show in a probe of their patterns.
pub(super) fn residuals(
    patterns: &[Pattern<'_>],
    probe: &Probe,
    observations: &[Observation],
    tracks: &Tracks,
) -> Vec<ResidualsInRun> {
    let of_camera = |pattern: &Pattern| {
        let id = pattern.camera.id;
        let squares = tracks.of_camera(observations, id);
        pattern.found(probe, squares, tracks.tails(observations, id))
    };
    patterns.iter().filter_map(of_camera).collect()
}

/// What a population's residuals show; none where no run was asked.
pub(in crate::stability) fn residuals_of(
    sampled: &[(&Run, &CameraInRun)],
    overlap: Option<&Overlap>,
) -> Option<Residuals> {
    let of_run = |(run, camera): &(&Run, &CameraInRun)| {
        let mut all = run.inside.as_ref()?.residuals.iter();
        let residuals = all.find(|one| one.camera_id == camera.id.0)?.clone();
        Some(RunResiduals { run: run.name.clone(), residuals })
    };
    let runs: Vec<RunResiduals> = sampled.iter().filter_map(of_run).collect();
    let all: Vec<&ResidualsInRun> = runs.iter().map(|run| &run.residuals).collect();
    // Pooled cameras of one run share the points that they see, and no more is known of them.
    let shared = overlap.map_or(0.0, |overlap| overlap.shared_fraction);
    let median =
        |of: fn(&ResidualsInRun) -> f64| median_of(all.iter().map(|one| of(one)).collect());
    Some(Residuals {
        n: all.len(),
        p: together(all.iter().map(|one| one.p).collect())?,
        effect_px: median(|one| one.effect_px)?,
        sigma_px: median(|one| one.sigma_px)?,
        tails: tails_of(&all),
        map: map(&all, shared)?,
        runs,
    })
}

fn tails_of(all: &[&ResidualsInRun]) -> Option<Tails> {
    let tails: Vec<Tails> = all.iter().filter_map(|one| one.tails).collect();
    let median = |of: fn(&Tails) -> f64| median_of(tails.iter().map(of).collect());
    let mut counts: Vec<usize> = tails.iter().map(|one| one.points).collect();
    counts.sort_unstable();
    (2 * tails.len() > all.len()).then_some(())?;
    Some(Tails {
        points: counts[counts.len() / 2],
        robust_sigma_px: median(|one| one.robust_sigma_px)?,
        sigma_ratio: median(|one| one.sigma_ratio)?,
        beyond_share: median(|one| one.beyond_share)?,
        p: together(tails.iter().map(|one| one.p).collect())?,
    })
}

/// The means of runs that have cells of one size, the most common one; of equally common ones the coarsest.
fn map(all: &[&ResidualsInRun], shared: f64) -> Option<ResidualMap> {
    let mut sizes: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    all.iter().for_each(|one| *sizes.entry(one.cells).or_default() += 1);
    let most = sizes.values().copied().max()?;
    let cells = *sizes.iter().find(|(_, count)| **count == most)?.0;
    let alike: Vec<&Means> =
        all.iter().filter(|one| one.cells == cells).map(|one| &one.means).collect();
    let mut by_cell: BTreeMap<usize, Vec<CellMean>> = BTreeMap::new();
    let mut by_ring: BTreeMap<u64, Vec<RingMean>> = BTreeMap::new();
    for means in &alike {
        means.cells.iter().for_each(|cell| by_cell.entry(cell.cell).or_default().push(*cell));
        // Radii are of the image, and so the same to the last bit.
        let key = |ring: &RingMean| ring.radius_px.to_bits();
        means.rings.iter().for_each(|ring| by_ring.entry(key(ring)).or_default().push(*ring));
    }
    let of_cell = |cells: &Vec<CellMean>| {
        let means: Vec<Mean> = cells.iter().map(|cell| cell.mean).collect();
        CellMean { mean: Mean::together(&means, shared), ..cells[0] }
    };
    let of_ring = |rings: &Vec<RingMean>| {
        let means: Vec<Mean> = rings.iter().map(|ring| ring.mean).collect();
        RingMean { mean: Mean::together(&means, shared), ..rings[0] }
    };
    Some(ResidualMap {
        n: alike.len(),
        columns: cells[0],
        rows: cells[1],
        cell_px: alike.first()?.cell_px,
        cells: by_cell.values().map(of_cell).collect(),
        rings: by_ring.values().map(of_ring).collect(),
    })
}
