//! A fixed share of the points, with the sightings of them: what one thread works on at a time.
//!
//! Points are sorted so that those of a chunk are seen by few images; a chunk numbers its images and cameras itself, and has a
//! sum for each pair of them that share a point. How points are cut into chunks depends on the scene alone.

use std::ops::Range;

use super::BundleError;
use super::linearize::Sighting;

/// No sum.
pub(super) const NONE: u32 = u32::MAX;

/// Some points and their sightings.
#[derive(Debug, Clone)]
pub(super) struct Chunk {
    /// Of the sorted points.
    pub points: Range<usize>,
    /// Where each point's sightings end.
    pub ends: Vec<u32>,
    /// Sorted by image within a point.
    pub sightings: Vec<Sighting>,
    /// The images, ascending, as numbered in the problem.
    pub images: Vec<u32>,
    /// The camera of each image, as numbered here.
    pub camera_of: Vec<u32>,
    /// The cameras, ascending, as numbered in the problem.
    pub cameras: Vec<u32>,
    /// Which sum is that of each two images; the pairs (0, 0), (0, 1), (1, 1), (0, 2), ...
    pub pose_pose: Vec<u32>,
    /// Where the sum of each image and camera begins, images first.
    pub pose_camera: Vec<u32>,
    /// Where the sum of each two cameras begins, as for images.
    pub camera_camera: Vec<u32>,
    /// How many sums there are of two images.
    pub pose_pose_count: usize,
    /// How many numbers the sums with cameras are.
    pub border_length: usize,
    /// The longest track.
    pub longest: usize,
}

/// The place of a pair, first <= second, in a table of pairs.
#[inline(always)]
pub(super) fn pair(first: usize, second: usize) -> usize {
    second * (second + 1) / 2 + first
}

/// A point as it is cut into chunks: its sightings, by the problem's number of the image.
pub(super) type Sighted = Vec<Sighting>;

/// What the chunk builder knows of images and cameras.
pub(super) struct Numbering<'a> {
    /// The camera of each image.
    pub camera_of: &'a [u32],
    /// The width of a camera's share of the border.
    pub width: usize,
    /// Whether sums between images are needed.
    pub poses: bool,
    /// Whether sums between different images are needed: only moving points make them.
    pub pairs: bool,
}

/// Cuts sorted points into chunks of about equal work.
pub(super) fn cut(
    points: &[Sighted],
    numbering: &Numbering<'_>,
) -> Result<Vec<Chunk>, BundleError> {
    /// A chunk is worth a thread's while, and its sums are no more than what a core keeps near it.
    const WORK: usize = 100_000;
    /// Fewer chunks than this keep few threads busy; with many more it takes longer to add their sums than to make them.
    const MOST_CHUNKS: usize = 64;
    let work = |track: &Sighted| track.len() * (10 + track.len() / 2);
    let total: usize = points.iter().map(work).sum();
    let mut share = (total / MOST_CHUNKS).max(WORK);
    loop {
        let mut chunks = Vec::new();
        let (mut start, mut done) = (0, 0);
        for (index, track) in points.iter().enumerate() {
            done += work(track);
            if done >= share || index + 1 == points.len() {
                chunks.push(Chunk::new(points, start..index + 1, numbering)?);
                (start, done) = (index + 1, 0);
            }
        }
        // Sums of many chunks that all see all images would be many times the system that they make.
        let sums: usize = chunks.iter().map(Chunk::sum_length).sum();
        let unknowns = 6 * numbering.camera_of.len()
            + numbering.width * chunks.first().map_or(0, |c| c.cameras.len());
        if chunks.len() <= 4 || sums <= 4 * unknowns * unknowns {
            return Ok(chunks);
        }
        share *= 2;
    }
}

