//! The triangulated points of a reconstruction, kept in few large arrays.

use std::borrow::Borrow;
use std::ops::Range;

use super::compact::Compact;
use super::{ImageId, Point3DId};

/// One sighting in a point's track: keypoint `keypoint` of image `image`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackElement {
    /// The image.
    pub image: ImageId,
    /// Index among the image's keypoints.
    pub keypoint: u32,
}

/// A triangulated point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point3D<Track> {
    /// Its id.
    pub id: Point3DId,
    /// Where, in world coordinates.
    pub xyz: [f64; 3],
    /// Its colour.
    pub rgb: [u8; 3],
    /// Mean reprojection error as COLMAP stored it, in px; -1 when it was not computed.
    pub error_px: f64,
    /// Where it was seen: a slice of `TrackElement`s, or what iterates over them.
    pub track: Track,
}

/// The triangulated points, in the order in which they were added.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Points3D {
    ids: Compact<Point3DId>,
    xyz: Vec<[f64; 3]>,
    rgb: Vec<[u8; 3]>,
    error_px: Vec<f64>,
    /// Where each track ends in `tracks`.
    track_ends: Compact<usize>,
    tracks: Compact<TrackElement>,
}

/// The sightings of one point, in the order of the file.
#[derive(Debug, Clone)]
pub struct Track<'a> {
    tracks: &'a Compact<TrackElement>,
    left: Range<usize>,
}

impl Points3D {
    /// Adds one at the end. That its id is new is the caller's to know.
    pub fn push(&mut self, point: Point3D<impl IntoIterator<Item: Borrow<TrackElement>>>) {
        self.ids.push(point.id);
        self.xyz.push(point.xyz);
        self.rgb.push(point.rgb);
        self.error_px.push(point.error_px);
        point.track.into_iter().for_each(|element| self.tracks.push(*element.borrow()));
        self.track_ends.push(self.tracks.len());
    }

    /// Adds all of the other's at the end.
    pub fn append(&mut self, mut other: Self) {
        let earlier = self.tracks.len();
        self.ids.append(other.ids);
        self.xyz.append(&mut other.xyz);
        self.rgb.append(&mut other.rgb);
        self.error_px.append(&mut other.error_px);
        self.tracks.append(other.tracks);
        other.track_ends.iter().for_each(|end| self.track_ends.push(earlier + end));
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many sightings all tracks hold together.
    pub fn observation_count(&self) -> usize {
        self.tracks.len()
    }

    /// Their ids, in order.
    pub fn ids(&self) -> impl Iterator<Item = Point3DId> {
        self.ids.iter()
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = Point3D<Track<'_>>> {
        let places = self.xyz.iter().zip(&self.rgb).zip(&self.error_px);
        let mut start = 0;
        self.ids.iter().zip(places).zip(self.track_ends.iter()).map(move |((id, place), end)| {
            let ((&xyz, &rgb), &error_px) = place;
            let left = std::mem::replace(&mut start, end)..end;
            Point3D { id, xyz, rgb, error_px, track: Track { tracks: &self.tracks, left } }
        })
    }
}

impl Iterator for Track<'_> {
    type Item = TrackElement;

    #[inline]
    fn next(&mut self) -> Option<TrackElement> {
        self.left.next().and_then(|index| self.tracks.get(index))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.left.size_hint()
    }
}

impl ExactSizeIterator for Track<'_> {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_keeps_its_own_track() {
        let sighting = |image, keypoint| TrackElement { image: ImageId(image), keypoint };
        let tracks = [
            vec![sighting(1, 0), sighting(2, 5)],
            vec![],
            vec![sighting(2, 6)],
            vec![sighting(70_000, 1), sighting(3, 0)],
        ];
        let mut points = Points3D::default();
        // By halves: the second half is appended.
        for half in [0..2, 2..4] {
            let mut these = Points3D::default();
            for index in half {
                let (id, xyz) = (Point3DId(7 - index as u64), [index as f64, 1.0, 2.0]);
                these.push(Point3D {
                    id,
                    xyz,
                    rgb: [1, 2, 3],
                    error_px: 0.5,
                    track: &tracks[index],
                });
            }
            points.append(these);
        }
        assert_eq!(points.iter().map(|point| point.track.len()).collect::<Vec<_>>(), [2, 0, 1, 2]);
        let back: Vec<Vec<TrackElement>> = points.iter().map(|p| p.track.collect()).collect();
        assert_eq!(back, tracks);
        assert_eq!(points.ids().map(|id| id.0).collect::<Vec<_>>(), [7, 6, 5, 4]);
        let bits = |x: f64| x.to_bits();
        let xs: Vec<u64> = points.iter().map(|point| bits(point.xyz[0])).collect();
        assert_eq!(xs, [0.0, 1.0, 2.0, 3.0].map(bits));
        assert_eq!((points.len(), points.observation_count()), (4, 5));
    }
}
