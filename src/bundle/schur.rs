//! The system that is left when points are eliminated: poses first, the cameras' intrinsics as its border last.

use super::chunk::{Chunk, NONE, pair};
use super::eliminate::Sums;
use super::linearize::{MOST_PARAMS, Params};
use super::shape::Shape;
use super::tiles::Tiles;

/// Where each unknown of poses and cameras stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layout {
    /// How many unknowns the poses are.
    pub poses: usize,
    /// Where each camera's share of the border begins.
    pub cameras: Vec<usize>,
    /// How wide each camera's share is: the same for all, for the processor's sake.
    pub width: usize,
    /// How many unknowns there are.
    pub size: usize,
    /// Unknowns that stay: those that fix the gauge, and those that fill up a camera's share.
    pub held: Vec<bool>,
}

impl Layout {
    /// For so many images, or none if they stay, and so many free parameters of each camera.
    pub(super) fn new(images: usize, free: impl Iterator<Item = usize> + Clone) -> Self {
        let poses = 6 * images;
        let mut held = vec![false; poses];
        let mut cameras = Vec::new();
        // The passes over points are compiled for these widths.
        let width = match free.clone().max().unwrap_or(0) {
            0 => 0,
            1..=4 => 4,
            5..=8 => 8,
            _ => MOST_PARAMS,
        };
        for free in free {
            cameras.push(held.len());
            held.extend((0..width).map(|place| place >= free));
        }
        Self { poses, cameras, width, size: held.len(), held }
    }
}

/// The system, its factor and its solution.
#[derive(Debug, Clone)]
pub(super) struct System {
    layout: Layout,
    /// The row of each unknown in the matrix.
    rows: Vec<usize>,
    pose_tiles: usize,
    matrix: Tiles,
    /// A right side, and then the solution, as the matrix has its rows.
    right: Vec<f64>,
    /// The scale of each of its rows; zero also for those that fill up tiles.
    row_scales: Vec<f64>,
    /// The gradient after points are eliminated.
    gradient: Vec<f64>,
    /// Of J^T J, before points are eliminated.
    diagonal: Vec<f64>,
    /// The gradient before points are eliminated.
    own_gradient: Vec<f64>,
    /// What each unknown is multiplied by for a diagonal of ones; zero for those that stay.
    scales: Vec<f64>,
    /// The step of each unknown.
    pub step: Vec<f64>,
    /// What `information` gives, after a solution without damping.
    pub left: Option<(Information, usize)>,
}

/// What is known of a step of poses and cameras.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solved {
    /// -gradient . step
    pub descent: f64,
    /// The step's square, weighed by the diagonal of J^T J.
    pub weighed_square: f64,
    /// The square of its length.
    pub square: f64,
    /// The largest component of the gradient.
    pub gradient: f64,
}

impl System {
    pub(super) fn new(layout: Layout, shape: &Shape) -> Self {
        let zeros = vec![0.0; layout.size];
        let matrix = Tiles::new(shape.pattern.clone());
        Self {
            rows: shape.rows.clone(),
            pose_tiles: shape.pose_tiles,
            right: vec![0.0; matrix.size()],
            row_scales: vec![0.0; matrix.size()],
            matrix,
            gradient: zeros.clone(),
            diagonal: zeros.clone(),
            own_gradient: zeros.clone(),
            scales: zeros.clone(),
            step: zeros,
            left: None,
            layout,
        }
    }

    pub(super) fn clear(&mut self) {
        self.matrix.clear();
        for vector in [&mut self.gradient, &mut self.diagonal, &mut self.own_gradient] {
            vector.fill(0.0);
        }
    }

    /// Adds the sums of a chunk: those of all chunks, in their order.
    pub(super) fn add(&mut self, chunk: &Chunk, sums: &Sums) {
        if self.layout.poses > 0 {
            self.add_poses(chunk, sums);
            self.add_borders(chunk, sums);
        }
        self.add_cameras(chunk, sums);
    }

