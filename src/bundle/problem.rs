//! A scene as a problem: built once, the same for any number of threads.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Vector3};

use super::chunk::{self, Chunk, Numbering, Sighted};
use super::frame::Frame;
use super::limits::Limits;
use super::linearize::{Kernel, Lens, MOST_PARAMS, Params, Placed, Sighting};
use super::options::{Options, Which};
use super::schur::Layout;
use super::shape::Shape;
use super::{BundleError, gauge};
use crate::scene::{CameraId, Geometry, ImageId, Keypoints, Scene};

/// All unknowns, in the frame of the adjustment.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub poses: Vec<Placed>,
    pub params: Vec<Params>,
    pub points: Vec<Vector3<f64>>,
}

/// What was left out of the adjustment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dropped {
    /// Observations that cannot be projected at the start: behind the camera, or beyond what the lens sees.
    pub unprojectable: usize,
    /// Points that a single image sees, or none: they tell nothing of anything else.
    pub lone_points: usize,
    /// The observations of these points.
    pub of_lone_points: usize,
}

/// A scene, ready to be adjusted.
#[derive(Debug, Clone)]
pub(super) struct Problem {
    pub chunks: Vec<Chunk>,
    pub lenses: Vec<Lens>,
    pub start: State,
    pub layout: Layout,
    pub shape: Shape,
    pub limits: Limits,
    pub frame: Frame,
    /// The images with their cameras, by their number here.
    pub images: Vec<ImageId>,
    /// How many observations each image has.
    pub sightings: Vec<usize>,
    pub cameras: Vec<CameraId>,
    /// The camera of each image.
    pub camera_of: Vec<u32>,
    /// Each point's place in the scene.
    pub points: Vec<usize>,
    pub observations: usize,
    pub dropped: Dropped,
    pub components: usize,
}

impl Problem {
    pub(super) fn new(scene: &Scene, options: &Options) -> Result<Self, BundleError> {
        let (mut problem, tracks) = Self::counted(scene, options)?;
        problem.lay_out(&tracks, options)?;
        Ok(problem)
    }

    /// What is adjusted of a scene and the sightings of its points, not yet cut into chunks.
    pub(super) fn counted(
        scene: &Scene,
        options: &Options,
    ) -> Result<(Self, Vec<Sighted>), BundleError> {
        let geometry = scene.geometry.as_ref().ok_or(BundleError::NoGeometry)?;
        check_names(scene, options)?;
        let (images, camera_of, cameras) = number(geometry);
        let lenses = lenses(scene, &cameras, options);
        let limits = Limits::new(scene, &cameras, &lenses, options);
        let frame = Frame::of(&geometry.points.iter().map(|point| point.xyz).collect::<Vec<_>>());
        let mut start = State {
            poses: placed(&frame, &images, &geometry.poses())?,
            params: cameras
                .iter()
                .map(|id| padded(scene.cameras[id].intrinsics.params()))
                .collect(),
            points: Vec::new(),
        };
        limits.put_inside(&mut start, &[]);
        let mut problem = Self {
            chunks: Vec::new(),
            layout: Layout::new(0, std::iter::empty()),
            shape: Shape::default(),
            limits,
            lenses,
            start,
            frame,
            sightings: vec![0; images.len()],
            images,
            cameras,
            camera_of,
            points: Vec::new(),
            observations: 0,
            dropped: Dropped::default(),
            components: 0,
        };
        let tracks = problem.choose(geometry, options);
        problem.count(&tracks)?;
        Ok((problem, tracks))
    }

    /// The sightings of each point, by the problem's numbers of the images.
    pub(super) fn tracks(&self) -> Vec<Sighted> {
        let mut tracks = Vec::with_capacity(self.points.len());
        for chunk in &self.chunks {
            let mut start = 0;
            for &end in &chunk.ends {
                let track = chunk.sightings[start..end as usize].iter();
                let outside = |seen: &Sighting| Sighting {
                    image: chunk.images[seen.image as usize],
                    ..*seen
                };
                tracks.push(track.map(outside).collect());
                start = end as usize;
            }
        }
        tracks
    }

    /// What is left of a sighting of a point at the start; none if it cannot be projected.
    pub(super) fn residual(&self, seen: &Sighting, point: &Vector3<f64>) -> Option<[f64; 2]> {
        let image = seen.image as usize;
        let camera = self.camera_of[image] as usize;
        let residual = self.lenses[camera].kernel.residual;
        residual(&self.start.params[camera], &self.start.poses[image], point, &seen.xy)
    }

