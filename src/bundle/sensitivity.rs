//! How every pixel of a scene moves with its point and with the free parameters of its camera, at the scene as it is.
//!
//! The images, points and observations are those that an adjustment would take.

use std::ops::Range;

use nalgebra::Vector3;

use super::chunk::Sighted;
use super::linearize::{Lens, Row, Run, Sighting, wrt_pose};
use super::options::{Options, Refine};
use super::outcome::free_params;
use super::point::{InverseFactor, PointBlock};
use super::problem::Problem;
use super::{BundleError, Dropped, FreeParam};
use crate::scene::{CameraId, ImageId, Scene};

/// How the pixels of a scene move. World coordinates are those of the adjustment: centred, and of size one.
#[derive(Debug, Clone)]
pub struct Sensitivities {
    /// The images, ascending; others refer to them by their place here.
    pub images: Vec<ImageId>,
    /// The cameras that took them, ascending.
    pub cameras: Vec<CameraId>,
    /// The camera of each image, by its place.
    pub camera_of: Vec<usize>,
    /// The free parameters, camera by camera.
    pub params: Vec<FreeParam>,
    /// Where from each image was taken.
    pub centres: Vec<Vector3<f64>>,
    /// Where to: its optical axis, of length one.
    pub axes: Vec<Vector3<f64>>,
    /// The points.
    pub points: Vec<Vector3<f64>>,
    /// The place of each point in the scene.
    pub places: Vec<usize>,
    /// What an adjustment would leave out.
    pub dropped: Dropped,
    /// Of each camera its share of `params`.
    shares: Vec<Range<usize>>,
    ends: Vec<usize>,
    sensed: Vec<Sensed>,
    wrt_params: Vec<f64>,
}

/// An observation, and how its pixel moves with the point.
#[derive(Debug, Clone, Copy)]
pub struct Sensed {
    /// The place of the image.
    pub image: usize,
    /// Where it was seen, in px.
    pub xy: [f64; 2],
    /// d pixel / d world point.
    pub wrt_point: [[f64; 3]; 2],
    /// Where d pixel / d params begins.
    at: usize,
}

impl Sensitivities {
    /// Those of a scene of which these parameters move.
    pub fn new(scene: &Scene, refine: Refine) -> Result<Self, BundleError> {
        let options = Options { refine, ..Options::default() };
        let (problem, tracks) = Problem::counted(scene, &options)?;
        let mut next = 0;
        let share = |lens: &Lens| {
            next += lens.free.len();
            next - lens.free.len()..next
        };
        let poses = &problem.start.poses;
        let mut made = Self {
            images: problem.images.clone(),
            cameras: problem.cameras.clone(),
            camera_of: problem.camera_of.iter().map(|&camera| camera as usize).collect(),
            params: free_params(scene, &problem, &[]),
            centres: poses.iter().map(|pose| -pose.rotation.tr_mul(&pose.translation)).collect(),
            axes: poses.iter().map(|pose| pose.rotation.row(2).transpose()).collect(),
            points: problem.start.points.clone(),
            places: problem.points.clone(),
            dropped: problem.dropped,
            shares: problem.lenses.iter().map(share).collect(),
            ends: Vec::with_capacity(problem.points.len()),
            sensed: Vec::with_capacity(problem.observations),
            wrt_params: Vec::new(),
        };
        tracks.iter().zip(&problem.start.points).for_each(|it| made.add(&problem, it));
        Ok(made)
    }

    fn add(&mut self, problem: &Problem, (track, &point): (&Sighted, &Vector3<f64>)) {
        let mut rows = [Row::ZERO];
        for sighting in track {
            let image = sighting.image as usize;
            let camera = self.camera_of[image];
            let lens = &problem.lenses[camera];
            let pose = &problem.start.poses[image..=image];
            let sightings = &[Sighting { image: 0, ..*sighting }];
            let run = Run { point, sightings, images: &[0], poses: pose };
            // What cannot be projected is no part of a problem.
            if !(lens.kernel.linearize)(lens, &problem.start.params[camera], &run, &mut rows) {
                continue;
            }
            let [Row { wrt_point, wrt_params, .. }] = &rows;
            let at = self.wrt_params.len();
            self.sensed.push(Sensed { image, xy: sighting.xy, wrt_point: *wrt_point, at });
            for row in wrt_params {
                self.wrt_params.extend_from_slice(&row[..lens.free.len()]);
            }
        }
        self.ends.push(self.sensed.len());
    }

    /// A camera's share of the parameters.
    pub fn share(&self, camera: usize) -> Range<usize> {
        self.shares[camera].clone()
    }

    /// The observations of a point, by image.
    pub fn track(&self, point: usize) -> &[Sensed] {
        let start = point.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.sensed[start..self.ends[point]]
    }

    /// All observations, point after point.
    pub fn observations(&self) -> &[Sensed] {
        &self.sensed
    }

    /// d pixel / d params of the observation's camera, its two rows.
    pub fn wrt_params(&self, seen: &Sensed) -> [&[f64]; 2] {
        let count = self.shares[self.camera_of[seen.image]].len();
        [0, 1].map(|row| &self.wrt_params[seen.at + row * count..][..count])
    }
}

impl Sensed {
    /// d pixel / d pose, its two rows: turned about the world's origin, then moved, both in world coordinates.
    #[inline(always)]
    pub fn wrt_pose(&self, point: &Vector3<f64>) -> [[f64; 6]; 2] {
        wrt_pose(&self.wrt_point, point)
    }
}

/// What eliminates a point that is sensed so.
pub(crate) fn eliminator(track: &[&Sensed]) -> InverseFactor {
    PointBlock::of_derivatives(track.iter().map(|seen| &seen.wrt_point)).factor(0.0)
}
