//! What keypoints and tracks say of each other, which must be the same.
//!
//! Each track claims the keypoints that it names. A keypoint of another point is refused at once; one that names a
//! point and stays unclaimed names a point that does not exist, or one whose track does not know of it.

use std::collections::{BTreeMap, HashMap};

use super::Why;
use crate::scene::{Image, ImageId, Keypoints, Point3DId, Points3D, TrackElement};

/// The keypoints of all images, and which of them a track has claimed.
pub struct Sightings<'a> {
    images: HashMap<ImageId, Seen<'a>>,
    claim_count: usize,
}

struct Seen<'a> {
    keypoints: &'a Keypoints,
    claimed: Vec<bool>,
}

impl<'a> Sightings<'a> {
    /// No keypoint claimed yet.
    pub fn of(images: &'a BTreeMap<ImageId, Image>) -> Self {
        let seen = |image: &'a Image| Seen {
            keypoints: &image.keypoints,
            claimed: vec![false; image.keypoints.len()],
        };
        Self {
            images: images.iter().map(|(&id, image)| (id, seen(image))).collect(),
            claim_count: 0,
        }
    }

    /// Notes that the track of `point` names this keypoint.
    pub fn claim(&mut self, element: TrackElement, point: Point3DId) -> Result<(), Why> {
        let TrackElement { image, keypoint } = element;
        let seen = self.images.get_mut(&image).ok_or(Why::UnknownImage(image.0.into()))?;
        let count = seen.keypoints.len();
        let index = usize::try_from(keypoint).unwrap_or(usize::MAX);
        let Some((found, claimed)) = seen.keypoints.get(index).zip(seen.claimed.get_mut(index))
        else {
            return Err(Why::UnknownKeypoint { image, keypoint, count });
        };
        if found.point != Some(point) {
            return Err(Why::NotItsKeypoint { image, keypoint, owner: found.point });
        }
        if *claimed {
            return Err(Why::SeenTwice { image, keypoint });
        }
        *claimed = true;
        self.claim_count += 1;
        Ok(())
    }

    /// Whether every keypoint that names a point has been claimed by it.
    pub fn are_all_claimed(&self) -> bool {
        let named = |seen: &Seen| seen.keypoints.iter().filter(|at| at.point.is_some()).count();
        self.claim_count == self.images.values().map(named).sum::<usize>()
    }

    /// What is wrong with a keypoint that names this point, once all tracks have been read.
    pub fn check(
        &self,
        image: ImageId,
        index: usize,
        point: Point3DId,
        points: &Points3D,
    ) -> Result<(), Why> {
        let seen = self.images.get(&image).ok_or(Why::UnknownImage(image.0.into()))?;
        match seen.claimed.get(index) {
            Some(true) => Ok(()),
            _ if points.iter().any(|known| known.id == point) => Err(Why::NotInTrack(point)),
            _ => Err(Why::UnknownPoint(point)),
        }
    }
}