    /// The same cameras and images, with no point yet.
    pub(super) fn bare(&self) -> Self {
        let Self { lenses, limits, frame, images, cameras, camera_of, dropped, .. } = self;
        let State { poses, params, .. } = &self.start;
        Self {
            chunks: Vec::new(),
            lenses: lenses.clone(),
            start: State { poses: poses.clone(), params: params.clone(), points: Vec::new() },
            layout: Layout::new(0, std::iter::empty()),
            shape: Shape::default(),
            limits: limits.clone(),
            frame: *frame,
            images: images.clone(),
            sightings: vec![0; images.len()],
            cameras: cameras.clone(),
            camera_of: camera_of.clone(),
            points: Vec::new(),
            observations: 0,
            dropped: *dropped,
            components: 0,
        }
    }

    /// The points that are adjusted, and their sightings, sorted by the images that see them.
    fn choose(&mut self, geometry: &Geometry, options: &Options) -> Vec<Sighted> {
        let keypoints: Vec<&Keypoints> =
            geometry.images.values().map(|image| &image.keypoints).collect();
        let mut chosen: Vec<(Sighted, usize, Vector3<f64>)> = Vec::new();
        for (index, point) in geometry.points.iter().enumerate() {
            let xyz = self.frame.point_in(point.xyz);
            let mut track: Sighted = Vec::with_capacity(point.track.len());
            for element in point.track {
                let keypoint = element.keypoint;
                let Ok(place) = self.images.binary_search(&element.image) else { continue };
                let Some(seen) = keypoints[place].get(keypoint as usize) else { continue };
                let Ok(image) = place.try_into() else { continue };
                let sighting = Sighting { xy: seen.xy, image, keypoint };
                match self.residual(&sighting, &xyz) {
                    Some(_) => track.push(sighting),
                    None => self.dropped.unprojectable += 1,
                }
            }
            // By image, and by place where an image sees a point twice: the order in a file tells nothing.
            track.sort_by(|a, b| {
                let by_place = || a.xy[0].total_cmp(&b.xy[0]).then(a.xy[1].total_cmp(&b.xy[1]));
                a.image.cmp(&b.image).then_with(by_place)
            });
            let is_lone = track.first().map(|a| a.image) == track.last().map(|b| b.image);
            if track.is_empty() || is_lone && options.mode.moves_points() {
                self.dropped.lone_points += 1;
                self.dropped.of_lone_points += track.len();
                continue;
            }
            chosen.push((track, index, xyz));
        }
        chosen.sort_by_cached_key(|(track, index, _)| {
            (track.first().map(|a| a.image), track.last().map(|a| a.image), *index)
        });
        self.points = chosen.iter().map(|(_, index, _)| *index).collect();
        self.start.points = chosen.iter().map(|(_, _, xyz)| *xyz).collect();
        chosen.into_iter().map(|(track, ..)| track).collect()
    }

    /// Counts the sightings.
    pub(super) fn count(&mut self, tracks: &[Sighted]) -> Result<(), BundleError> {
        self.sightings.fill(0);
        for sighting in tracks.iter().flatten() {
            self.sightings[sighting.image as usize] += 1;
        }
        self.observations = self.sightings.iter().sum();
        if self.observations == 0 {
            let unprojectable = self.dropped.unprojectable;
            let total = unprojectable + self.dropped.of_lone_points;
            return Err(BundleError::NoObservation { total, unprojectable });
        }
        Ok(())
    }

    /// Cuts the points into chunks, once their sightings are counted, and gives every unknown its place.
    pub(super) fn lay_out(
        &mut self,
        tracks: &[Sighted],
        options: &Options,
    ) -> Result<(), BundleError> {
        let (poses, pairs) = (options.mode.moves_poses(), options.mode.moves_points());
        let moving = if poses { self.images.len() } else { 0 };
        self.layout = Layout::new(moving, self.lenses.iter().map(|lens| lens.free.len()));
        let (components, count) = gauge::components(self.images.len(), tracks);
        self.components = count;
        if poses && pairs {
            let held = gauge::held(&components, count, &self.sightings, &self.start.poses);
            held.iter().for_each(|&unknown| self.layout.held[unknown] = true);
        }
        let numbering =
            Numbering { camera_of: &self.camera_of, width: self.layout.width, poses, pairs };
        self.chunks = chunk::cut(tracks, &numbering)?;
        self.shape = Shape::new(&self.layout, &self.chunks);
        self.fits(self.bytes(), options)
    }

    /// How much memory the adjustment takes.
    fn bytes(&self) -> usize {
        let chunk = |chunk: &Chunk| {
            4 * chunk.pose_pose.len() + 24 * chunk.sightings.len() + 16 * chunk.images.len()
        };
        let sums =
            |chunk: &Chunk| 8 * chunk.sum_length() + 1000 * (chunk.longest + chunk.cameras.len());
        let most = self.chunks.iter().map(sums).max().unwrap_or(0);
        let at_a_time = super::solver::at_a_time(self.chunks.len());
        let points = 4 * size_of::<Vector3<f64>>() * self.start.points.len();
        let chunks: usize = self.chunks.iter().map(chunk).sum();
        self.shape.pattern.bytes() + points + chunks + at_a_time * most
    }

