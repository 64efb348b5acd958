//! The normal equations of some images, points eliminated: images leave and enter by taking out and re-adding their points.

use std::collections::BTreeSet;

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

/// What a point, or an image's sight of it, adds to the rows of some unknowns.
struct Carried {
    /// The first of the unknowns.
    start: usize,
    /// L^-1 J_point^T J, a row for each unknown.
    rows: Vec<[f64; 3]>,
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
        seen.into_iter().for_each(|point| system.add(point, 1.0));
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
        let of = |image: &usize| self.candidates.points_of[*image].iter().copied();
        let touched: BTreeSet<usize> = out.iter().chain(into).flat_map(of).collect();
        let mut changed = self.clone();
        touched.iter().for_each(|&point| changed.add(point, -1.0));
        for &image in out {
            if let Some(slot) = changed.slots[image].take() {
                changed.images[slot] = None;
            }
        }
        for &image in into {
            if let Some(slot) = changed.images.iter().position(Option::is_none) {
                changed.clear(slot);
                (changed.images[slot], changed.slots[image]) = (Some(image), Some(slot));
            }
        }
        touched.iter().for_each(|&point| changed.add(point, 1.0));
        changed
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

    /// Adds, times `sign`, what the images tell by a point; nothing if fewer than two see it.
    fn add(&mut self, point: usize, sign: f64) {
        let rows = &self.candidates.rows;
        let track: Vec<&Sensed> =
            rows.track(point).iter().filter(|seen| self.slots[seen.image].is_some()).collect();
        if track.first().map(|it| it.image) == track.last().map(|it| it.image) {
            return;
        }
        let inverse = eliminator(&track);
        let mut carried: Vec<Carried> = Vec::with_capacity(2 * track.len());
        for seen in track {
            let Some(slot) = self.slots[seen.image] else { continue };
            let pose = seen.wrt_pose(&rows.points[point]);
            let params = rows.wrt_params(seen);
            let share = self.poses + rows.share(rows.camera_of[seen.image]).start;
            self.add_products(6 * slot, &[&pose[0], &pose[1]], sign);
            self.add_products(share, &params, sign);
            self.add_border(share, &params, 6 * slot, &pose, sign);
            for (start, own) in [(6 * slot, [&pose[0][..], &pose[1][..]]), (share, params)] {
                let at = carried.iter().position(|it| it.start == start).unwrap_or_else(|| {
                    carried.push(Carried { start, rows: vec![[0.0; 3]; own[0].len()] });
                    carried.len() - 1
                });
                for (index, sum) in carried[at].rows.iter_mut().enumerate() {
                    let [across, down] = seen.wrt_point;
                    for (sum, (x, y)) in sum.iter_mut().zip(across.iter().zip(down)) {
                        *sum += own[0][index] * x + own[1][index] * y;
                    }
                }
            }
        }
        for row in carried.iter_mut().flat_map(|it| &mut it.rows) {
            *row = inverse.times(row);
        }
        self.take_carried(&carried, sign);
    }

    /// J^T J of one block.
    fn add_products(&mut self, start: usize, own: &[&[f64]; 2], sign: f64) {
        for row in 0..own[0].len() {
            let filled = &mut self.dense.row_mut(start + row)[start..];
            for (column, sum) in filled.iter_mut().enumerate() {
                *sum += sign * (own[0][row] * own[0][column] + own[1][row] * own[1][column]);
            }
            self.diagonal[start + row] += sign * (own[0][row].powi(2) + own[1][row].powi(2));
        }
    }

    /// J^T J of parameters and a pose.
    fn add_border(
        &mut self,
        start: usize,
        params: &[&[f64]; 2],
        pose_start: usize,
        pose: &[[f64; 6]; 2],
        sign: f64,
    ) {
        for (row, (x, y)) in params[0].iter().zip(params[1]).enumerate() {
            let filled = &mut self.dense.row_mut(start + row)[pose_start..pose_start + 6];
            for (column, sum) in filled.iter_mut().enumerate() {
                *sum += sign * (x * pose[0][column] + y * pose[1][column]);
            }
        }
    }

    fn take_carried(&mut self, carried: &[Carried], sign: f64) {
        for later in carried {
            for earlier in carried.iter().filter(|earlier| earlier.start <= later.start) {
                for (row, [x, y, z]) in later.rows.iter().enumerate() {
                    let filled = &mut self.dense.row_mut(later.start + row)[earlier.start..];
                    for (sum, [a, b, c]) in filled.iter_mut().zip(&earlier.rows) {
                        *sum -= sign * (x * a + y * b + z * c);
                    }
                }
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
        let rows = &self.candidates.rows;
        let mut is_done = vec![false; self.images.len()];
        let mut is_passed = vec![false; rows.points.len()];
        let mut parts = Vec::new();
        for first in 0..self.images.len() {
            if self.images[first].is_none() || std::mem::replace(&mut is_done[first], true) {
                continue;
            }
            let mut part = vec![first];
            let mut next = 0;
            while let Some(image) = part.get(next).and_then(|&slot| self.images[slot]) {
                for &point in &self.candidates.points_of[image] {
                    if std::mem::replace(&mut is_passed[point], true) {
                        continue;
                    }
                    for slot in rows.track(point).iter().filter_map(|seen| self.slots[seen.image]) {
                        if !std::mem::replace(&mut is_done[slot], true) {
                            part.push(slot);
                        }
                    }
                }
                next += 1;
            }
            parts.push(part);
        }
        parts
    }
}
