//! The adjustment as a whole: a scene in, the refined scene and what there is to say of it out.

use super::BundleError;
use super::options::Options;
use super::problem::{Dropped, Problem, State};
use super::solver::Solver;
use crate::least_squares::{self, Reason, Trial};
use crate::scene::{CameraId, Scene};

/// A scene after adjustment.
#[derive(Debug, Clone, PartialEq)]
pub struct Adjusted {
    /// The refined scene.
    pub scene: Scene,
    /// What there is to say of it.
    pub outcome: Outcome,
}

/// How an adjustment went.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Why it stopped.
    pub reason: Reason,
    /// 1/2 sum of rho before.
    pub initial_cost: f64,
    /// 1/2 sum of rho after.
    pub cost: f64,
    /// Steps that were tried.
    pub iterations: usize,
    /// What was left out.
    pub dropped: Dropped,
    /// The cameras that took images.
    pub cameras: Vec<CameraOutcome>,
}

/// What became of one camera.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraOutcome {
    /// Its id.
    pub id: CameraId,
    /// The places of the parameters that moved.
    pub free: Vec<usize>,
}

/// Adjusts a scene; `watch` is told of every step.
pub fn adjust(
    scene: Scene,
    options: &Options,
    watch: &mut dyn FnMut(&Trial),
) -> Result<Adjusted, BundleError> {
    let problem = Problem::new(&scene, options)?;
    let mut solver = Solver::new(&problem, options, watch);
    let start = problem.start.clone();
    let Some(end) = least_squares::minimize(&mut solver, start, &options.stop) else {
        return Err(BundleError::NoGeometry);
    };
    let outcome = Outcome {
        reason: end.reason,
        initial_cost: end.initial_cost,
        cost: end.cost,
        iterations: end.iterations,
        dropped: problem.dropped,
        cameras: Vec::new(),
    };
    let scene = write_back(scene, &problem, &end.state);
    Ok(Adjusted { scene, outcome })
}

fn write_back(mut scene: Scene, problem: &Problem, state: &State) -> Scene {
    for (id, params) in problem.cameras.iter().zip(&state.params) {
        if let Some(camera) = scene.cameras.get_mut(id) {
            let count = camera.intrinsics.params().len();
            camera.intrinsics = camera.intrinsics.model().with_params(&params[..count]).unwrap_or(camera.intrinsics);
        }
    }
    scene
}
