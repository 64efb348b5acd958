//! What a heuristic chooses from: the images or frames of the largest part of the pool that shared points hold together.

use std::collections::BTreeMap;

use super::{Candidates, Request, SelectionError, Unit};
use crate::scene::CameraId;

/// So many shared points hold two images together; with fewer, chance matches would do.
pub(super) const LEAST_SHARED: usize = 6;

/// An image, or the images of a frame.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// Their places in `Candidates`, ascending.
    pub images: Vec<usize>,
    /// The points that they see, ascending.
    pub points: Vec<usize>,
    /// The wanted cameras that took them, by their places in `Field::wanted`.
    pub cameras: Vec<usize>,
}

/// What a heuristic chooses from, and how much.
#[derive(Debug)]
pub(super) struct Field<'a> {
    pub candidates: &'a Candidates,
    /// By their first images.
    pub groups: Vec<Group>,
    /// The cameras whose intrinsics are wanted, ascending.
    pub wanted: Vec<CameraId>,
    pub size: usize,
    pub seed: u64,
    /// The groups that see each point.
    seen_by: Vec<Vec<usize>>,
    /// The groups that share points enough with each to hold together with it by themselves.
    partners: Vec<Vec<usize>>,
}

impl<'a> Field<'a> {
    pub(super) fn new(
        candidates: &'a Candidates,
        request: &Request<'_>,
    ) -> Result<Self, SelectionError> {
        let Request { pool, size, seed, unit, camera } = *request;
        if size < 2 {
            return Err(SelectionError::TooFew);
        }
        let mut wanted: Vec<CameraId> = match camera {
            Some(camera) => vec![camera],
            None => pool.iter().map(|&image| candidates.camera(image)).collect(),
        };
        wanted.sort_unstable();
        wanted.dedup();
        let groups = groups(candidates, pool, unit, &wanted);
        if let (true, Some(camera)) = (groups.is_empty(), camera) {
            return Err(SelectionError::NoCamera(camera));
        }
        let all = groups.len();
        let (seen_by, partners) = (Vec::new(), Vec::new());
        let mut field = Self { candidates, seen_by, partners, groups, wanted, size, seed };
        field.index();
        let kept = field.largest_part();
        if size > kept.len() {
            return Err(SelectionError::TooMany { size, pool: all, connected: kept.len() });
        }
        if kept.len() < all {
            let mut is_kept = vec![false; all];
            kept.into_iter().for_each(|group| is_kept[group] = true);
            let mut kept = is_kept.into_iter();
            field.groups.retain(|_| kept.next() == Some(true));
            field.index();
        }
        field.check_cameras()?;
        Ok(field)
    }

    fn index(&mut self) {
        self.seen_by = vec![Vec::new(); self.candidates.rows.points.len()];
        for (group, Group { points, .. }) in self.groups.iter().enumerate() {
            points.iter().for_each(|&point| self.seen_by[point].push(group));
        }
        let partners = |group: usize| {
            let shared = self.shared_with(group).into_iter().enumerate();
            shared.filter(|(_, shared)| *shared >= LEAST_SHARED).map(|(other, _)| other).collect()
        };
        self.partners = (0..self.groups.len()).map(partners).collect();
    }

    /// Whether some groups hang together by pairs of them; then also each with all the others.
    pub(super) fn hangs_by_pairs(&self, groups: &[usize]) -> bool {
        let mut is_left = vec![false; self.groups.len()];
        groups.iter().for_each(|&group| is_left[group] = true);
        let mut reached: Vec<usize> = groups.first().copied().into_iter().collect();
        reached.iter().for_each(|&group| is_left[group] = false);
        let mut next = 0;
        while let Some(&group) = reached.get(next) {
            for &partner in &self.partners[group] {
                if std::mem::replace(&mut is_left[partner], false) {
                    reached.push(partner);
                }
            }
            next += 1;
        }
        reached.len() == groups.len()
    }

    /// The groups that see a point.
    pub(super) fn seen_by(&self, point: usize) -> &[usize] {
        &self.seen_by[point]
    }

    /// How many points each group shares with this one.
    pub(super) fn shared_with(&self, group: usize) -> Vec<usize> {
        let mut shared = vec![0; self.groups.len()];
        for &point in &self.groups[group].points {
            self.seen_by[point].iter().for_each(|&other| shared[other] += 1);
        }
        shared
    }

    /// The groups of the largest part, the earliest of those as large; ascending.
    fn largest_part(&self) -> Vec<usize> {
        let mut is_reached = vec![false; self.groups.len()];
        let mut largest = Vec::new();
        for first in 0..self.groups.len() {
            if std::mem::replace(&mut is_reached[first], true) {
                continue;
            }
            let mut part = vec![first];
            let mut next = 0;
            while next < part.len() {
                for &other in &self.partners[part[next]] {
                    if !std::mem::replace(&mut is_reached[other], true) {
                        part.push(other);
                    }
                }
                next += 1;
            }
            if part.len() > largest.len() {
                largest = part;
            }
        }
        largest.sort_unstable();
        largest
    }

    fn check_cameras(&self) -> Result<(), SelectionError> {
        let shows = |at: usize| self.groups.iter().any(|group| group.cameras.contains(&at));
        if let Some(at) = (0..self.wanted.len()).find(|&at| !shows(at)) {
            return Err(SelectionError::Unreached(self.wanted[at]));
        }
        let most = self.groups.iter().map(|group| group.cameras.len()).max().unwrap_or(0);
        let cameras = self.wanted.len();
        if most * self.size < cameras {
            return Err(SelectionError::TooManyCameras { size: self.size, cameras });
        }
        Ok(())
    }

    /// The images of some groups, ascending.
    pub(super) fn images_of(&self, groups: &[usize]) -> Vec<usize> {
        let mut images: Vec<usize> =
            groups.iter().flat_map(|&group| self.groups[group].images.iter().copied()).collect();
        images.sort_unstable();
        images
    }

    /// The images of a group that wanted cameras took.
    pub(super) fn wanted_images(&self, group: usize) -> impl Iterator<Item = usize> {
        let images = self.groups[group].images.iter().copied();
        images.filter(|&image| self.wanted.contains(&self.candidates.camera(image)))
    }

    /// The groups in the order of the sequence.
    pub(super) fn sequence(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.groups.len()).collect();
        order.sort_by_key(|&group| {
            self.groups[group].images.iter().map(|&image| self.candidates.rank(image)).min()
        });
        order
    }
}

fn groups(candidates: &Candidates, pool: &[usize], unit: Unit, wanted: &[CameraId]) -> Vec<Group> {
    let mut by_key: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &image in pool {
        let key = match unit {
            Unit::Image => image,
            Unit::Frame => candidates.frame(image),
        };
        by_key.entry(key).or_default().push(image);
    }
    let group = |images: Vec<usize>| {
        let sorted = |mut list: Vec<usize>| {
            list.sort_unstable();
            list.dedup();
            list
        };
        let points = images.iter().flat_map(|&image| candidates.points_of[image].iter().copied());
        let cameras =
            images.iter().filter_map(|&at| wanted.binary_search(&candidates.camera(at)).ok());
        Group {
            points: sorted(points.collect()),
            cameras: sorted(cameras.collect()),
            images: sorted(images),
        }
    };
    let mut groups: Vec<Group> = by_key.into_values().map(group).collect();
    groups.retain(|group| !group.cameras.is_empty());
    groups.sort_by_key(|group| group.images[0]);
    groups
}
