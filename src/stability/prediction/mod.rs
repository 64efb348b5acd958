//! What the runs' own adjustments say of the spread between them: how large it should be, and whether it is larger.

mod consistency;
mod directions;
mod effect;
pub(super) mod remarks;
#[cfg(test)]
mod tests;

pub use consistency::{Consistency, Ratio};
pub use directions::Direction;

use nalgebra::{DMatrix, Vector2};
use schemars::JsonSchema;
use serde::Serialize;

use super::refinement::Origin;
use super::run::CameraInRun;
use super::spread::{Region, Spread, View, in_single_precision, radial_rms, rms};
use super::{Overlap, Run};
use crate::camera::{Grid, Param};
use crate::scene::Camera;
use crate::stats::std_interval_factors_of_degrees;
use consistency::consistency;
use directions::directions;
use effect::{effect, variances};

/// What the adjustments predict of a population.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Prediction {
    /// How far independent repeats should disagree; none where the image tells no rotation.
    pub spread: Option<PredictedSpread>,
    /// Whether the runs differ by more; none with fewer than two.
    pub consistency: Option<Consistency>,
    /// The parameters that `directions` are changes of; empty unless all runs estimated the same ones.
    pub parameters: Vec<String>,
    /// The mean covariance by what it does in the image, strongest first.
    pub directions: Vec<Direction>,
}

/// The spread that covariances predict, rotation-aligned, over the cells of the observed spread; of a lone run over what it
/// observed.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PredictedSpread {
    /// How many runs it is the mean of.
    pub n: usize,
    /// Share of the image that it is over.
    pub cell_share: f64,
    /// Root of the mean square over the cells; its square is the expected mapping error.
    pub rms_px: f64,
    /// The observed spread, rotation-aligned, as a multiple of it.
    pub observed_ratio: Option<f64>,
    /// The same for independent runs: corrected for what the runs share.
    pub independent_ratio: Option<f64>,
    /// 95 % of the groups of so many independent runs would show between these multiples of it.
    pub band_95: [f64; 2],
    /// What each run alone predicts.
    pub runs: Vec<RunPrediction>,
    /// RMS over the rings of the observed spread's radial profile; empty without one.
    pub radial_px: Vec<f64>,
    /// In each cell of the observed spread, in px, written in single precision; empty without one.
    #[serde(serialize_with = "in_single_precision")]
    pub map_px: Vec<f64>,
}

/// The spread that one run's covariance predicts for repeats like it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RunPrediction {
    /// The run.
    pub run: String,
    /// The camera's CAMERA_ID in it.
    pub camera_id: u32,
    /// Root of the mean square over the cells.
    pub rms_px: f64,
}

/// One calibration with its covariance.
struct Estimate<'a> {
    run: &'a str,
    camera_id: u32,
    camera: &'a Camera,
    names: &'static [Param],
    free: &'a [usize],
    values: &'a [f64],
    covariance: DMatrix<f64>,
}

impl Estimate<'_> {
    fn size(&self) -> [u64; 2] {
        [self.camera.width, self.camera.height]
    }
}

/// What is known besides the calibrations.
pub(super) struct Beside<'a> {
    pub spread: Option<&'a Spread>,
    pub overlap: Option<&'a Overlap>,
    /// What a lone run observed.
    pub view: Option<&'a View>,
    pub region: Option<Region>,
}

/// Of the samples that have covariances; none where none has.
pub(super) fn prediction(sampled: &[(&Run, &CameraInRun)], beside: &Beside) -> Option<Prediction> {
    let estimates: Vec<Estimate> = sampled
        .iter()
        .filter_map(|(run, camera)| estimate(run, camera))
        .filter(|one| beside.spread.is_none_or(|spread| is_compared(spread, one)))
        .collect();
    let first = estimates.first()?;
    let cells = cells(first.camera, beside);
    let effects: Option<Vec<DMatrix<f64>>> = estimates
        .iter()
        .map(|one| effect(&one.camera.intrinsics, one.free, &cells.pixels))
        .collect();
    let spread =
        effects.as_ref().and_then(|effects| predicted(&estimates, effects, &cells, beside));
    let are_alike = estimates.iter().all(|one| one.free == first.free);
    let mean = || {
        estimates.iter().map(|one| &one.covariance).sum::<DMatrix<f64>>() / estimates.len() as f64
    };
    let found = effects.filter(|_| are_alike).and_then(|effects| directions(&mean(), &effects[0]));
    let names = first.free.iter().map(|&place| first.names[place].name.to_owned());
    Some(Prediction {
        spread,
        consistency: consistency(&estimates, beside.overlap),
        parameters: if found.is_some() { names.collect() } else { Vec::new() },
        directions: found.unwrap_or_default(),
    })
}

