//! The adjustment as a whole: a scene in, the refined scene and what there is to say of it out.

use super::covariance::{Covariance, FreeParam};
use super::options::Options;
use super::problem::{Dropped, Problem};
use super::solver::Solver;
use super::{BundleError, Loss, write_back};
use crate::least_squares::{self, Reason, Trial};
use crate::scene::{Camera, CameraId, Scene};

/// A scene after adjustment.
#[derive(Debug, Clone, PartialEq)]
pub struct Adjusted {
    /// The refined scene, in the frame in which it came: gauge and similarity are undone.
    pub scene: Scene,
    /// What there is to say of it.
    pub outcome: Outcome,
}

/// How an adjustment went.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Why it stopped.
    pub reason: Reason,
    /// 1/2 sum of rho before, in px^2.
    pub initial_cost: f64,
    /// 1/2 sum of rho after, in px^2.
    pub cost: f64,
    /// Steps that were tried.
    pub iterations: usize,
    /// Images that have observations.
    pub images: usize,
    /// Points that took part.
    pub points: usize,
    /// Observations that took part; each is two residuals.
    pub observations: usize,
    /// What was left out.
    pub dropped: Dropped,
    /// Parts of the scene that no point connects.
    pub components: usize,
    /// What moved: 6 a pose, 3 a point, the free intrinsics, less 7 a component where poses and points both move.
    pub unknowns: usize,
    /// Of these, how many the observations determine.
    pub rank: usize,
    /// sqrt(2 cost / (2 observations - rank)), in px: the noise of one coordinate, if the loss is squared; none when no residual is
    /// left over.
    pub sigma_px: Option<f64>,
    /// The cameras, those included that took no image.
    pub cameras: Vec<CameraOutcome>,
    /// How well the intrinsics are determined; none when none moved, or the loss is not squared.
    pub covariance: Option<Covariance>,
    /// Images of one frame moved freely, so that the rigs that held them are no more: each camera is a rig of its own now.
    pub rigs_dissolved: bool,
}

/// What became of one camera.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraOutcome {
    /// Its id.
    pub id: CameraId,
    /// As it was.
    pub before: Camera,
    /// As it is.
    pub after: Camera,
    /// The places of the parameters that moved.
    pub free: Vec<usize>,
    /// Images that it took and that have observations.
    pub images: usize,
    /// Why no real lens has these intrinsics.
    pub implausible: Option<String>,
}

/// Adjusts a scene; `watch` is told of every step.
pub fn adjust(
    mut scene: Scene,
    options: &Options,
    watch: &mut dyn FnMut(&Trial),
) -> Result<Adjusted, BundleError> {
    let problem = Problem::new(&scene, options)?;
    let mut solver = Solver::new(&problem, options, watch);
    let start = problem.start.clone();
    let end = least_squares::minimize(&mut solver, start, &options.stop);
    let end = end.ok_or(BundleError::NoCost)?;
    let before: Vec<(CameraId, Camera)> =
        scene.cameras.iter().map(|(id, camera)| (*id, *camera)).collect();
    let rigs_dissolved = write_back::write_back(&mut scene, &problem, options, &end.state)?;
    let unknowns = problem.unknowns(options);
    let (information, nullity) = solver.information(&end.state);
    let params = free_params(&scene, &problem);
    let residuals = 2 * problem.observations;
    let of_rank = |rank: usize| {
        let freedom = residuals.checked_sub(rank).filter(|&freedom| freedom > 0)?;
        Some(2.0 * end.cost / freedom as f64)
    };
    let mut covariance = Covariance::new(params, &problem.layout, &information);
    let rank = unknowns.saturating_sub(nullity + covariance.open.len());
    let variance = of_rank(rank);
    covariance.scale(variance);
    let is_meant = !covariance.params.is_empty() && options.loss == Loss::Squared;
    let outcome = Outcome {
        reason: end.reason,
        initial_cost: end.initial_cost,
        cost: end.cost,
        iterations: end.iterations,
        images: problem.sightings.iter().filter(|&&count| count > 0).count(),
        points: problem.points.len(),
        observations: problem.observations,
        dropped: problem.dropped,
        components: problem.components,
        unknowns,
        rank,
        sigma_px: variance.map(f64::sqrt),
        cameras: before.into_iter().map(|before| camera(&scene, &problem, before)).collect(),
        covariance: is_meant.then_some(covariance),
        rigs_dissolved,
    };
    Ok(Adjusted { scene, outcome })
}

fn free_params(scene: &Scene, problem: &Problem) -> Vec<FreeParam> {
    let mut params = Vec::new();
    for (id, lens) in problem.cameras.iter().zip(&problem.lenses) {
        let names = scene.cameras[id].intrinsics.model().params;
        params.extend(lens.free.iter().map(|&place| FreeParam {
            camera: *id,
            place,
            name: names[place].name,
        }));
    }
    params
}

fn camera(scene: &Scene, problem: &Problem, (id, before): (CameraId, Camera)) -> CameraOutcome {
    let after = scene.cameras[&id];
    let number = problem.cameras.iter().position(|other| *other == id);
    let took = |image: &usize| {
        Some(problem.camera_of[*image] as usize) == number && problem.sightings[*image] > 0
    };
    CameraOutcome {
        id,
        before,
        after,
        free: number.map(|number| problem.lenses[number].free.clone()).unwrap_or_default(),
        images: (0..problem.images.len()).filter(took).count(),
        implausible: after.implausible(),
    }
}
