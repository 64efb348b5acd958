//! The end of an adjustment, kept for questions: what is left of each observation, and where more freedom would lead.

use nalgebra::Vector3;

use super::covariance::FreeParam;
use super::limits::Limits;
use super::linearize::{Kernel, Lens, Sighting};
use super::options::Options;
use super::problem::{Problem, State, padded};
use super::solver::Solver;
use super::{BundleError, Loss};
use crate::camera::Intrinsics;
use crate::least_squares::{self, Reason, Stop};
use crate::scene::{CameraId, ImageId};

/// An adjustment at its end.
#[derive(Debug, Clone)]
pub struct Optimum {
    pub(super) problem: Problem,
    pub(super) state: State,
    pub(super) options: Options,
    pub(super) free: Vec<FreeParam>,
}

/// An observation that took part, and what is left of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// The camera.
    pub camera: CameraId,
    /// The image.
    pub image: ImageId,
    /// The number of its point among those that took part; observations of one point follow each other.
    pub track: usize,
    /// Where it was measured, in px.
    pub pixel: [f64; 2],
    /// Projection less measurement, in px.
    pub residual: [f64; 2],
    /// The point in camera coordinates, in a unit of the adjustment's own.
    pub point: Vector3<f64>,
}

/// A camera under a model that contains its own, and what of it is to move.
#[derive(Debug, Clone, PartialEq)]
pub struct Widened {
    /// Which camera.
    pub camera: CameraId,
    /// The same lens in the wider model.
    pub intrinsics: Intrinsics,
    /// The places of the parameters that move.
    pub free: Vec<usize>,
}

impl Optimum {
    /// What the residuals cost.
    pub fn loss(&self) -> Loss {
        self.options.loss
    }

    /// Whether points moved.
    pub fn moves_points(&self) -> bool {
        self.options.mode.moves_points()
    }

    /// The intrinsics that moved and are on no bound: what [`Probe`](super::Probe) says follows.
    pub fn free(&self) -> &[FreeParam] {
        &self.free
    }

    /// Whether something was known of intrinsics beforehand.
    pub fn is_limited(&self) -> bool {
        !(self.options.priors.is_empty() && self.options.bounds.is_empty())
    }

    /// The observations that took part, in an order that depends on the scene alone.
    pub fn observations(&self) -> Vec<Observation> {
        let Self { problem, state, .. } = self;
        let mut all = Vec::with_capacity(problem.observations);
        for chunk in &problem.chunks {
            let mut start = 0;
            for (&end, track) in chunk.ends.iter().zip(chunk.points.clone()) {
                for sighting in &chunk.sightings[start..end as usize] {
                    let image = chunk.images[sighting.image as usize] as usize;
                    all.extend(self.observation(image, (track, &state.points[track]), sighting));
                }
                start = end as usize;
            }
        }
        all
    }

    /// An observation of the image of this number; none if it cannot be projected, which the optimum's cost excludes.
    pub(super) fn observation(
        &self,
        image: usize,
        (track, point): (usize, &Vector3<f64>),
        sighting: &Sighting,
    ) -> Option<Observation> {
        let Self { problem, state, .. } = self;
        let (camera, pose) = (problem.camera_of[image] as usize, &state.poses[image]);
        let residual = problem.lenses[camera].kernel.residual;
        Some(Observation {
            camera: problem.cameras[camera],
            image: problem.images[image],
            track,
            pixel: sighting.xy,
            residual: residual(&state.params[camera], pose, point, &sighting.xy)?,
            point: pose.see(point),
        })
    }

    /// The same observations adjusted further, these cameras under their wider models: all intrinsics that moved, or none where
    /// that does not converge. Priors and bounds are about the narrow models and cannot be kept.
    pub fn readjusted(
        &self,
        widened: &[Widened],
    ) -> Result<Option<Vec<(CameraId, Intrinsics)>>, BundleError> {
        /// No unknown is further from its end than this share of its std, squared.
        const NEAR: f64 = 1e-3;
        /// What takes longer leads far from where the question was asked.
        const MOST_STEPS: usize = 30;
        let problem = self.widened(widened)?;
        let stop =
            least_squares::Options { stop: Stop::Decrement(NEAR), max_iterations: MOST_STEPS };
        let mut watch = |_: &least_squares::Trial| ();
        let mut solver = Solver::new(&problem, &self.options, &mut watch);
        let end = least_squares::minimize(&mut solver, problem.start.clone(), &stop);
        let end = end.ok_or(BundleError::NoCost)?;
        if !matches!(end.reason, Reason::Converged | Reason::Rounding) {
            return Ok(None);
        }
        let mut all = Vec::new();
        for one in widened {
            let number = problem.cameras.binary_search(&one.camera).unwrap_or_default();
            let count = one.intrinsics.params().len();
            let made = one.intrinsics.model().with_params(&end.state.params[number][..count]);
            let made = made.map_err(|error| BundleError::NoLens(one.camera, error))?;
            all.push((one.camera, made));
        }
        Ok(Some(all))
    }

    /// The problem at this state with other lenses.
    fn widened(&self, widened: &[Widened]) -> Result<Problem, BundleError> {
        let mut problem = self.problem.bare();
        problem.start.clone_from(&self.state);
        problem.points.clone_from(&self.problem.points);
        problem.limits = Limits::default();
        for Widened { camera, intrinsics, free } in widened {
            if let Ok(number) = problem.cameras.binary_search(camera) {
                problem.lenses[number] =
                    Lens { kernel: Kernel::of(intrinsics), free: free.clone() };
                problem.start.params[number] = padded(intrinsics.params());
            }
        }
        let tracks = self.problem.tracks();
        problem.count(&tracks)?;
        problem.lay_out(&tracks, &self.options)?;
        Ok(problem)
    }
}
