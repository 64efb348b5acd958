//! The adjustment as a whole: a scene in, the refined scene and what there is to say of it out.

use super::covariance::{Covariance, FreeParam};
use super::determined::{Determined, determined};
use super::limits::Resting;
use super::optimum::Optimum;
use super::options::Options;
use super::problem::{Dropped, Problem};
use super::{BundleError, solver, write_back};
use crate::least_squares::{Reason, Trial};
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
    /// 1/2 sum of rho before, in px^2, with what the priors cost.
    pub initial_cost: f64,
    /// 1/2 sum of rho after, in px^2, with what the priors cost.
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
    /// sqrt(2 cost / (2 observations - rank)), in px, priors left aside: the noise of one coordinate, if the loss is squared; none when no residual is
    /// left over.
    pub sigma_px: Option<f64>,
    /// The cameras, those included that took no image.
    pub cameras: Vec<CameraOutcome>,
    /// How well the intrinsics are determined; none when none moved.
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
    /// The places of the parameters that moved, and are not on a bound.
    pub free: Vec<usize>,
    /// The places of those that ended on a bound and stay there.
    pub at_bound: Vec<usize>,
    /// Images that it took and that have observations.
    pub images: usize,
    /// Why no real lens has these intrinsics.
    pub implausible: Option<String>,
}

/// Adjusts a scene; `watch` is told of every step.
pub fn adjust(
    scene: Scene,
    options: &Options,
    watch: &mut dyn FnMut(&Trial),
) -> Result<Adjusted, BundleError> {
    Ok(adjust_to_optimum(scene, options, watch)?.0)
}

/// The same, with the end of the adjustment itself for whoever has questions.
pub fn adjust_to_optimum(
    mut scene: Scene,
    options: &Options,
    watch: &mut dyn FnMut(&Trial),
) -> Result<(Adjusted, Optimum), BundleError> {
    let problem = Problem::new(&scene, options)?;
    let (end, known) = solver::minimize(&problem, options, watch)?;
    let before: Vec<(CameraId, Camera)> =
        scene.cameras.iter().map(|(id, camera)| (*id, *camera)).collect();
    let rigs_dissolved = write_back::write_back(&mut scene, &problem, options, &end.state)?;
    let resting = problem.limits.resting(&end.state);
    let free = free_params(&scene, &problem, &resting);
    let Determined { unknowns, rank, sigma_px, covariance } =
        determined(&problem, options, (&end.state, end.cost, known), free.clone());
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
        sigma_px,
        cameras: before.into_iter().map(|it| camera(&scene, &problem, &resting, it)).collect(),
        covariance,
        rigs_dissolved,
    };
    let optimum = Optimum { state: end.state, options: options.clone(), free, problem };
    Ok((Adjusted { scene, outcome }, optimum))
}

pub(super) fn free_params(scene: &Scene, problem: &Problem, resting: &[Resting]) -> Vec<FreeParam> {
    let mut params = Vec::new();
    for (number, (id, lens)) in problem.cameras.iter().zip(&problem.lenses).enumerate() {
        let names = scene.cameras[id].intrinsics.model().params;
        let moves = |&&place: &&usize| !resting.iter().any(|rests| rests.is(number, place));
        params.extend(lens.free.iter().filter(moves).map(|&place| FreeParam {
            camera: *id,
            place,
            name: names[place].name,
        }));
    }
    params
}

fn camera(
    scene: &Scene,
    problem: &Problem,
    resting: &[Resting],
    (id, before): (CameraId, Camera),
) -> CameraOutcome {
    let after = scene.cameras[&id];
    let number = problem.cameras.iter().position(|other| *other == id);
    let took = |image: &usize| {
        Some(problem.camera_of[*image] as usize) == number && problem.sightings[*image] > 0
    };
    let all = number.map(|number| problem.lenses[number].free.clone()).unwrap_or_default();
    let rests = |place: &usize| resting.iter().any(|it| number.is_some_and(|n| it.is(n, *place)));
    let (at_bound, free) = all.into_iter().partition(rests);
    CameraOutcome {
        id,
        before,
        after,
        free,
        at_bound,
        images: (0..problem.images.len()).filter(took).count(),
        implausible: after.implausible(),
    }
}