fn estimate<'a>(run: &'a Run, camera: &'a CameraInRun<'a>) -> Option<Estimate<'a>> {
    let Origin::Refined { free, covariance: Some(rows) } = &camera.origin else { return None };
    if free.is_empty() {
        return None;
    }
    let covariance = DMatrix::from_fn(free.len(), free.len(), |row, column| rows[row][column]);
    Some(Estimate {
        run: &run.name,
        camera_id: camera.id.0,
        camera: camera.camera,
        names: camera.camera.intrinsics.model().params,
        free,
        values: camera.camera.intrinsics.params(),
        covariance,
    })
}

/// Whether the calibration was compared with the others, and not set aside.
fn is_compared(spread: &Spread, one: &Estimate) -> bool {
    spread.runs.iter().any(|run| run.run == one.run && run.camera_id == one.camera_id)
}

/// Where the image is looked at.
struct Cells {
    grid: Grid,
    pixels: Vec<Vector2<f64>>,
}

/// The cells of the observed spread; of a lone run those of its region that have a ray.
fn cells(camera: &Camera, beside: &Beside) -> Cells {
    let grid = Grid::new(camera.width, camera.height);
    if let Some(spread) = beside.spread {
        let pixels = spread.cells.iter().map(|&cell| grid.pixel(cell)).collect();
        return Cells { grid, pixels };
    }
    let observed: Vec<&[bool]> = beside.view.iter().map(|view| &*view.observed_cells).collect();
    let usual = if observed.is_empty() { Region::All } else { Region::Observed };
    let cells = beside.region.unwrap_or(usual).cells(&grid, &observed);
    let pixels = cells.into_iter().map(|cell| grid.pixel(cell));
    Cells { grid, pixels: pixels.filter(|at| camera.intrinsics.unproject(at).is_ok()).collect() }
}

/// How far a spread with so many degrees of freedom may lie from what is predicted.
fn band(spread: &Spread) -> Option<[f64; 2]> {
    let [low, high] = std_interval_factors_of_degrees(spread.degrees, 0.95)?;
    Some([1.0 / high, 1.0 / low])
}

/// The mean of what the runs predict.
fn predicted(
    estimates: &[Estimate],
    effects: &[DMatrix<f64>],
    cells: &Cells,
    beside: &Beside,
) -> Option<PredictedSpread> {
    let of_runs: Vec<Vec<f64>> = estimates
        .iter()
        .zip(effects)
        .map(|(one, effect)| variances(effect, &one.covariance))
        .collect();
    let mean = |variances: &[f64]| variances.iter().sum::<f64>() / variances.len() as f64;
    let of_cell = |cell: usize| {
        of_runs.iter().map(|variances| variances[cell]).sum::<f64>() / of_runs.len() as f64
    };
    let map_px: Vec<f64> = (0..cells.pixels.len()).map(|cell| of_cell(cell).sqrt()).collect();
    let rms_px = rms(&map_px);
    let observed_ratio = beside.spread.map(|spread| spread.rotated.rms_px / rms_px);
    let factor = beside.overlap.and_then(|overlap| overlap.independent_factor);
    let of_run = |(one, variances): (&Estimate, &Vec<f64>)| RunPrediction {
        run: one.run.to_owned(),
        camera_id: one.camera_id,
        rms_px: mean(variances).sqrt(),
    };
    rms_px.is_finite().then(|| PredictedSpread {
        n: estimates.len(),
        cell_share: cells.pixels.len() as f64 / cells.grid.cell_count() as f64,
        rms_px,
        observed_ratio: observed_ratio.filter(|ratio| ratio.is_finite()),
        independent_ratio: observed_ratio.zip(factor).map(|(ratio, factor)| ratio * factor),
        band_95: beside.spread.and_then(band).unwrap_or([1.0; 2]),
        runs: estimates.iter().zip(&of_runs).map(of_run).collect(),
        radial_px: beside
            .spread
            .map_or(Vec::new(), |spread| radial_rms(spread, estimates[0].size(), &map_px)),
        map_px: if beside.spread.is_some() { map_px } else { Vec::new() },
    })
}