impl Chunk {
    fn new(
        points: &[Sighted],
        range: Range<usize>,
        numbering: &Numbering<'_>,
    ) -> Result<Self, BundleError> {
        let tracks = &points[range.clone()];
        let images = distinct(tracks.iter().flatten().map(|sighting| sighting.image));
        let cameras = distinct(images.iter().map(|&image| numbering.camera_of[image as usize]));
        let camera_of: Vec<u32> = images
            .iter()
            .map(|&image| place(&cameras, numbering.camera_of[image as usize]))
            .collect::<Result<_, _>>()?;
        let mut chunk = Self {
            points: range,
            ends: Vec::with_capacity(tracks.len()),
            sightings: Vec::new(),
            pose_pose: vec![NONE; pair(0, images.len())],
            pose_camera: vec![NONE; images.len() * cameras.len()],
            camera_camera: vec![NONE; pair(0, cameras.len())],
            images,
            camera_of,
            cameras,
            pose_pose_count: 0,
            border_length: 0,
            longest: tracks.iter().map(Vec::len).max().unwrap_or(0),
        };
        for track in tracks {
            for sighting in track {
                let image = place(&chunk.images, sighting.image)?;
                chunk.sightings.push(Sighting { image, ..*sighting });
            }
            let end = chunk.sightings.len().try_into().map_err(|_| BundleError::TooLarge)?;
            chunk.ends.push(end);
        }
        chunk.lay_out(numbering)?;
        Ok(chunk)
    }

    /// Gives a sum to each pair that shares a point.
    fn lay_out(&mut self, numbering: &Numbering<'_>) -> Result<(), BundleError> {
        let width = numbering.width;
        let mut cameras = Vec::new();
        let give = |slot: &mut u32, size: usize, length: &mut usize| -> Result<(), BundleError> {
            if *slot == NONE && size > 0 {
                *slot = u32::try_from(*length).map_err(|_| BundleError::TooLarge)?;
                *length += size;
            }
            Ok(())
        };
        let mut start = 0;
        for &end in &self.ends {
            let track = &self.sightings[start..end as usize];
            start = end as usize;
            cameras.clear();
            cameras.extend(track.iter().map(|seen| self.camera_of[seen.image as usize]));
            cameras.sort_unstable();
            cameras.dedup();
            for (at, seen) in track.iter().enumerate() {
                let image = seen.image as usize;
                let own = self.camera_of[image];
                let firsts = if numbering.pairs { &track[..=at] } else { &track[at..=at] };
                for first in firsts.iter().filter(|_| numbering.poses) {
                    self.pose_pose[pair(first.image as usize, image)] = 0;
                }
                for &camera in &cameras {
                    if numbering.poses && (numbering.pairs || camera == own) {
                        let slot = image * self.cameras.len() + camera as usize;
                        give(&mut self.pose_camera[slot], 6 * width, &mut self.border_length)?;
                    }
                }
            }
            for (at, &second) in cameras.iter().enumerate() {
                let firsts = if numbering.pairs { &cameras[..=at] } else { &cameras[at..=at] };
                for &first in firsts {
                    let (first, second) = (first as usize, second as usize);
                    let slot = &mut self.camera_camera[pair(first, second)];
                    give(slot, width * width, &mut self.border_length)?;
                }
            }
        }
        // Those of one image with all others in a row: they are summed image by image.
        for slot in self.pose_pose.iter_mut().filter(|slot| **slot != NONE) {
            *slot = u32::try_from(self.pose_pose_count).map_err(|_| BundleError::TooLarge)?;
            self.pose_pose_count += 1;
        }
        Ok(())
    }

    /// How many numbers all sums are.
    pub(super) fn sum_length(&self) -> usize {
        48 * self.pose_pose_count + self.border_length
    }
}

fn distinct(numbers: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut sorted: Vec<u32> = numbers.collect();
    sorted.sort_unstable();
    sorted.dedup();
    sorted
}

fn place(sorted: &[u32], number: u32) -> Result<u32, BundleError> {
    let at = sorted.binary_search(&number).map_err(|_| BundleError::TooLarge)?;
    at.try_into().map_err(|_| BundleError::TooLarge)
}
