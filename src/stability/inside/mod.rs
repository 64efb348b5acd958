//! What a single run gives away against itself, where no comparison of runs can see it: parameters that were held and want to
//! move, a pattern in the residuals, points that do not fit. Computed while the run's adjustment stands; what is kept is plain data.

mod freed;
mod held;
mod population;
pub(super) mod remarks;
mod residuals;

pub use held::{FreedParameter, HeldClass, HeldInRun};
pub(super) use held::{LEAST_EFFECT_PX, MOST_P};
pub(super) use population::held_tests;
pub use population::{HeldTest, RunHeld};
pub(super) use remarks::{LEAST_PATTERN_PX, MOST_SIGMA_RATIO};
pub use residuals::{
    CellMean, Mean, ResidualMap, Residuals, ResidualsInRun, RingMean, RunResiduals, Tails,
};
pub(super) use residuals::{TAIL, residuals_of};

use schemars::JsonSchema;
use serde::Serialize;

use super::refinement::failure_of_outcome;
use super::spread::{Region, View, observation_counts, observed_cells};
use crate::bundle::{Entry, Loss, Observation, Optimum, Outcome};
use crate::camera::Grid;
use crate::scene::CameraId;

/// What one run gives away.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct Inside {
    /// Of each camera, what freeing a class of held parameters would do.
    pub held: Vec<HeldInRun>,
    /// Of each camera, what its residuals show; none of a camera with few observations.
    pub residuals: Vec<ResidualsInRun>,
}

/// More columns than this cost more than the adjustment did; a camera for each of so many images is no camera to judge.
const MOST_COLUMNS: usize = 500;

impl Inside {
    /// Looks into an adjustment at its end, over this region of the image. None where it did not converge, its loss is robust,
    /// or it has no noise to compare with.
    pub fn of(outcome: &Outcome, optimum: &Optimum, region: Option<Region>) -> Option<Self> {
        let is_meant = failure_of_outcome(outcome).is_none()
            && optimum.loss() == Loss::Squared
            && !optimum.free().is_empty();
        let variance = outcome.sigma_px.map(|sigma| sigma * sigma);
        let variance = variance.filter(|variance| is_meant && *variance > 0.0)?;
        let observations = optimum.observations();
        let candidates = held::candidates(outcome, optimum);
        let columns = candidates.iter().map(|one| one.freed.len()).sum();
        if columns > MOST_COLUMNS {
            return Some(Self::default());
        }
        let patterns = residuals::patterns(outcome, &observations, columns, MOST_COLUMNS);
        let entries = |seen: &Observation, entries: &mut Vec<Entry>| {
            held::add_entries(&candidates, seen, entries);
            patterns.iter().for_each(|pattern| pattern.add_entries(seen, entries));
        };
        let probe = optimum.probe(residuals::end(&patterns, columns), &entries);
        let tracks = residuals::Tracks::new(outcome, &observations, optimum.moves_points());
        let residuals = residuals::residuals(&patterns, &probe, &observations, &tracks);
        let view = |camera| view(outcome, &observations, camera);
        let beside = held::Beside { optimum, probe: &probe, variance, region, view: &view };
        Some(Self { held: held::tests(&candidates, &beside), residuals })
    }
}

/// What the camera observed.
fn view(outcome: &Outcome, observations: &[Observation], camera: CameraId) -> Option<View> {
    let size = outcome.cameras.iter().find(|one| one.id == camera)?.after;
    let grid = Grid::new(size.width, size.height);
    let own = observations.iter().filter(|seen| seen.camera == camera).map(|seen| seen.pixel);
    let observation_counts = observation_counts(&grid, own);
    let observed_cells = observed_cells(&grid, &observation_counts);
    Some(View { observation_counts, observed_cells, distances: None })
}
