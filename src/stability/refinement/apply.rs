//! From an adjustment to samples: which cameras count, and how well each says its parameters are determined.

use super::super::run::CameraInRun;
use super::super::{Correlations, Run};
use super::{ClusteredCovariance, Refined};
use crate::bundle::{CameraOutcome, Covariance, Outcome, Refit};
use crate::camera::Model;
use crate::least_squares::Reason;
use crate::scene::{Camera, CameraId};

/// Where a camera's parameters are from.
#[derive(Debug, Clone)]
pub(in crate::stability) enum Origin<'a> {
    /// From the files.
    Left,
    /// From our own adjustment.
    Refined {
        /// The places of the parameters that moved.
        free: &'a [usize],
        /// Their covariance.
        covariance: Option<Vec<Vec<f64>>>,
    },
    /// Our own adjustment came to nothing: its values are those of the files, and no sample.
    Failed,
}

impl Origin<'_> {
    /// The standard deviation of the parameter at this place, by the adjustment.
    pub(in crate::stability) fn predicted_std(&self, place: usize) -> Option<f64> {
        let Self::Refined { free, covariance } = self else { return None };
        let row = free.iter().position(|free| *free == place)?;
        Some(covariance.as_ref()?[row][row].sqrt())
    }
}

/// A camera of a run as its adjustment made it; none where that failed.
pub(in crate::stability) fn refined(run: &Run, id: CameraId) -> Option<(&Camera, Origin<'_>)> {
    let result = run.refinement.as_ref().filter(|result| failure_of_run(result).is_none())?;
    let outcome = result.as_ref().ok()?;
    let camera = outcome.cameras.iter().find(|camera| camera.id == id)?;
    let covariance = covariance_of_camera(outcome, camera);
    failure_of_camera(outcome, camera)
        .is_none()
        .then_some((&camera.after, Origin::Refined { free: &camera.free, covariance }))
}

/// Why no camera of a run counts.
pub(super) fn failure_of_run(result: &Refined) -> Option<String> {
    match result {
        Err(error) => Some(error.to_string()),
        Ok(outcome) => failure_of_outcome(outcome),
    }
}

/// Why no camera of an adjustment that came to an end counts.
pub(in crate::stability) fn failure_of_outcome(outcome: &Outcome) -> Option<String> {
    failure_to_converge(outcome.reason, outcome.iterations)
}

fn failure_to_converge(reason: Reason, iterations: usize) -> Option<String> {
    match reason {
        Reason::Converged | Reason::Rounding => None,
        Reason::IterationLimit => {
            Some(format!("stopped after {iterations} steps without convergence"))
        }
        Reason::Stuck => Some("stopped without convergence: no step leads downhill".to_owned()),
    }
}

/// Why this camera of a run that converged does not count.
pub(super) fn failure_of_camera(outcome: &Outcome, camera: &CameraOutcome) -> Option<String> {
    if camera.images == 0 {
        return Some(UNSEEN.to_owned());
    }
    failure_to_determine(&undetermined(outcome, camera))
}

const UNSEEN: &str = "none of its images has an observation that takes part";

fn failure_to_determine(open: &[String]) -> Option<String> {
    (!open.is_empty()).then(|| format!("the observations do not determine {}", open.join("; ")))
}

/// Why this camera of an adjustment is no sample of it.
pub fn failure_of_sample(outcome: &Outcome, camera: CameraId) -> Option<String> {
    let own = outcome.cameras.iter().find(|own| own.id == camera);
    failure_of_outcome(outcome).or_else(|| own.and_then(|own| failure_of_camera(outcome, own)))
}

/// Why this camera of a refit, which leaves these directions open, is no sample of it.
pub fn failure_of_refit(refit: &Refit, open: &Covariance, camera: CameraId) -> Option<String> {
    failure_to_converge(refit.reason, refit.iterations).or_else(|| {
        match refit.intrinsics.iter().any(|(id, _)| *id == camera) {
            true => failure_to_determine(&open_in_words(open, camera)),
            false => Some(UNSEEN.to_owned()),
        }
    })
}

/// The directions that the observations leave open and this camera takes part in, in words.
pub(super) fn undetermined(outcome: &Outcome, camera: &CameraOutcome) -> Vec<String> {
    outcome.covariance.as_ref().map_or_else(Vec::new, |it| open_in_words(it, camera.id))
}

fn open_in_words(covariance: &Covariance, camera: CameraId) -> Vec<String> {
    let takes_part = |at: usize| covariance.params[at].camera == camera;
    let open = covariance.open.iter();
    open.filter(|direction| direction.changes.iter().any(|(at, _)| takes_part(*at)))
        .map(|direction| covariance.words(direction))
        .collect()
}

/// The covariance of one camera's parameters that moved.
pub(super) fn covariance_of_camera(
    outcome: &Outcome,
    camera: &CameraOutcome,
) -> Option<Vec<Vec<f64>>> {
    let covariance = outcome.covariance.as_ref()?;
    let matrix = covariance.matrix.as_ref()?;
    let own = (0..covariance.params.len()).filter(|&at| covariance.params[at].camera == camera.id);
    let own: Vec<usize> = own.collect();
    Some(own.iter().map(|&row| own.iter().map(|&column| matrix[row][column]).collect()).collect())
}

/// The same with its images as clusters.
pub(super) fn clustered_of_camera(
    outcome: &Outcome,
    camera: &CameraOutcome,
) -> Option<ClusteredCovariance> {
    let mut clustered = outcome.covariance.as_ref()?.clustered.iter();
    ClusteredCovariance::new(clustered.find(|clustered| clustered.camera == camera.id)?)
}

/// Correlations of the parameters by the mean covariance of these adjustments; none unless all have one of the same parameters.
pub(in crate::stability) fn predicted_correlations(
    model: &Model,
    cameras: &[&CameraInRun],
) -> Option<Correlations> {
    let covariances: Vec<(&[usize], &Vec<Vec<f64>>)> = cameras
        .iter()
        .map(|camera| match &camera.origin {
            Origin::Refined { free, covariance } => Some((*free, covariance.as_ref()?)),
            Origin::Left | Origin::Failed => None,
        })
        .collect::<Option<_>>()?;
    let (free, _) = *covariances.first()?;
    if free.is_empty() || covariances.iter().any(|(other, _)| *other != free) {
        return None;
    }
    // The sum serves as the mean: a factor is no matter to correlations.
    let sum = |row: usize, column: usize| -> f64 {
        covariances.iter().map(|(_, matrix)| matrix[row][column]).sum()
    };
    let correlation = |row: usize, column: usize| {
        let both = sum(row, column) / (sum(row, row) * sum(column, column)).sqrt();
        both.is_finite().then_some(both)
    };
    let all = 0..free.len();
    Some(Correlations {
        parameters: free.iter().map(|&place| model.params[place].name.to_owned()).collect(),
        matrix: all.clone().map(|row| all.clone().map(|c| correlation(row, c)).collect()).collect(),
    })
}