    fn add_poses(&mut self, chunk: &Chunk, sums: &Sums) {
        for (second, &image) in chunk.images.iter().enumerate() {
            let start = 6 * image as usize;
            let later = self.rows[start];
            for (first, &earlier) in chunk.images[..=second].iter().enumerate() {
                let slot = chunk.pose_pose[pair(first, second)];
                if slot == NONE {
                    continue;
                }
                let block = sums.pose_blocks[slot as usize].iter().map(|values| &values[..6]);
                let earlier = self.rows[6 * earlier as usize];
                // The block's rows are those of the earlier image: columns of the matrix, if that is eliminated earlier too.
                if earlier <= later {
                    self.matrix.add_columns(later, earlier, block);
                } else {
                    self.matrix.add_rows(earlier, later, block);
                }
            }
            let own = &sums.pose_blocks[chunk.pose_pose[pair(second, second)] as usize];
            for (at, values) in own.iter().enumerate() {
                self.gradient[start + at] += values[6];
                self.own_gradient[start + at] += values[7];
                self.diagonal[start + at] += sums.pose_diagonals[second][at];
            }
        }
    }

    fn add_borders(&mut self, chunk: &Chunk, sums: &Sums) {
        for (index, &image) in chunk.images.iter().enumerate() {
            for (local, &camera) in chunk.cameras.iter().enumerate() {
                let slot = chunk.pose_camera[index * chunk.cameras.len() + local];
                if slot == NONE {
                    continue;
                }
                let (start, width) = (self.layout.cameras[camera as usize], self.layout.width);
                let block = sums.blocks[slot as usize..][..6 * width].chunks_exact(width);
                self.matrix.add_columns(self.rows[start], self.rows[6 * image as usize], block);
            }
        }
    }

    fn add_cameras(&mut self, chunk: &Chunk, sums: &Sums) {
        for (second, &camera) in chunk.cameras.iter().enumerate() {
            let (start, width) = (self.layout.cameras[camera as usize], self.layout.width);
            let vectors = [&mut self.gradient, &mut self.diagonal, &mut self.own_gradient];
            for (vector, values) in vectors.into_iter().zip(&sums.cameras[second]) {
                for (sum, value) in vector[start..start + width].iter_mut().zip(values) {
                    *sum += value;
                }
            }
            for (first, &earlier) in chunk.cameras[..=second].iter().enumerate() {
                let slot = chunk.camera_camera[pair(first, second)];
                if slot == NONE {
                    continue;
                }
                let column = self.rows[self.layout.cameras[earlier as usize]];
                let block = sums.blocks[slot as usize..][..width * width].chunks_exact(width);
                self.matrix.add_rows(self.rows[start], column, block);
            }
        }
    }

    /// Adds what is known of an unknown beforehand.
    pub(super) fn add_prior(&mut self, unknown: usize, weight: f64, gradient: f64) {
        let row = self.rows[unknown];
        self.matrix.add_rows(row, row, std::iter::once([weight].as_slice()));
        self.diagonal[unknown] += weight;
        self.gradient[unknown] += gradient;
        self.own_gradient[unknown] += gradient;
    }

    /// Which unknowns stay from now on.
    pub(super) fn hold(&mut self, held: &[bool], more: impl Iterator<Item = usize>) {
        self.layout.held.copy_from_slice(held);
        more.for_each(|unknown| self.layout.held[unknown] = true);
    }

    /// Scales the system to a diagonal of ones before points are eliminated, damps it, and takes out what stays.
    fn scale(&mut self, damping: f64) {
        for (at, scale) in self.scales.iter_mut().enumerate() {
            let moves = !self.layout.held[at] && self.diagonal[at] > 0.0;
            *scale = if moves { 1.0 / self.diagonal[at].sqrt() } else { 0.0 };
        }
        for (&row, &scale) in self.rows.iter().zip(&self.scales) {
            self.row_scales[row] = scale;
        }
        let scales = &self.row_scales;
        // What stays, or fills up a tile, is apart from all else.
        let diagonal = |row: usize, value| if scales[row] > 0.0 { value + damping } else { 1.0 };
        self.matrix.scale(scales, diagonal);
    }

    /// Solves with the factor of the scaled matrix.
    fn solve_for(&mut self, right: &mut [f64]) {
        self.right.fill(0.0);
        for (value, (&row, scale)) in right.iter().zip(self.rows.iter().zip(&self.scales)) {
            self.right[row] = value * scale;
        }
        self.matrix.solve(&mut self.right);
        for (value, &row) in right.iter_mut().zip(&self.rows) {
            *value = self.right[row];
        }
    }

