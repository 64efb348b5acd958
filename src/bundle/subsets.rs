//! Many adjustments of some of a scene's images at a time.
//!
//! The scene is made a problem once: which observations count, and each point's sightings, in the frame of the adjustment. A subset
//! is a mask on its images; points that fewer than two of them see drop out. Nothing is written back. Where the scene is at its own
//! optimum, subsets are near theirs.

use std::collections::BTreeSet;

use super::chunk::Sighted;
use super::covariance::FreeParam;
use super::linearize::Sighting;
use super::optimum::Optimum;
use super::options::Options;
use super::outcome::free_params;
use super::problem::Problem;
use super::solver::Solver;
use super::{BundleError, Dropped};
use crate::camera::Intrinsics;
use crate::least_squares::{self, Reason, Trial};
use crate::scene::{CameraId, ImageId, Scene};

/// A scene of which many subsets of images are adjusted.
#[derive(Debug, Clone)]
pub struct Subsets {
    whole: Problem,
    tracks: Vec<Sighted>,
    options: Options,
    free: Vec<FreeParam>,
    cameras: Vec<Intrinsics>,
}

/// The adjustment of one subset.
#[derive(Debug, Clone)]
pub struct Refit {
    /// Why it stopped.
    pub reason: Reason,
    /// 1/2 sum of rho before, in px^2, with what the priors cost.
    pub initial_cost: f64,
    /// 1/2 sum of rho after.
    pub cost: f64,
    /// Steps that were tried.
    pub iterations: usize,
    /// Points that took part.
    pub points: usize,
    /// Observations that took part.
    pub observations: usize,
    /// The cameras that took an image of the subset.
    pub intrinsics: Vec<(CameraId, Intrinsics)>,
    /// Its end, for questions.
    pub optimum: Optimum,
}

impl Subsets {
    /// Every adjustment starts where the scene is.
    pub fn new(scene: &Scene, options: &Options) -> Result<Self, BundleError> {
        let whole = Problem::new(scene, options)?;
        let free = free_params(scene, &whole, &[]);
        let cameras = whole.cameras.iter().map(|id| scene.cameras[id].intrinsics).collect();
        Ok(Self { tracks: whole.tracks(), whole, options: options.clone(), free, cameras })
    }

    /// Adjusts these images by themselves; those that the scene does not have are none.
    pub fn adjust(&self, images: &BTreeSet<ImageId>) -> Result<Refit, BundleError> {
        let problem = self.masked(images)?;
        let mut watch = |_: &Trial| ();
        let mut solver = Solver::new(&problem, &self.options, &mut watch);
        let start = problem.start.clone();
        let end = least_squares::minimize(&mut solver, start, &self.options.stop);
        let end = end.ok_or(BundleError::NoCost)?;
        let resting = problem.limits.resting(&end.state);
        let mut free = self.free.clone();
        free.retain(|param| {
            let number = problem.cameras.binary_search(&param.camera).unwrap_or_default();
            !resting.iter().any(|resting| resting.is(number, param.place))
        });
        let mut intrinsics = Vec::new();
        for (number, (id, before)) in problem.cameras.iter().zip(&self.cameras).enumerate() {
            let count = before.params().len();
            let made = before.model().with_params(&end.state.params[number][..count]);
            if problem.camera_of.iter().any(|&camera| camera as usize == number) {
                intrinsics.push((*id, made.map_err(|error| BundleError::NoLens(*id, error))?));
            }
        }
        Ok(Refit {
            reason: end.reason,
            initial_cost: end.initial_cost,
            cost: end.cost,
            iterations: end.iterations,
            points: problem.points.len(),
            observations: problem.observations,
            intrinsics,
            optimum: Optimum { problem, state: end.state, options: self.options.clone(), free },
        })
    }

