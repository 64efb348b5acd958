//! The normal equations of some images, points eliminated: images leave and enter sight by sight.
//!
//! With V the sum of P^T P over the sights that a point has, P = d pixel / d point, one more tells g^T (1 + P V^-1 P^T)^-1 g, where
//! g is its row less what the others foretell of it, P V^-1 P_other^T times theirs: what a Kalman filter adds.

use std::collections::BTreeSet;

use multiversion::multiversion;
use nalgebra::DMatrix;

use super::Candidates;
use super::information::Information;
use crate::bundle::{Dense, Sensed, eliminator};

/// A pivot of a scaled pose below this is rounding: that direction is open.
const NULL: f64 = 1e-12;

/// The normal equations of the poses of some images, and of all free parameters.
#[derive(Debug, Clone)]
pub(super) struct System<'a> {
    candidates: &'a Candidates,
    /// The slot of each image: its pose begins at six times that.
    slots: Vec<Option<usize>>,
    /// The images by their slots.
    images: Vec<Option<usize>>,
    /// Where the parameters begin.
    poses: usize,
    dense: Dense,
    /// The diagonal before points are eliminated: the scale of rounding.
    diagonal: Vec<f64>,
}

/// Rows that have numbers in the columns of some poses and parameters alone.
#[derive(Debug, Clone)]
struct Told<const ROWS: usize> {
    /// With the first column of each pose; one that comes twice counts as the sum.
    poses: Vec<(usize, [[f64; 6]; ROWS])>,
    /// With the column of each parameter.
    params: Vec<(usize, [f64; ROWS])>,
}

impl<const ROWS: usize> Default for Told<ROWS> {
    fn default() -> Self {
        Self { poses: Vec::with_capacity(8), params: Vec::with_capacity(8) }
    }
}

impl Told<2> {
    /// Makes other rows of the two.
    fn map(&mut self, of: impl Fn([f64; 2]) -> [f64; 2]) {
        for (_, [across, down]) in &mut self.poses {
            for (a, d) in across.iter_mut().zip(down) {
                [*a, *d] = of([*a, *d]);
            }
        }
        self.params.iter_mut().for_each(|(_, rows)| *rows = of(*rows));
    }
}

impl<'a> System<'a> {
    pub(super) fn new(candidates: &'a Candidates, images: &[usize]) -> Self {
        Self::with_room(candidates, images, 0)
    }

    /// With so many slots to spare.
    pub(super) fn with_room(candidates: &'a Candidates, images: &[usize], spare: usize) -> Self {
        let mut system = Self::empty(candidates, images, spare);
        let seen: BTreeSet<usize> =
            images.iter().flat_map(|&image| candidates.points_of[image].iter().copied()).collect();
        seen.into_iter().for_each(|point| system.add(point));
        system
    }

    fn empty(candidates: &'a Candidates, images: &[usize], spare: usize) -> Self {
        let mut slots = vec![None; candidates.image_count()];
        images.iter().enumerate().for_each(|(slot, &image)| slots[image] = Some(slot));
        let poses = 6 * (images.len() + spare);
        let size = poses + candidates.params().len();
        let images = images.iter().map(|&image| Some(image)).chain((0..spare).map(|_| None));
        Self {
            candidates,
            slots,
            images: images.collect(),
            poses,
            dense: Dense::new(size),
            diagonal: vec![0.0; size],
        }
    }

    /// The same with some images left out and others in, for which there must be room.
    pub(super) fn exchanged(&self, out: &[usize], into: &[usize]) -> Self {
        let mut changed = self.clone();
        for &image in out {
            changed.change(image, -1.0);
            if let Some(slot) = changed.slots[image].take() {
                changed.images[slot] = None;
            }
        }
        for &image in into {
            if let Some(slot) = changed.images.iter().position(Option::is_none) {
                changed.clear(slot);
                (changed.images[slot], changed.slots[image]) = (Some(image), Some(slot));
                changed.change(image, 1.0);
            }
        }
        changed
    }

    /// Adds, times `sign`, what an image with a slot tells together with the others.
    fn change(&mut self, image: usize, sign: f64) {
        let Candidates { rows, points_of, .. } = self.candidates;
        for &point in &points_of[image] {
            let has_slot = |seen: &&Sensed| self.slots[seen.image].is_some();
            let (own, mut others): (Vec<&Sensed>, Vec<&Sensed>) =
                rows.track(point).iter().filter(has_slot).partition(|seen| seen.image == image);
            let is_lone = others.first().map(|it| it.image) == others.last().map(|it| it.image);
            if is_lone || eliminator(&others).nullity > 0 {
                let all: Vec<&Sensed> = others.iter().chain(&own).copied().collect();
                self.add_seen(point, &others, -sign);
                self.add_seen(point, &all, sign);
                continue;
            }
            for seen in own {
                self.add_sight(point, seen, &others, sign);
                others.push(seen);
            }
        }
    }

