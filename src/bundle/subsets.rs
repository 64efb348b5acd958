//! Many adjustments of some of a scene's images at a time.
//!
//! The scene is made a problem once: which observations count, and each point's sightings, in the frame of the adjustment. A subset
//! is a mask on its images; points that fewer than two of them see drop out. The same observations may be seen at other pixels, and
//! adjustments start elsewhere, again and again. Nothing is written back. Where the start is at its own optimum, subsets are near
//! theirs.

use std::collections::BTreeSet;

use super::chunk::Sighted;
use super::covariance::{Covariance, FreeParam};
use super::linearize::Sighting;
use super::optimum::Optimum;
use super::options::Options;
use super::outcome::free_params;
use super::problem::{Problem, State, padded, placed};
use super::solver::{self, Known};
use super::{BundleError, Dropped, determined};
use crate::camera::Intrinsics;
use crate::least_squares::Reason;
use crate::scene::{CameraId, Estimates, ImageId, Scene};

/// A scene of which many subsets of images are adjusted.
#[derive(Debug, Clone)]
pub struct Subsets {
    pub(super) whole: Problem,
    pub(super) tracks: Vec<Sighted>,
    options: Options,
    free: Vec<FreeParam>,
    cameras: Vec<Intrinsics>,
}

/// What the images see, and where adjustments start.
#[derive(Debug, Clone)]
pub struct Sight<'a> {
    pub(super) subsets: &'a Subsets,
    /// Of each image's keypoints; none where they are where the scene has them.
    pixels: Option<&'a [Vec<[f64; 2]>]>,
    pub(super) start: State,
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
    /// The cameras that took an image with an observation that took part.
    pub intrinsics: Vec<(CameraId, Intrinsics)>,
    /// Its end, for questions.
    pub optimum: Optimum,
    /// The points that took part, by their numbers among the whole's.
    pub(super) kept: Vec<usize>,
    known: Option<Known>,
}

impl Subsets {
    /// Adjustments start where the scene is, unless told otherwise.
    pub fn new(scene: &Scene, options: &Options) -> Result<Self, BundleError> {
        let whole = Problem::new(scene, options)?;
        let free = free_params(scene, &whole, &[]);
        let cameras = whole.cameras.iter().map(|id| scene.cameras[id].intrinsics).collect();
        Ok(Self { tracks: whole.tracks(), whole, options: options.clone(), free, cameras })
    }

    /// Adjusts these images by themselves; those that the scene does not have are none.
    pub fn adjust(&self, images: &BTreeSet<ImageId>) -> Result<Refit, BundleError> {
        let start = self.whole.start.clone();
        Sight { subsets: self, pixels: None, start }.adjust(images)
    }

    /// The same observations at other pixels, given of all keypoints in the order of the images, and another start of the same
    /// cameras, images and points.
    pub fn seen<'a>(
        &'a self,
        pixels: &'a [Vec<[f64; 2]>],
        start: &Estimates,
    ) -> Result<Sight<'a>, BundleError> {
        let start = self.start(start)?;
        let count = |seen: &Sighting| pixels.get(seen.image as usize).map_or(0, Vec::len);
        let fits = |seen: &Sighting| (seen.keypoint as usize) < count(seen);
        match self.tracks.iter().flatten().all(fits) {
            true => Ok(Sight { subsets: self, pixels: Some(pixels), start }),
            false => Err(BundleError::OtherScene),
        }
    }

    fn start(&self, estimates: &Estimates) -> Result<State, BundleError> {
        let Problem { frame, images, cameras, points, limits, .. } = &self.whole;
        let Estimates { cameras: given, poses, points: places } = estimates;
        let lens = |(id, own): (&CameraId, &Intrinsics)| {
            let lens = given.get(id).map(|camera| camera.intrinsics);
            lens.filter(|lens| lens.model().name == own.model().name)
        };
        let lenses: Option<Vec<Intrinsics>> = cameras.iter().zip(&self.cameras).map(lens).collect();
        let places: Option<Vec<[f64; 3]>> =
            points.iter().map(|&point| places.get(point).copied()).collect();
        let (Some(lenses), Some(places), true) = (lenses, places, poses.len() == images.len())
        else {
            return Err(BundleError::OtherScene);
        };
        let mut start = State {
            poses: placed(frame, images, poses)?,
            params: lenses.iter().map(|lens| padded(lens.params())).collect(),
            points: places.into_iter().map(|place| frame.point_in(place)).collect(),
        };
        limits.put_inside(&mut start, &[]);
        Ok(start)
    }
}

