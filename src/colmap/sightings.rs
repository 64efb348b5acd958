//! What keypoints and tracks say of each other, which must be the same.
//!
//! `Seen` tells quickly whether all is well. When it is not, `Claims` finds the first place: each track claims the keypoints
//! that it names; a keypoint of another point is refused at once; one that names a point and stays unclaimed names a point
//! that does not exist, or one whose track does not know of it.

use std::collections::{BTreeMap, HashSet};

use super::Why;
use super::images::TakeImages;
use super::points::{ReadPoint, TakePoints};
use crate::scene::{Image, ImageId, Keypoints, Point3DId, Points3D, TrackElement};

/// The keypoints of all images.
pub struct Seen<'a> {
    /// Ascending.
    ids: Vec<ImageId>,
    /// The keypoints of each of these images.
    keypoints: Vec<&'a Keypoints>,
    /// From an image's id to its index; empty when the ids are so far apart that it would be mostly holes.
    indices: Vec<Option<u32>>,
}

/// How many times as many entries as images the table of indices may have: 4 times 8 bytes, where an image in a file takes 73.
const MOST_HOLES: usize = 4;

impl<'a> Seen<'a> {
    /// Nothing is copied.
    pub fn of(images: &'a BTreeMap<ImageId, Image>) -> Self {
        let ids: Vec<ImageId> = images.keys().copied().collect();
        let room = ids.last().map_or(0, |last| last.0 as usize + 1);
        let mut indices = Vec::new();
        if room <= MOST_HOLES * ids.len() {
            indices.resize(room, None);
            for (id, index) in ids.iter().zip(0..) {
                indices[id.0 as usize] = Some(index);
            }
        }
        Self { ids, keypoints: images.values().map(|image| &image.keypoints).collect(), indices }
    }

    /// The image's index.
    #[inline]
    fn index(&self, id: ImageId) -> Option<usize> {
        if self.indices.is_empty() {
            return self.ids.binary_search(&id).ok();
        }
        self.indices.get(id.0 as usize).copied().flatten().map(|index| index as usize)
    }

    /// Whether all keypoints that the track names are the point's, and none is named twice.
    ///
    /// When that holds for all points, no two have one id, and the tracks together are as long as there are keypoints that
    /// name a point, then tracks and keypoints say the same.
    #[inline]
    pub fn agrees(&self, point: &ReadPoint) -> bool {
        let is_its = |element: &TrackElement| {
            let keypoints = self.index(element.image).map(|index| self.keypoints[index]);
            keypoints.and_then(|seen| seen.point(element.keypoint as usize)) == Some(point.id)
        };
        point.track.iter().all(is_its) && !has_twins(point.track)
    }

    /// How many keypoints name a point.
    pub fn observation_count(&self) -> usize {
        self.keypoints.iter().map(|keypoints| keypoints.observation_count()).sum()
    }
}

/// Up to this length all pairs are compared sooner than a copy is sorted.
const SHORT_TRACK: usize = 32;

fn has_twins(track: &[TrackElement]) -> bool {
    if track.len() <= SHORT_TRACK {
        return track.iter().enumerate().any(|(index, one)| track[..index].contains(one));
    }
    let mut sorted: Vec<(ImageId, u32)> =
        track.iter().map(|one| (one.image, one.keypoint)).collect();
    sorted.sort_unstable();
    sorted.windows(2).any(|pair| pair[0] == pair[1])
}

/// Which keypoints tracks have claimed so far, and the points whose tracks they are.
pub struct Claims<'a> {
    seen: Seen<'a>,
    claimed: Vec<Vec<bool>>,
    ids: HashSet<Point3DId>,
    points: Points3D,
}

impl<'a> Claims<'a> {
    /// No keypoint claimed yet.
    pub fn on(seen: Seen<'a>) -> Self {
        let claimed = seen.keypoints.iter().map(|keypoints| vec![false; keypoints.len()]).collect();
        Self { seen, claimed, ids: HashSet::new(), points: Points3D::default() }
    }

    /// The points, if every keypoint that names a point has been claimed by it.
    pub fn into_points(self) -> Result<Points3D, Unclaimed> {
        if self.points.observation_count() == self.seen.observation_count() {
            return Ok(self.points);
        }
        let claimed = self.seen.ids.iter().copied().zip(self.claimed).collect();
        Err(Unclaimed { claimed, ids: self.ids })
    }
}

impl TakePoints for Claims<'_> {
    fn is_new(&mut self, id: Point3DId) -> bool {
        self.ids.insert(id)
    }

    /// Claims the keypoint.
    fn check(&mut self, point: Point3DId, element: TrackElement) -> Result<(), Why> {
        let TrackElement { image, keypoint } = element;
        let seen = self.seen.index(image).ok_or(Why::UnknownImage(image.0.into()))?;
        let index = usize::try_from(keypoint).unwrap_or(usize::MAX);
        let keypoints = self.seen.keypoints[seen];
        let (Some(found), Some(claimed)) =
            (keypoints.get(index), self.claimed[seen].get_mut(index))
        else {
            return Err(Why::UnknownKeypoint { image, keypoint, count: keypoints.len() });
        };
        if found.point != Some(point) {
            return Err(Why::NotItsKeypoint { image, keypoint, owner: found.point });
        }
        if std::mem::replace(claimed, true) {
            return Err(Why::SeenTwice { image, keypoint });
        }
        Ok(())
    }

    fn take(&mut self, point: ReadPoint) {
        self.points.push(point);
    }
}

/// Some keypoint names a point that has not claimed it: which one shows when the images are read again.
pub struct Unclaimed {
    claimed: BTreeMap<ImageId, Vec<bool>>,
    ids: HashSet<Point3DId>,
}

impl TakeImages for Unclaimed {
    fn check(&mut self, image: ImageId, index: usize, point: Point3DId) -> Result<(), Why> {
        let claimed = self.claimed.get(&image).ok_or(Why::UnknownImage(image.0.into()))?;
        match claimed.get(index) {
            Some(true) => Ok(()),
            _ if self.ids.contains(&point) => Err(Why::NotInTrack(point)),
            _ => Err(Why::UnknownPoint(point)),
        }
    }

    fn take(&mut self, _: ImageId, _: Image) {}
}