    /// The problem of these images alone.
    fn masked(&self, images: &BTreeSet<ImageId>) -> Result<Problem, BundleError> {
        let mut problem = self.whole.bare();
        let mut numbers = vec![None; problem.images.len()];
        let is_in: Vec<bool> = problem.images.iter().map(|id| images.contains(id)).collect();
        let kept = (0..is_in.len()).filter(|&image| is_in[image]);
        kept.zip(0..).for_each(|(image, number)| numbers[image] = Some(number));
        let mut is_kept = is_in.iter();
        problem.images.retain(|_| is_kept.next() == Some(&true));
        let mut is_kept = is_in.iter();
        problem.camera_of.retain(|_| is_kept.next() == Some(&true));
        let mut is_kept = is_in.iter();
        problem.start.poses.retain(|_| is_kept.next() == Some(&true));
        problem.sightings = vec![0; problem.images.len()];
        problem.dropped = Dropped::default();
        let mut tracks = Vec::with_capacity(self.tracks.len());
        for (at, track) in self.tracks.iter().enumerate() {
            let inside = |seen: &Sighting| {
                numbers[seen.image as usize].map(|image| Sighting { image, ..*seen })
            };
            let track: Sighted = track.iter().filter_map(inside).collect();
            let is_lone = track.first().map(|a| a.image) == track.last().map(|b| b.image);
            if track.is_empty() || is_lone && self.options.mode.moves_points() {
                problem.dropped.lone_points += 1;
                problem.dropped.of_lone_points += track.len();
                continue;
            }
            problem.points.push(self.whole.points[at]);
            problem.start.points.push(self.whole.start.points[at]);
            tracks.push(track);
        }
        problem.lay_out(&tracks, &self.options)?;
        Ok(problem)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{World, camera, disturbed};
    use super::super::{Refine, Which, adjust};
    use super::*;
    use crate::camera::ParamClass::{Extra, Focal};

    #[test]
    fn a_subset_ends_where_the_scene_of_its_images_does_whatever_it_starts_from() {
        let lenses = [
            camera("OPENCV", &[1000.0, 1010.0, 645.0, 472.0, -0.1, 0.03, 0.001, -0.0005]),
            camera("SIMPLE_RADIAL", &[900.0, 640.0, 480.0, 0.02]),
        ];
        let scene = World::ring(lenses.to_vec(), 12, 300).with_noise(0.5).scene();
        let others = [Focal, Extra].map(Which::Class).to_vec();
        let refine = Refine { others, ..Refine::default() };
        let options = Options { refine, ..Options::default() };
        let refined = adjust(scene.clone(), &options, &mut |_| {}).unwrap().scene;
        let far = Subsets::new(&disturbed(scene.clone(), 0.01, 1.02), &options).unwrap();
        let near = Subsets::new(&refined, &options).unwrap();
        let mut compared = 0;
        // The last has images of one camera only.
        for images in [vec![1, 2, 3, 4, 5, 6, 7], vec![2, 5, 8, 9, 11, 99], vec![1, 3, 5, 7, 9, 11]]
        {
            let images: BTreeSet<ImageId> = images.into_iter().map(ImageId).collect();
            let alone = adjust(scene.with_images(&images), &options, &mut |_| {}).unwrap();
            let [far, near] = [&far, &near].map(|subsets| subsets.adjust(&images).unwrap());
            assert!(near.iterations < far.iterations);
            let covariance = alone.outcome.covariance.unwrap();
            let stds = covariance.stds().unwrap();
            for refit in [far, near] {
                assert_eq!(refit.observations, alone.outcome.observations);
                assert_eq!(refit.points, alone.outcome.points);
                assert!((refit.cost / alone.outcome.cost - 1.0).abs() < 1e-9);
                assert_eq!(
                    refit.intrinsics.len(),
                    if images.contains(&ImageId(2)) { 2 } else { 1 }
                );
                for (param, std) in covariance.params.iter().zip(&stds) {
                    let found = refit.intrinsics.iter().find(|(id, _)| *id == param.camera);
                    let Some((_, found)) = found else { continue };
                    let wanted =
                        alone.scene.cameras[&param.camera].intrinsics.params()[param.place];
                    assert!((found.params()[param.place] - wanted).abs() < 1e-4 * std);
                    compared += 1;
                }
            }
        }
        assert_eq!(compared, 2 * (8 + 8 + 6));
    }
}
