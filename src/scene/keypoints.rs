//! What was detected in one image.

use super::Point3DId;

/// A detected image point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keypoint {
    /// Where, in px; the first pixel's centre is (0.5, 0.5).
    pub xy: [f64; 2],
    /// The triangulated point it is seen as, if any.
    pub point: Option<Point3DId>,
}

/// The keypoints of one image, in the order by which tracks refer to them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Keypoints {
    xy: Vec<[f64; 2]>,
    /// `NONE` where there is no point: half the size of an `Option`.
    point: Vec<u64>,
}

const NONE: u64 = u64::MAX;

impl Keypoints {
    /// Room for this many.
    pub fn with_capacity(count: usize) -> Self {
        Self { xy: Vec::with_capacity(count), point: Vec::with_capacity(count) }
    }

    /// Adds one at the end.
    pub fn push(&mut self, keypoint: Keypoint) {
        self.xy.push(keypoint.xy);
        self.point.push(keypoint.point.map_or(NONE, |id| id.0));
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.xy.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.xy.is_empty()
    }

    /// The one at this index.
    pub fn get(&self, index: usize) -> Option<Keypoint> {
        let (&xy, &point) = self.xy.get(index).zip(self.point.get(index))?;
        Some(Keypoint { xy, point: (point != NONE).then_some(Point3DId(point)) })
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = Keypoint> {
        (0..self.len()).filter_map(|index| self.get(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keypoints_come_back_in_order_with_and_without_a_point() {
        let with = Keypoint { xy: [1.0, 2.0], point: Some(Point3DId(7)) };
        let without = Keypoint { xy: [3.0, 4.0], point: None };
        let mut keypoints = Keypoints::with_capacity(2);
        keypoints.push(with);
        keypoints.push(without);
        assert_eq!(keypoints.iter().collect::<Vec<_>>(), [with, without]);
        assert_eq!(keypoints.get(2), None);
    }
}