impl Sight<'_> {
    /// Adjusts these images by themselves; those that the scene does not have are none.
    pub fn adjust(&self, images: &BTreeSet<ImageId>) -> Result<Refit, BundleError> {
        let Subsets { options, free, cameras, .. } = self.subsets;
        let (problem, kept) = self.masked(images)?;
        let (end, known) = solver::minimize(&problem, options, &mut |_| ())?;
        let resting = problem.limits.resting(&end.state);
        let mut free = free.clone();
        free.retain(|param| {
            let number = problem.cameras.binary_search(&param.camera).unwrap_or_default();
            !resting.iter().any(|resting| resting.is(number, param.place))
        });
        let mut intrinsics = Vec::new();
        for (number, (id, before)) in problem.cameras.iter().zip(cameras).enumerate() {
            let count = before.params().len();
            let made = before.model().with_params(&end.state.params[number][..count]);
            let mut seeing = problem.camera_of.iter().zip(&problem.sightings);
            if seeing.any(|(&camera, &sightings)| camera as usize == number && sightings > 0) {
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
            optimum: Optimum { problem, state: end.state, options: options.clone(), free },
            kept,
            known,
        })
    }

    /// Where a sighting of the whole is, in px.
    pub(super) fn pixel(&self, seen: &Sighting) -> [f64; 2] {
        let own = |pixels: &[Vec<[f64; 2]>]| pixels[seen.image as usize][seen.keypoint as usize];
        self.pixels.map_or(seen.xy, own)
    }

    /// The problem of these images alone, and the numbers of its points among the whole's.
    fn masked(&self, images: &BTreeSet<ImageId>) -> Result<(Problem, Vec<usize>), BundleError> {
        let Subsets { whole, tracks, options, .. } = self.subsets;
        let inside: Vec<usize> =
            (0..whole.images.len()).filter(|&at| images.contains(&whole.images[at])).collect();
        let mut numbers = vec![None; whole.images.len()];
        inside.iter().zip(0..).for_each(|(&image, number)| numbers[image] = Some(number));
        let mut problem = whole.bare();
        problem.images = inside.iter().map(|&image| whole.images[image]).collect();
        problem.camera_of = inside.iter().map(|&image| whole.camera_of[image]).collect();
        problem.sightings = vec![0; inside.len()];
        problem.dropped = Dropped::default();
        problem.start = State {
            poses: inside.iter().map(|&image| self.start.poses[image]).collect(),
            params: self.start.params.clone(),
            points: Vec::new(),
        };
        let (mut kept, mut kept_tracks) = (Vec::new(), Vec::with_capacity(tracks.len()));
        for (at, track) in tracks.iter().enumerate() {
            let mut seen: Sighted = Vec::with_capacity(track.len());
            for sighting in track {
                let Some(image) = numbers[sighting.image as usize] else { continue };
                let sighting = Sighting { image, xy: self.pixel(sighting), ..*sighting };
                match problem.residual(&sighting, &self.start.points[at]) {
                    Some(_) => seen.push(sighting),
                    None => problem.dropped.unprojectable += 1,
                }
            }
            let is_lone = seen.first().map(|a| a.image) == seen.last().map(|b| b.image);
            if seen.is_empty() || is_lone && options.mode.moves_points() {
                problem.dropped.lone_points += 1;
                problem.dropped.of_lone_points += seen.len();
                continue;
            }
            problem.points.push(whole.points[at]);
            problem.start.points.push(self.start.points[at]);
            kept.push(at);
            kept_tracks.push(seen);
        }
        problem.count(&kept_tracks)?;
        problem.lay_out(&kept_tracks, options)?;
        Ok((problem, kept))
    }
}

