//! One model, made ready: what is taken for the truth, and what each repeat sees of it.

use std::collections::{BTreeMap, BTreeSet};

use super::super::field::Field;
use super::super::{Candidates, Heuristic, Request, SelectionError};
use super::plan::{Noise, Plan, Pool};
use crate::bundle::{self, BundleError, Mode, Options, Outcome, Subsets};
use crate::scene::{
    Camera, CameraId, Estimates, ImageId, Keypoint, Keypoints, Point3D, Points3D, Scene,
    TrackElement,
};
use crate::stability::spread::View;
use crate::stability::{InputFile, failure_of_sample, views};
use crate::synth::{Noiseless, Purpose, Random, Starts};

/// How far off every adjustment starts: intrinsics by a hundredth of themselves, poses and points by a few px.
const START_OFF: f64 = 0.01;

/// A model as an experiment takes it.
#[derive(Debug, Clone)]
pub struct Input {
    /// What it is called.
    pub name: String,
    /// The files it is from.
    pub files: Vec<InputFile>,
    /// What is in them.
    pub scene: Scene,
    /// What is known of its cameras from elsewhere; nothing where all that is known is the model itself.
    pub truth: BTreeMap<CameraId, Camera>,
}

/// Why a model cannot be part of an experiment.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GroundError {
    /// The images cannot be chosen from.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// The model cannot be adjusted.
    #[error(transparent)]
    Bundle(#[from] BundleError),
    /// There is nothing to compare with.
    #[error("its refinement gives nothing to compare subsets with: {0}")]
    Refinement(String),
    /// No residual is left over.
    #[error("no residual is left over: the noise of its pixels is not known")]
    NoNoise,
    /// The truth lacks a camera.
    #[error("the truth has no camera {0}")]
    NoTruth(CameraId),
    /// The truth is about other images.
    #[error("the truth's camera {0} has images of another size")]
    TruthOfOtherSize(CameraId),
}

/// A model made ready.
#[derive(Debug, Clone)]
pub(super) struct Ground {
    pub name: String,
    pub files: Vec<InputFile>,
    pub candidates: Candidates,
    /// The cameras whose intrinsics are wanted.
    pub wanted: Vec<CameraId>,
    /// With what each wanted camera is compared.
    pub references: BTreeMap<CameraId, Camera>,
    /// The cameras of the full reconstruction, with which adjustments start.
    pub refined: BTreeMap<CameraId, Camera>,
    pub views: BTreeMap<CameraId, View>,
    pub sigma_px: f64,
    pub has_truth: bool,
    /// Images or frames that hang together.
    pub unit_count: usize,
    /// The model's structure, of which every choice is a mask.
    pub subsets: Subsets,
    /// What is seen, as it was measured and without noise.
    measured: Vec<Vec<[f64; 2]>>,
    noiseless: Noiseless,
    /// Where adjustments start from: off the full reconstruction.
    starts: Starts,
}

impl Ground {
    pub(super) fn new(input: Input, plan: &Plan) -> Result<Self, GroundError> {
        let Input { name, files, scene, truth } = input;
        let geometry = scene.geometry.as_ref().ok_or(BundleError::NoGeometry)?.clone();
        let has_truth = !truth.is_empty();
        let (refined, outcome) = adjusted(scene, Mode::SelfCalibration, plan)?;
        let sigma_px = outcome.sigma_px.ok_or(GroundError::NoNoise)?;
        let candidates = Candidates::new(&refined, plan.refine.clone(), sigma_px)?;
        let candidates = candidates.with_frames_of(&geometry);
        let wanted = match plan.camera {
            Some(camera) => vec![camera],
            None => candidates.cameras().to_vec(),
        };
        let cameras = refined.cameras.clone();
        let views = views(&refined);
        let mut references = BTreeMap::new();
        for id in &wanted {
            let of = if has_truth { &truth } else { &cameras };
            references.insert(*id, *of.get(id).ok_or(GroundError::NoTruth(*id))?);
            let own = |camera: &Camera| [camera.width, camera.height];
            if own(&references[id]) != own(&cameras[id]) {
                return Err(GroundError::TruthOfOtherSize(*id));
            }
        }
        let mut world = lean(refined);
        if has_truth && plan.noise == Noise::Redraw {
            // What is known is true of what is seen then: poses and points settle for it.
            world.cameras.extend(truth);
            world = adjusted(world, Mode::BundleAdjustment, plan)?.0;
        }
        let noiseless = Noiseless::of(&world);
        world.cameras.clone_from(&cameras);
        let all: Vec<usize> = (0..candidates.image_count()).collect();
        let least = wanted.len().max(2);
        let unit_count = Field::new(&candidates, &request(&all, least, 0, plan))?.groups.len();
        Ok(Self {
            name,
            files,
            candidates,
            wanted,
            references,
            refined: cameras,
            views,
            sigma_px,
            has_truth,
            unit_count,
            measured: world.pixels(),
            noiseless,
            subsets: Subsets::new(&world, &options(Mode::SelfCalibration, plan))?,
            starts: Starts::around(&world),
        })
    }