    /// Solves the damped system; none when it is singular. Without damping, directions that are not determined stay.
    pub(super) fn solve(&mut self, damping: f64) -> Option<Solved> {
        self.scale(damping);
        self.left = None;
        let nullity = self.matrix.factor(0..self.pose_tiles, null(damping))?;
        if damping <= 0.0 {
            self.left = Some((self.schur_complement(), nullity));
        }
        self.matrix.factor(self.pose_tiles..self.matrix.tiles(), null(damping))?;
        let mut step = std::mem::take(&mut self.step);
        step.iter_mut().zip(&self.gradient).for_each(|(step, gradient)| *step = -gradient);
        self.solve_for(&mut step);
        self.step = step;
        let mut solved = Solved { descent: 0.0, weighed_square: 0.0, square: 0.0, gradient: 0.0 };
        for (at, step) in self.step.iter_mut().enumerate() {
            solved.weighed_square += if self.scales[at] > 0.0 { *step * *step } else { 0.0 };
            *step *= self.scales[at];
            solved.descent -= self.gradient[at] * *step;
            solved.square += *step * *step;
            if self.scales[at] > 0.0 {
                solved.gradient = solved.gradient.max(self.own_gradient[at].abs());
            }
        }
        (solved.descent.is_finite() && solved.square.is_finite()).then_some(solved)
    }

    /// Eliminates the poses of the undamped system: gives the information on the intrinsics, scaled, with the scales of its rows,
    /// and how many directions of the poses are not determined.
    pub(super) fn information(&mut self) -> (Information, usize) {
        self.scale(0.0);
        // With a bound on pivots nothing is singular.
        let nullity = self.matrix.factor(0..self.pose_tiles, null(0.0));
        (self.schur_complement(), nullity.unwrap_or(self.layout.poses))
    }

    /// What is left of the intrinsics' rows when poses are eliminated.
    fn schur_complement(&self) -> Information {
        let (poses, size) = (self.layout.poses, self.layout.size);
        let entry = |row: usize, column| self.matrix.entry(self.rows[row], self.rows[column]);
        let row = |row| (poses..=row).map(|column| entry(row, column)).collect();
        let rows = (poses..size).map(row).collect();
        Information { rows, scales: self.scales[poses..].to_vec() }
    }

    /// Solves the undamped system for each right side, which becomes the answer; gives the gradient. What is held, or not
    /// determined, stays zero.
    pub(super) fn answers(&mut self, rights: &mut [Vec<f64>]) -> Vec<f64> {
        self.scale(0.0);
        // With a bound on pivots nothing is singular.
        let _ = self.matrix.factor(0..self.matrix.tiles(), null(0.0));
        self.more_answers(rights);
        self.gradient.clone()
    }

    /// The same once more, with the factor that there is.
    pub(super) fn more_answers(&mut self, rights: &mut [Vec<f64>]) {
        for right in rights {
            self.solve_for(right);
            right.iter_mut().zip(&self.scales).for_each(|(value, scale)| *value *= scale);
        }
    }

    /// The step of one pose.
    pub(super) fn pose_step(&self, image: usize) -> Option<[f64; 6]> {
        self.step[..self.layout.poses].as_chunks::<6>().0.get(image).copied()
    }

    /// The step of one camera's free parameters.
    pub(super) fn camera_step(&self, camera: usize) -> Params {
        let (start, width) = (self.layout.cameras[camera], self.layout.width);
        let mut step = [0.0; MOST_PARAMS];
        step[..width].copy_from_slice(&self.step[start..start + width]);
        step
    }
}

/// The Schur complement of the intrinsics after points and poses, with columns scaled: its lower triangle, row by row.
#[derive(Debug, Clone)]
pub(super) struct Information {
    pub rows: Vec<Vec<f64>>,
    pub scales: Vec<f64>,
}

/// The pivot below which a direction is rounding alone; damped systems have none.
fn null(damping: f64) -> Option<f64> {
    /// Rounding of a system of a thousand unknowns stays below this share of its diagonal, a tenth of what covariances take for open.
    const NULL: f64 = 1e-11;
    (damping <= 0.0).then_some(NULL)
}