impl Refit {
    /// The directions of the intrinsics that the observations leave open. The covariance is not made.
    pub fn open(&self) -> Covariance {
        let Optimum { problem, state, options, free } = &self.optimum;
        let open = determined::open(problem, options, (state, self.known.as_ref()), free);
        Covariance { params: free.clone(), matrix: None, clustered: Vec::new(), open }
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
        let world = World::ring(lenses.to_vec(), 12, 300);
        let exact = Subsets::new(&world.scene(), &options()).unwrap();
        let scene = world.with_noise(0.5).scene();
        let options = options();
        let refined = adjust(scene.clone(), &options, &mut |_| {}).unwrap().scene;
        let far = Subsets::new(&disturbed(scene.clone(), 0.01, 1.02), &options).unwrap();
        let near = Subsets::new(&refined, &options).unwrap();
        let pixels = scene.pixels();
        let again = exact.seen(&pixels, &disturbed(scene.clone(), 0.01, 1.02).estimates()).unwrap();
        let mut compared = 0;
        // The last has images of one camera only.
        for images in [vec![1, 2, 3, 4, 5, 6, 7], vec![2, 5, 8, 9, 11, 99], vec![1, 3, 5, 7, 9, 11]]
        {
            let images: BTreeSet<ImageId> = images.into_iter().map(ImageId).collect();
            let alone = adjust(scene.with_images(&images), &options, &mut |_| {}).unwrap();
            let [far, near] = [&far, &near].map(|subsets| subsets.adjust(&images).unwrap());
            let again = again.adjust(&images).unwrap();
            assert!(near.iterations < far.iterations);
            assert_eq!(again.iterations, far.iterations);
            let covariance = alone.outcome.covariance.unwrap();
            let stds = covariance.stds().unwrap();
            for refit in [far, near, again] {
                // A camera without images is open, and no other.
                let open = refit.open();
                let seen = |at: usize| {
                    refit.intrinsics.iter().any(|(id, _)| *id == open.params[at].camera)
                };
                assert!(open.open.iter().flat_map(|it| &it.changes).all(|(at, _)| !seen(*at)));
                assert_eq!(open.open.is_empty(), images.contains(&ImageId(2)));
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
        assert_eq!(compared, 3 * (8 + 8 + 6));
    }

    #[test]
    fn what_is_of_another_scene_is_refused() {
        let lens = camera("OPENCV", &[1000.0, 1010.0, 645.0, 472.0, -0.1, 0.03, 0.001, -0.0005]);
        let scene = World::ring(vec![lens], 6, 60).scene();
        let subsets = Subsets::new(&scene, &Options::default()).unwrap();
        let (pixels, start) = (scene.pixels(), scene.estimates());
        assert!(subsets.seen(&pixels, &start).is_ok());
        let mut fewer = pixels.clone();
        fewer[3].pop();
        let mut without_pose = start.clone();
        without_pose.poses.pop();
        let mut without_point = start.clone();
        without_point.points.pop();
        let mut other_lens = start.clone();
        let lens = camera("SIMPLE_RADIAL", &[1000.0, 645.0, 472.0, -0.1]);
        other_lens.cameras.insert(CameraId(1), lens);
        for (pixels, start) in [
            (&fewer, &start),
            (&pixels, &without_pose),
            (&pixels, &without_point),
            (&pixels, &other_lens),
        ] {
            assert_eq!(subsets.seen(pixels, start).unwrap_err(), BundleError::OtherScene);
        }
    }

    fn options() -> Options {
        let others = [Focal, Extra].map(Which::Class).to_vec();
        Options { refine: Refine { others, ..Refine::default() }, ..Options::default() }
    }
}
