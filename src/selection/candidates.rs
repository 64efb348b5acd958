//! A reconstruction as heuristics see it: built once, borrowed by all.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::OnceLock;

use nalgebra::{DMatrix, Vector3};

use super::SelectionError;
use super::information;
use super::mapping;
use crate::bundle::{FreeParam, Refine, Sensitivities};
use crate::camera::{Grid, ParamClass};
use crate::scene::{CameraId, Geometry, ImageId, Scene};

/// The standard deviation of a pixel that is taken where none is known. It scales every figure alike, and chooses nothing.
pub const SIGMA_PX: f64 = 1.0;

/// A reconstruction as heuristics see it. Images are known by their places among the scene's, in the order of their ids.
#[derive(Debug, Clone)]
pub struct Candidates {
    pub(super) rows: Sensitivities,
    names: Vec<String>,
    /// The place of each image in the sequence.
    ranks: Vec<usize>,
    /// The frame of each image; images without one are frames of their own.
    frames: Vec<usize>,
    /// The points that each image sees, ascending.
    pub(super) points_of: Vec<Vec<usize>>,
    /// The images that see a point that an image sees, itself among them, ascending; made when first asked for.
    partners: OnceLock<Vec<Vec<usize>>>,
    /// The parts of the image plane where each image sees something, ascending.
    pub(super) cells_of: Vec<Vec<usize>>,
    /// What each image tells of its camera, points held.
    own: Vec<DMatrix<f64>>,
    /// For each camera, what a small change of its parameters does to its pixels.
    pub(super) mappings: Vec<Option<DMatrix<f64>>>,
    /// How well each parameter is known beforehand, for the greedy heuristic.
    prior_stds: Vec<f64>,
    pub(super) sigma_px: f64,
}

impl Candidates {
    /// Those of a scene of which these parameters are wanted, its pixels of standard deviation `sigma_px`.
    pub fn new(scene: &Scene, refine: Refine, sigma_px: f64) -> Result<Self, SelectionError> {
        let rows = Sensitivities::new(scene, refine)?;
        if rows.params.is_empty() {
            return Err(SelectionError::NothingFree);
        }
        let images: Vec<_> = scene.geometry.iter().flat_map(|it| it.images.values()).collect();
        let names: Vec<String> = images.iter().map(|image| image.name.clone()).collect();
        let grids = images.iter().map(|image| {
            let camera = &scene.cameras[&image.camera];
            Grid::new(camera.width, camera.height)
        });
        let mapping = |(camera, id): (usize, &CameraId)| {
            let free: Vec<usize> =
                rows.params[rows.share(camera)].iter().map(|p| p.place).collect();
            mapping::mapping(&scene.cameras[id], &free)
        };
        Ok(Self {
            partners: OnceLock::new(),
            ranks: ranks(&names, &rows.camera_of),
            frames: frames(scene.geometry.as_ref(), &rows.images),
            points_of: points_of(&rows),
            cells_of: cells_of(&rows, &grids.collect::<Vec<_>>()),
            own: information::own(&rows, sigma_px),
            mappings: rows.cameras.iter().enumerate().map(mapping).collect(),
            prior_stds: rows.params.iter().map(|param| prior_std(scene, param)).collect(),
            names,
            rows,
            sigma_px,
        })
    }

    /// The same with the frames of this geometry, of the same images: an adjustment may have dissolved them.
    pub(super) fn with_frames_of(mut self, geometry: &Geometry) -> Self {
        self.frames = frames(Some(geometry), &self.rows.images);
        self
    }

    /// How many images there are.
    pub fn image_count(&self) -> usize {
        self.names.len()
    }

    /// The id of an image.
    pub fn image(&self, place: usize) -> ImageId {
        self.rows.images[place]
    }

    /// The name of an image.
    pub fn name(&self, place: usize) -> &str {
        &self.names[place]
    }

    /// The camera that took an image.
    pub fn camera(&self, place: usize) -> CameraId {
        self.rows.cameras[self.rows.camera_of[place]]
    }

    /// The cameras that took images, ascending.
    pub fn cameras(&self) -> &[CameraId] {
        &self.rows.cameras
    }

    /// The free parameters, camera by camera: the order of rows and columns of all information.
    pub fn params(&self) -> &[FreeParam] {
        &self.rows.params
    }

    /// The place of an image in the sequence: that of names, where 2 comes before 10. Several cameras went through it side by
    /// side, each from its first name to its last, so that a stretch has images of all of them.
    pub fn rank(&self, place: usize) -> usize {
        self.ranks[place]
    }

    /// The number of the frame that an image belongs to.
    pub fn frame(&self, place: usize) -> usize {
        self.frames[place]
    }

    /// How many points that others see too an image sees.
    pub fn point_count(&self, place: usize) -> usize {
        self.points_of[place].len()
    }

    /// Where from an image was taken, in the coordinates of the adjustment.
    pub fn centre(&self, place: usize) -> Vector3<f64> {
        self.rows.centres[place]
    }

    /// Where to an image looks: a vector of length one.
    pub fn axis(&self, place: usize) -> Vector3<f64> {
        self.rows.axes[place]
    }

    /// What an image tells of its own camera's parameters when points are held and its pose is free.
    pub fn own_information(&self, place: usize) -> &DMatrix<f64> {
        &self.own[place]
    }