    /// What rounding left of an image that has gone.
    fn clear(&mut self, slot: usize) {
        let own = 6 * slot..6 * slot + 6;
        self.diagonal[own.clone()].fill(0.0);
        for row in 6 * slot..self.diagonal.len() {
            let filled = self.dense.row_mut(row);
            let end = own.end.min(filled.len());
            let from = if own.contains(&row) { 0 } else { own.start };
            filled[from..end].fill(0.0);
        }
    }

    /// Adds what the images tell by a point.
    fn add(&mut self, point: usize) {
        let track = self.candidates.rows.track(point).iter();
        let seen: Vec<&Sensed> = track.filter(|seen| self.slots[seen.image].is_some()).collect();
        self.add_seen(point, &seen, 1.0);
    }

    /// Adds, times `sign`, what some sights of a point tell; nothing if they are one image's.
    fn add_seen(&mut self, point: usize, seen: &[&Sensed], sign: f64) {
        if seen.iter().all(|it| it.image == seen[0].image) {
            return;
        }
        let inverse = eliminator(seen);
        let mut carried = Told::<3>::default();
        for seen in seen {
            let [across, down] = seen.wrt_point.map(|row| inverse.times(&row));
            let weights = std::array::from_fn(|axis| [across[axis], down[axis]]);
            self.tell(&mut carried, point, seen, weights);
            let own = self.own(point, seen, sign);
            add_square(&mut self.dense, &own, sign);
        }
        add_square(&mut self.dense, &carried, -sign);
    }

    /// Adds, times `sign`, what one more sight of a point tells when these others are there, two images' at least: of its pixel,
    /// what they do not foretell, by how little they do.
    fn add_sight(&mut self, point: usize, seen: &Sensed, others: &[&Sensed], sign: f64) {
        let inverse = eliminator(others);
        let own = seen.wrt_point.map(|row| inverse.times(&row));
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        // The factor of 1 + P V^-1 P^T: the covariance of the pixel less what is foretold of it.
        let first = (1.0 + dot(&own[0], &own[0])).sqrt();
        let lower = dot(&own[0], &own[1]) / first;
        let second = (1.0 + dot(&own[1], &own[1]) - lower * lower).sqrt();
        let whitened = |[across, down]: [f64; 2]| {
            let across = across / first;
            [across, (down - lower * across) / second]
        };
        let transposed = |[[a, b], [c, d]]: [[f64; 2]; 2]| [[a, c], [b, d]];
        let mut told = self.own(point, seen, sign);
        told.map(whitened);
        for other in others {
            let foretold = other.wrt_point.map(|row| {
                let row = inverse.times(&row);
                whitened([-dot(&own[0], &row), -dot(&own[1], &row)])
            });
            self.tell(&mut told, point, other, transposed(foretold));
        }
        add_square(&mut self.dense, &told, sign);
    }

    /// The rows of one sight by itself; they count on the diagonal, times `sign`.
    fn own(&mut self, point: usize, seen: &Sensed, sign: f64) -> Told<2> {
        let mut own = Told::default();
        self.tell(&mut own, point, seen, [[1.0, 0.0], [0.0, 1.0]]);
        for (start, rows) in &own.poses {
            let sums = &mut self.diagonal[*start..];
            for (sum, (across, down)) in sums.iter_mut().zip(rows[0].iter().zip(&rows[1])) {
                *sum += sign * (across.powi(2) + down.powi(2));
            }
        }
        for (at, [across, down]) in &own.params {
            self.diagonal[*at] += sign * (across.powi(2) + down.powi(2));
        }
        own
    }

    /// Adds the two rows of a sight, weighed, to others.
    fn tell<const ROWS: usize>(
        &self,
        told: &mut Told<ROWS>,
        point: usize,
        seen: &Sensed,
        weights: [[f64; 2]; ROWS],
    ) {
        let rows = &self.candidates.rows;
        let Some(slot) = self.slots[seen.image] else { return };
        let [across, down] = seen.wrt_pose(&rows.points[point]);
        let weighed = |[x, y]: [f64; 2]| std::array::from_fn(|at| x * across[at] + y * down[at]);
        told.poses.push((6 * slot, weights.map(weighed)));
        let [across, down] = rows.wrt_params(seen);
        let start = self.poses + rows.share(rows.camera_of[seen.image]).start;
        let place = told.params.iter().position(|(at, _)| *at == start).unwrap_or_else(|| {
            let count = told.params.len();
            told.params.extend((start..start + across.len()).map(|at| (at, [0.0; ROWS])));
            count
        });
        for ((_, sums), (a, d)) in told.params[place..].iter_mut().zip(across.iter().zip(down)) {
            for (sum, [x, y]) in sums.iter_mut().zip(&weights) {
                *sum += x * a + y * d;
            }
        }
    }

