//! What points carry between the poses of two images: most of the work where a point is seen by many.
//!
//! Points are gathered first, then gone through image by image: the sums of one image with all others stay near the
//! processor, where the pairs of one point after the other would each fetch a sum from afar.

use super::chunk::{Chunk, pair};
use super::products::{Wide, take_outers};

/// Sightings to gather at most: what is kept of them fits into a core's own cache, or nearly. Tests are to see many gatherings.
const MOST: usize = if cfg!(test) { 16 } else { 8192 };

/// What is kept of points until their pairs of images are summed.
#[derive(Debug, Clone, Default)]
pub(super) struct Gathered {
    /// For each sighting the columns of Z = J_pose^T J_point L^-T.
    factors: Vec<[Wide; 3]>,
    /// The image of each sighting, and the place here of its point's first.
    seen: Vec<(u32, usize)>,
    /// The sightings' places, image by image.
    by_image: Vec<u32>,
    /// Where those of each image end.
    ends: Vec<u32>,
}

impl Gathered {
    /// Whether no such track fits in any more. What is kept is no larger than the sums, which might be near as they are.
    pub(super) fn is_full_for(&self, track: usize, chunk: &Chunk) -> bool {
        let most = MOST.min(chunk.pose_pose_count);
        !self.seen.is_empty() && self.seen.len() + track > most
    }

    /// Keeps a sighting's factor; `at` is its place among its point's.
    #[inline(always)]
    pub(super) fn push(&mut self, image: u32, at: usize, factor: &[Wide; 3]) {
        self.seen.push((image, self.seen.len() - at));
        self.factors.push(*factor);
    }

    /// Takes what the points carry from the sums of their pairs of images, and forgets them.
    #[inline(always)]
    pub(super) fn take_from<const FUSED: bool>(&mut self, blocks: &mut [[Wide; 6]], chunk: &Chunk) {
        self.sort(chunk.images.len());
        let mut start = 0;
        for (image, &end) in self.ends.iter().enumerate() {
            let slots = &chunk.pose_pose[pair(0, image)..pair(0, image + 1)];
            for &place in &self.by_image[start..end as usize] {
                let place = place as usize;
                let last = self.factors[place];
                let earlier = self.seen[place].1..place;
                for (&(first, _), other) in
                    self.seen[earlier.clone()].iter().zip(&self.factors[earlier])
                {
                    let block = &mut blocks[slots[first as usize] as usize];
                    take_outers::<8, 8, FUSED>(block, other, &last);
                    if first as usize == image {
                        // Both halves of a symmetric block: the image has two keypoints of this point.
                        take_outers::<8, 8, FUSED>(block, &last, other);
                    }
                }
            }
            start = end as usize;
        }
        self.factors.clear();
        self.seen.clear();
    }

    /// Counts the sightings of each image, and puts their places in order.
    fn sort(&mut self, images: usize) {
        let Self { seen, by_image, ends, .. } = self;
        ends.clear();
        ends.resize(images, 0);
        seen.iter().for_each(|&(image, _)| ends[image as usize] += 1);
        let mut start = 0;
        for end in &mut *ends {
            start += std::mem::replace(end, start);
        }
        by_image.clear();
        by_image.resize(seen.len(), 0);
        for (&(image, _), place) in seen.iter().zip(0..) {
            let next = &mut ends[image as usize];
            by_image[*next as usize] = place;
            *next += 1;
        }
    }
}
