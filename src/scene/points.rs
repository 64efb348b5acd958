//! The triangulated points of a reconstruction, kept in few large arrays.

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
pub struct Point3D<'a> {
    /// Its id.
    pub id: Point3DId,
    /// Where, in world coordinates.
    pub xyz: [f64; 3],
    /// Its colour.
    pub rgb: [u8; 3],
    /// Mean reprojection error as COLMAP stored it, in px; -1 when it was not computed.
    pub error_px: f64,
    /// Where it was seen.
    pub track: &'a [TrackElement],
}

/// The triangulated points, in the order in which they were added.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Points3D {
    ids: Vec<Point3DId>,
    xyz: Vec<[f64; 3]>,
    rgb: Vec<[u8; 3]>,
    error_px: Vec<f64>,
    /// Where each track ends in `tracks`.
    track_ends: Vec<usize>,
    tracks: Vec<TrackElement>,
}

impl Points3D {
    /// Adds one at the end. That its id is new is the caller's to know.
    pub fn push(&mut self, point: Point3D) {
        self.ids.push(point.id);
        self.xyz.push(point.xyz);
        self.rgb.push(point.rgb);
        self.error_px.push(point.error_px);
        self.tracks.extend_from_slice(point.track);
        self.track_ends.push(self.tracks.len());
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// How many sightings all tracks hold together.
    pub fn observation_count(&self) -> usize {
        self.tracks.len()
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = Point3D<'_>> {
        (0..self.len()).map(|index| {
            let start = if index == 0 { 0 } else { self.track_ends[index - 1] };
            Point3D {
                id: self.ids[index],
                xyz: self.xyz[index],
                rgb: self.rgb[index],
                error_px: self.error_px[index],
                track: &self.tracks[start..self.track_ends[index]],
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_keeps_its_own_track() {
        let sighting = |image, keypoint| TrackElement { image: ImageId(image), keypoint };
        let tracks = [vec![sighting(1, 0), sighting(2, 5)], vec![], vec![sighting(2, 6)]];
        let mut points = Points3D::default();
        for (id, track) in (1..).zip(&tracks) {
            let (id, xyz) = (Point3DId(id), [0.0, 1.0, 2.0]);
            points.push(Point3D { id, xyz, rgb: [1, 2, 3], error_px: 0.5, track });
        }
        let back: Vec<Vec<TrackElement>> = points.iter().map(|p| p.track.to_vec()).collect();
        assert_eq!(back, tracks);
        assert_eq!(points.observation_count(), 3);
    }
}