    /// The images that see a point that an image sees, itself among them, ascending.
    pub(super) fn partners_of(&self, image: usize) -> &[usize] {
        &self.partners.get_or_init(|| partners_of(&self.rows, &self.points_of))[image]
    }

    /// A camera's share of the parameters; empty for one that took no image.
    pub(super) fn share_of(&self, camera: CameraId) -> Range<usize> {
        self.rows.cameras.binary_search(&camera).map_or(0..0, |place| self.rows.share(place))
    }

    /// What is known of a parameter before any image.
    pub(super) fn prior_std(&self, param: usize) -> f64 {
        self.prior_stds[param]
    }
}

/// The greedy heuristic's first images must not be chosen by a singular determinant; a hundredth of this changes no later choice.
fn prior_std(scene: &Scene, param: &FreeParam) -> f64 {
    let camera = &scene.cameras[&param.camera];
    let side = camera.width.max(camera.height) as f64 / 1024.0;
    match camera.intrinsics.model().params[param.place].class {
        ParamClass::Focal => 200.0 * side,
        ParamClass::PrincipalPoint => 100.0 * side,
        ParamClass::Extra | ParamClass::Metadata => 0.3,
    }
}

fn ranks(names: &[String], cameras: &[usize]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..names.len()).collect();
    let by_name = |&a: &usize, &b: &usize| -> Ordering {
        natord::compare(&names[a], &names[b]).then_with(|| names[a].cmp(&names[b]))
    };
    order.sort_by(by_name);
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    let mut places = vec![0; names.len()];
    for &image in &order {
        let count = counts.entry(cameras[image]).or_default();
        places[image] = *count;
        *count += 1;
    }
    // How far each is through its camera's images, in products so that equal shares are equal.
    let through = |&a: &usize, &b: &usize| {
        let count = |image: usize| counts[&cameras[image]];
        ((2 * places[a] + 1) * count(b)).cmp(&((2 * places[b] + 1) * count(a)))
    };
    // Stable: of those as far through, the first name.
    order.sort_by(through);
    let mut ranks = vec![0; names.len()];
    order.iter().enumerate().for_each(|(rank, &place)| ranks[place] = rank);
    ranks
}

fn frames(geometry: Option<&Geometry>, images: &[ImageId]) -> Vec<usize> {
    let mut of_image: BTreeMap<u64, usize> = BTreeMap::new();
    let mounting = geometry.and_then(|geometry| geometry.mounting.as_ref());
    for (number, frame) in mounting.iter().flat_map(|it| it.frames.values()).enumerate() {
        // Data of other sensors have numbers of their own.
        let kind = crate::scene::SensorKind::Camera;
        let of_cameras = frame.data.iter().filter(|(sensor, _)| sensor.kind == kind);
        of_image.extend(of_cameras.map(|&(_, datum)| (datum, number)));
    }
    let alone = mounting.map_or(0, |mounting| mounting.frames.len());
    let frame = |(place, id): (usize, &ImageId)| {
        of_image.get(&u64::from(id.0)).copied().unwrap_or(alone + place)
    };
    images.iter().enumerate().map(frame).collect()
}

fn points_of(rows: &Sensitivities) -> Vec<Vec<usize>> {
    let mut points = vec![Vec::new(); rows.images.len()];
    for point in 0..rows.points.len() {
        for seen in rows.track(point) {
            points[seen.image].push(point);
        }
    }
    points.iter_mut().for_each(Vec::dedup);
    points
}

fn partners_of(rows: &Sensitivities, points_of: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let partners = |points: &Vec<usize>| {
        let mut is_partner = vec![false; points_of.len()];
        let seen = points.iter().flat_map(|&point| rows.track(point));
        seen.for_each(|seen| is_partner[seen.image] = true);
        (0..points_of.len()).filter(|&image| is_partner[image]).collect()
    };
    points_of.iter().map(partners).collect()
}

/// A part of the image plane is so many cells wide and high; single cells would count points.
pub(super) const CELLS_PER_PART: usize = 5;

/// The parts of the image plane in which each image sees something.
fn cells_of(rows: &Sensitivities, grids: &[Grid]) -> Vec<Vec<usize>> {
    let mut cells = vec![Vec::new(); rows.images.len()];
    for seen in rows.observations() {
        let grid = &grids[seen.image];
        if let Some(cell) = grid.cell_at(seen.xy) {
            let (row, column) = (cell / grid.columns(), cell % grid.columns());
            let columns = grid.columns().div_ceil(CELLS_PER_PART);
            cells[seen.image].push(row / CELLS_PER_PART * columns + column / CELLS_PER_PART);
        }
    }
    for cells in &mut cells {
        cells.sort_unstable();
        cells.dedup();
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_cameras_go_through_the_sequence_side_by_side() {
        let names = ["b/2", "b/10", "a/1", "a/2", "a/3", "a/10"].map(str::to_owned);
        // Of camera b the first is as far as between the first two of camera a.
        assert_eq!(ranks(&names, &[1, 1, 0, 0, 0, 0]), [1, 4, 0, 2, 3, 5]);
        assert_eq!(ranks(&names, &[0; 6]), [4, 5, 0, 1, 2, 3]);
    }
}