    fn fits(&self, needed: usize, options: &Options) -> Result<(), BundleError> {
        match options.memory {
            Some(limit) if needed > limit => {
                Err(BundleError::Memory { images: self.images.len(), needed, limit })
            }
            _ => Ok(()),
        }
    }

    /// How many parameters move that some observation depends on.
    pub(super) fn unknowns(&self, options: &Options) -> usize {
        let moving = self.layout.held.iter().filter(|&&held| !held).count();
        let unseen = self.sightings.iter().filter(|&&count| count == 0).count();
        let poses = if options.mode.moves_poses() { 6 * unseen } else { 0 };
        let points = if options.mode.moves_points() { 3 * self.points.len() } else { 0 };
        let idle = self.cameras.iter().zip(&self.lenses).enumerate().filter(|(camera, _)| {
            let sees = |image: usize| {
                self.camera_of[image] as usize == *camera && self.sightings[image] > 0
            };
            !(0..self.images.len()).any(sees)
        });
        let idle: usize = idle.map(|(_, (_, lens))| lens.free.len()).sum();
        moving + points - poses - idle
    }
}

/// The poses of images in a frame.
pub(super) fn placed(
    frame: &Frame,
    images: &[ImageId],
    poses: &[Option<Isometry3<f64>>],
) -> Result<Vec<Placed>, BundleError> {
    let placed = |(image, pose): (&ImageId, &Option<Isometry3<f64>>)| {
        pose.as_ref().map(|pose| frame.pose_in(pose)).ok_or(BundleError::NoPose(*image))
    };
    images.iter().zip(poses).map(placed).collect()
}

pub(super) fn padded(params: &[f64]) -> Params {
    let mut padded = [0.0; MOST_PARAMS];
    padded[..params.len()].copy_from_slice(params);
    padded
}

/// Images, the camera of each, and the cameras that took one.
fn number(geometry: &Geometry) -> (Vec<ImageId>, Vec<u32>, Vec<CameraId>) {
    let used: BTreeSet<CameraId> = geometry.images.values().map(|image| image.camera).collect();
    let numbers: BTreeMap<CameraId, u32> = used.iter().copied().zip(0..).collect();
    let camera_of = geometry.images.values().map(|image| numbers[&image.camera]).collect();
    (geometry.images.keys().copied().collect(), camera_of, used.into_iter().collect())
}

fn lenses(scene: &Scene, cameras: &[CameraId], options: &Options) -> Vec<Lens> {
    let lens = |id: &CameraId| {
        let intrinsics = &scene.cameras[id].intrinsics;
        let which = options.refine.of(*id);
        let params = intrinsics.model().params.iter().enumerate();
        let moves = options.mode.moves_intrinsics();
        let free = params.filter(|(_, param)| moves && which.iter().any(|which| which.is(param)));
        Lens { kernel: Kernel::of(intrinsics), free: free.map(|(place, _)| place).collect() }
    };
    cameras.iter().map(lens).collect()
}

/// A name that means nothing is a mistake of the user's, never a parameter that silently stays.
fn check_names(scene: &Scene, options: &Options) -> Result<(), BundleError> {
    let names = |id: &CameraId| {
        let params = scene.cameras[id].intrinsics.model().params.iter();
        params.map(|param| param.name).collect::<Vec<_>>()
    };
    let Options { refine, priors, bounds, .. } = options;
    let limited = || priors.iter().map(|p| &p.of).chain(bounds.iter().map(|b| &b.of));
    let mut named = refine.cameras.keys().chain(limited().filter_map(|of| of.camera.as_ref()));
    if let Some(id) = named.find(|id| !scene.cameras.contains_key(id)) {
        return Err(BundleError::NoCamera(*id));
    }
    let others: Vec<CameraId> =
        scene.cameras.keys().filter(|id| !refine.cameras.contains_key(id)).copied().collect();
    let mut asked = vec![(None, refine.others.clone(), others)];
    asked.extend(refine.cameras.iter().map(|(id, which)| (Some(*id), which.clone(), vec![*id])));
    asked.extend(limited().map(|of| {
        let ids = of.camera.map_or_else(|| scene.cameras.keys().copied().collect(), |id| vec![id]);
        (of.camera, vec![Which::Named(of.name.clone())], ids)
    }));
    for (camera, which, ids) in asked {
        let known: BTreeSet<&str> = ids.iter().flat_map(names).collect();
        for which in which {
            match which {
                Which::Named(name) if !ids.is_empty() && !known.contains(name.as_str()) => {
                    let known = known.into_iter().collect::<Vec<_>>().join(", ");
                    return Err(BundleError::NoParam { name, camera, known });
                }
                Which::Named(_) | Which::Class(_) => {}
            }
        }
    }
    Ok(())
}
