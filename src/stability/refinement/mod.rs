//! How the runs' own adjustments went: what is recorded of them, and which of their cameras count as samples.

mod apply;
pub(super) mod clustered;
pub(super) mod remarks;
#[cfg(test)]
pub(super) mod testing;
#[cfg(test)]
mod tests;

pub(super) use apply::{Origin, failure_of_outcome, predicted_correlations, refined};
pub use apply::{failure_of_refit, failure_of_sample};
pub use clustered::ClusteredCovariance;

use schemars::JsonSchema;
use serde::Serialize;

use super::spread::Region;
use super::{Parameter, Run};
use crate::bundle::{BundleError, CameraOutcome, Outcome};
use crate::least_squares::Reason;
use apply::{
    clustered_of_camera, covariance_of_camera, failure_of_camera, failure_of_run, undetermined,
};

/// How the runs were refined, in the words of the command line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct RefinementOptions {
    /// What moved.
    pub mode: String,
    /// Which intrinsics moved: classes and names, of all cameras or, after a colon, of one.
    pub refine: Vec<String>,
    /// What was taken for known beforehand.
    pub priors: Vec<String>,
    /// Between which values intrinsics stayed.
    pub bounds: Vec<String>,
    /// What a residual cost.
    pub loss: String,
    /// When to stop.
    pub stop: String,
}

/// How refining one run went.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Refinement {
    /// Why none of its cameras counts; none when it converged.
    pub failure: Option<String>,
    /// The adjustment; none when it could not begin.
    pub adjustment: Option<Adjustment>,
}

/// One adjustment, from its start to its end.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Adjustment {
    /// Why it stopped.
    pub stopped: Stopped,
    /// Steps that were tried.
    pub iterations: usize,
    /// 1/2 sum of the (robust) squares before, in px^2.
    pub initial_cost: f64,
    /// The same after.
    pub cost: f64,
    /// Images that took part.
    pub images: usize,
    /// Points that took part.
    pub points: usize,
    /// Observations that took part; each is two residuals.
    pub observations: usize,
    /// Observations left out as they cannot be projected at the start.
    pub unprojectable: usize,
    /// Points left out as fewer than two images see them.
    pub lone_points: usize,
    /// Observations of these points.
    pub of_lone_points: usize,
    /// Parts of the scene that no point connects.
    pub components: usize,
    /// What moved, less the freedom of the gauge.
    pub unknowns: usize,
    /// Of these, how many the observations determine.
    pub rank: usize,
    /// sqrt(2 cost / (2 observations - rank)), in px: the noise of one coordinate, if the loss is squared.
    pub sigma_px: Option<f64>,
    /// The cameras that took an image.
    pub cameras: Vec<RefinedCamera>,
}

/// One camera of one adjustment.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RefinedCamera {
    /// Its CAMERA_ID.
    pub camera_id: u32,
    /// Images of it that took part.
    pub images: usize,
    /// Why its values are no sample.
    pub failure: Option<String>,
    /// All parameters as COLMAP left them, in file order.
    pub as_left: Vec<f64>,
    /// All parameters after the adjustment.
    pub refined: Vec<f64>,
    /// The parameters that moved: rows and columns of the covariance.
    pub free: Vec<String>,
    /// Their covariance, in their own units, for the noise that the residuals show; points, poses and other cameras are free in it.
    /// None where a direction of any camera of the run is not determined, or a robust loss has no minimum.
    pub covariance: Option<Vec<Vec<f64>>>,
    /// The same if the errors of one image depend on each other; none with fewer than 30 images, which tell too little of it.
    pub clustered: Option<ClusteredCovariance>,
    /// Changes of parameters that the observations do not notice, in words.
    pub undetermined: Vec<String>,
}

/// Why an adjustment stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Stopped {
    /// The stopping rule was met.
    Converged,
    /// Rounding hides any further fall of the cost.
    Rounding,
    /// The iterations ran out.
    IterationLimit,
    /// No step leads downhill, however short.
    Stuck,
}

/// A population before its runs were refined: what COLMAP itself makes of the repeats.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct AsLeft {
    /// Its parameters, in file order.
    pub parameters: Vec<Parameter>,
    /// How far the calibrations disagree in the image; none with fewer than two.
    pub spread: Option<LeftSpread>,
    /// Why two calibrations or more have no spread.
    pub without_spread: Option<String>,
}

/// The spread of the calibrations as COLMAP left them, over the same region and at the same depths as that of the refined ones.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct LeftSpread {
    /// How many calibrations.
    pub n: usize,
    /// Which part of the image was asked for.
    pub region: Region,
    /// Share of the image that was compared.
    pub cell_share: f64,
    /// RMS over the image of the calibrations as they are.
    pub raw_rms_px: f64,
    /// The same after turning each onto the others.
    pub rotated_rms_px: f64,
    /// The same after turning and moving them.
    pub moved_rms_px: Option<f64>,
}

impl Run {
    /// Whether it has what an adjustment needs: images, and points that they observe.
    pub fn is_refinable(&self) -> bool {
        let geometry = self.scene.geometry.as_ref();
        geometry.is_some_and(|geometry| geometry.points.observation_count() > 0)
    }
}

/// What is recorded of a run's refinement; nothing where none was tried.
pub(super) fn record(run: &Run) -> Option<Refinement> {
    let result = run.refinement.as_ref()?;
    let adjustment = result.as_ref().ok().map(adjustment);
    Some(Refinement { failure: failure_of_run(result), adjustment })
}

/// How refining a run ended.
type Refined = Result<Outcome, BundleError>;

fn adjustment(outcome: &Outcome) -> Adjustment {
    let took_images = outcome.cameras.iter().filter(|camera| camera.images > 0);
    Adjustment {
        stopped: match outcome.reason {
            Reason::Converged => Stopped::Converged,
            Reason::Rounding => Stopped::Rounding,
            Reason::IterationLimit => Stopped::IterationLimit,
            Reason::Stuck => Stopped::Stuck,
        },
        iterations: outcome.iterations,
        initial_cost: outcome.initial_cost,
        cost: outcome.cost,
        images: outcome.images,
        points: outcome.points,
        observations: outcome.observations,
        unprojectable: outcome.dropped.unprojectable,
        lone_points: outcome.dropped.lone_points,
        of_lone_points: outcome.dropped.of_lone_points,
        components: outcome.components,
        unknowns: outcome.unknowns,
        rank: outcome.rank,
        sigma_px: outcome.sigma_px,
        cameras: took_images.map(|camera| refined_camera(outcome, camera)).collect(),
    }
}

fn refined_camera(outcome: &Outcome, camera: &CameraOutcome) -> RefinedCamera {
    let names = camera.after.intrinsics.model().params;
    RefinedCamera {
        camera_id: camera.id.0,
        images: camera.images,
        failure: failure_of_camera(outcome, camera),
        as_left: camera.before.intrinsics.params().to_vec(),
        refined: camera.after.intrinsics.params().to_vec(),
        free: camera.free.iter().map(|&place| names[place].name.to_owned()).collect(),
        covariance: covariance_of_camera(outcome, camera),
        clustered: clustered_of_camera(outcome, camera),
        undetermined: undetermined(outcome, camera),
    }
}