    /// What they tell of the parameters.
    pub(super) fn information(mut self) -> Information {
        let is_held = self.held();
        let size = self.diagonal.len();
        let scale = |at: usize| match self.diagonal[at] {
            _ if at >= self.poses => 1.0,
            own if own > 0.0 && !is_held[at] => 1.0 / own.sqrt(),
            _ => 0.0,
        };
        let scales: Vec<f64> = (0..size).map(scale).collect();
        for row in 0..size {
            let filled = self.dense.row_mut(row).iter_mut().zip(&scales);
            filled.for_each(|(value, scale)| *value *= scales[row] * scale);
        }
        // A pivot that is null is left out: there always is a factor.
        let _ = self.dense.factor(0..self.poses, Some(NULL));
        let variance = self.candidates.sigma_px.powi(2);
        let matrix = DMatrix::from_fn(size - self.poses, size - self.poses, |row, column| {
            let (row, column) = (self.poses + row.max(column), self.poses + row.min(column));
            self.dense.row(row)[column] / variance
        });
        Information { matrix }
    }

    /// The unknowns that stay, as no observation depends on where a part of the scene is, nor how large: the pose of one image
    /// of each part, and one coordinate of another far away. Also those of slots that no image has.
    fn held(&self) -> Vec<bool> {
        let mut is_held = vec![false; self.diagonal.len()];
        for (slot, image) in self.images.iter().enumerate() {
            is_held[6 * slot..6 * slot + 6].fill(image.is_none());
        }
        for part in self.parts() {
            let Some((&first, others)) = part.split_first() else { continue };
            is_held[6 * first..6 * first + 6].fill(true);
            let centre = |slot: usize| self.images[slot].map(|image| self.candidates.centre(image));
            let Some(origin) = centre(first) else { continue };
            let mut farthest = (0.0, first, 0);
            for &slot in others {
                let Some(centre) = centre(slot) else { continue };
                for (axis, along) in (centre - origin).iter().enumerate() {
                    if along.abs() > farthest.0 {
                        farthest = (along.abs(), slot, axis);
                    }
                }
            }
            is_held[6 * farthest.1 + 3 + farthest.2] = true;
        }
        is_held
    }

    /// The slots of the images that shared points connect, part by part.
    fn parts(&self) -> Vec<Vec<usize>> {
        let mut is_done = vec![false; self.images.len()];
        let mut parts = Vec::new();
        for first in 0..self.images.len() {
            if self.images[first].is_none() || std::mem::replace(&mut is_done[first], true) {
                continue;
            }
            let mut part = vec![first];
            let mut next = 0;
            while let Some(image) = part.get(next).and_then(|&slot| self.images[slot]) {
                let partners = self.candidates.partners_of(image).iter();
                for slot in partners.filter_map(|&partner| self.slots[partner]) {
                    if !std::mem::replace(&mut is_done[slot], true) {
                        part.push(slot);
                    }
                }
                next += 1;
            }
            parts.push(part);
        }
        parts
    }
}

/// Adds, times `sign`, the products of rows with themselves.
#[multiversion(targets("x86_64+avx2+fma"))]
fn add_square<const ROWS: usize>(dense: &mut Dense, told: &Told<ROWS>, sign: f64) {
    for (start, later) in &told.poses {
        for at in 0..6 {
            let row = dense.whole_row_mut(start + at);
            let factors = later.map(|values| sign * values[at]);
            for (column, earlier) in told.poses.iter().filter(|(column, _)| column <= start) {
                add_to_six(&mut row[*column..], &factors, earlier);
            }
        }
    }
    for (at, later) in &told.params {
        let row = dense.whole_row_mut(*at);
        let factors = later.map(|value| sign * value);
        for (column, earlier) in &told.poses {
            add_to_six(&mut row[*column..], &factors, earlier);
        }
        for (column, earlier) in told.params.iter().filter(|(column, _)| column <= at) {
            for (factor, value) in factors.iter().zip(earlier) {
                row[*column] += factor * value;
            }
        }
    }
}

#[inline(always)]
fn add_to_six<const ROWS: usize>(
    row: &mut [f64],
    factors: &[f64; ROWS],
    values: &[[f64; 6]; ROWS],
) {
    let Some(sums) = row.first_chunk_mut::<6>() else { return };
    for (factor, values) in factors.iter().zip(values) {
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += factor * value;
        }
    }
}