    /// What a repeat has to choose from, ascending.
    pub(super) fn pool(&self, plan: &Plan, repeat: &Repeat) -> Result<Vec<usize>, SelectionError> {
        let all: Vec<usize> = (0..self.candidates.image_count()).collect();
        let by = match plan.pool {
            Pool::Random(_) => "random",
            Pool::Window(_) => "window",
        };
        let size = plan.pool.size(self.unit_count);
        let request = request(&all, size, repeat.pool_seed, plan);
        let Some(by) = Heuristic::named(by) else { return Ok(all) };
        let choices = by.choose(&self.candidates, &request)?;
        let mut pool: Vec<usize> = choices.into_iter().flat_map(|choice| choice.images).collect();
        pool.sort_unstable();
        Ok(pool)
    }

    /// What a repeat sees, and from where its adjustments start.
    pub(super) fn seen(&self, plan: &Plan, repeat: &Repeat) -> (Vec<Vec<[f64; 2]>>, Estimates) {
        let pixels = match plan.noise {
            Noise::Redraw => self.noiseless.with_noise(self.sigma_px, plan.seed, repeat.stream),
            Noise::Keep => self.measured.clone(),
        };
        (pixels, self.starts.off_by(START_OFF, plan.seed, repeat.stream))
    }

    pub(super) fn ids(&self, images: &[usize]) -> BTreeSet<ImageId> {
        images.iter().map(|&image| self.candidates.image(image)).collect()
    }
}

/// What chance decides in one repeat of one model, the same for all heuristics and sizes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Repeat {
    pub stream: u64,
    pool_seed: u64,
    pub heuristic_seed: u64,
}

impl Repeat {
    pub(super) fn new(plan: &Plan, model: usize, repeat: usize) -> Self {
        let stream = (model as u64).wrapping_shl(32).wrapping_add(repeat as u64);
        let mut random = Random::new(plan.seed, stream, Purpose::Selection);
        Self { stream, pool_seed: random.bits(), heuristic_seed: random.bits() }
    }
}

pub(super) fn request<'a>(pool: &'a [usize], size: usize, seed: u64, plan: &Plan) -> Request<'a> {
    Request { pool, size, seed, unit: plan.unit, camera: plan.camera }
}

fn options(mode: Mode, plan: &Plan) -> Options {
    Options { mode, refine: plan.refine.clone(), ..Options::default() }
}

fn adjusted(scene: Scene, mode: Mode, plan: &Plan) -> Result<(Scene, Outcome), GroundError> {
    let adjusted = bundle::adjust(scene, &options(mode, plan), &mut |_| {})?;
    let cameras = adjusted.outcome.cameras.iter().filter(|camera| camera.images > 0);
    match cameras.filter_map(|camera| failure_of_sample(&adjusted.outcome, camera.id)).next() {
        Some(failure) => Err(GroundError::Refinement(failure)),
        None => Ok((adjusted.scene, adjusted.outcome)),
    }
}

/// The scene with what adjustments take of it alone: keypoints that are seen as points, and a pose for each image.
fn lean(mut scene: Scene) -> Scene {
    let Some(geometry) = &mut scene.geometry else { return scene };
    let poses = geometry.poses();
    let mut places: BTreeMap<ImageId, Vec<u32>> = BTreeMap::new();
    for ((id, image), pose) in geometry.images.iter_mut().zip(poses) {
        if let Some(pose) = pose {
            image.cam_from_world = pose.into();
        }
        let mut kept = Keypoints::default();
        let own = places.entry(*id).or_default();
        for keypoint @ Keypoint { point, .. } in image.keypoints.iter() {
            own.push(u32::try_from(kept.len()).unwrap_or(u32::MAX));
            if point.is_some() {
                kept.push(keypoint);
            }
        }
        image.keypoints = kept;
    }
    geometry.mounting = None;
    let mut points = Points3D::default();
    for point in geometry.points.iter() {
        let moved = |TrackElement { image, keypoint }| {
            let place = places.get(&image)?.get(keypoint as usize)?;
            Some(TrackElement { image, keypoint: *place })
        };
        let track: Vec<TrackElement> = point.track.filter_map(moved).collect();
        let Point3D { id, xyz, rgb, error_px, .. } = point;
        points.push(Point3D { id, xyz, rgb, error_px, track });
    }
    geometry.points = points;
    scene
}
