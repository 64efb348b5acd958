//! What was detected in one image.

use super::Point3DId;
use super::compact::Compact;

/// A detected image point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keypoint {
    /// Where, in px; the first pixel's centre is (0.5, 0.5).
    pub xy: [f64; 2],
    /// The triangulated point it is seen as, if any.
    pub point: Option<Point3DId>,
}

/// The keypoints of one image, in the order by which tracks refer to them.
///
/// Most keypoints of a real image are seen as no point: only those that are take room for an id.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Keypoints {
    xy: Compact<[f64; 2]>,
    /// Which keypoints name a point, 64 to a word.
    naming: Vec<Word>,
    /// The points of those that name one.
    points: Compact<Point3DId>,
}

/// Which of 64 keypoints name a point, the first one in the lowest bit.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Word {
    bits: u64,
    /// How many of the keypoints before these name a point.
    before: usize,
}

impl Keypoints {
    /// Adds one at the end.
    #[inline]
    pub fn push(&mut self, keypoint: Keypoint) {
        let bit = self.len() % 64;
        if bit == 0 {
            self.naming.push(Word { bits: 0, before: self.points.len() });
        }
        self.xy.push(keypoint.xy);
        if let (Some(point), Some(word)) = (keypoint.point, self.naming.last_mut()) {
            word.bits |= 1 << bit;
            self.points.push(point);
        }
    }

    /// Forgets all, and keeps the room for others; a clone takes no more room than it needs.
    pub fn clear(&mut self) {
        self.xy.clear();
        self.naming.clear();
        self.points.clear();
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.xy.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many of them are seen as a point.
    pub fn observation_count(&self) -> usize {
        self.points.len()
    }

    /// The one at this index.
    pub fn get(&self, index: usize) -> Option<Keypoint> {
        Some(Keypoint { xy: self.xy.get(index)?, point: self.point(index) })
    }

    /// The point that the keypoint at this index is seen as; none, too, where there is no keypoint.
    #[inline]
    pub fn point(&self, index: usize) -> Option<Point3DId> {
        let word = self.naming.get(index / 64)?;
        let bit = 1_u64 << (index % 64);
        if word.bits & bit == 0 {
            return None;
        }
        self.points.get(word.before + (word.bits & (bit - 1)).count_ones() as usize)
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = Keypoint> {
        let mut points = self.points.iter();
        self.xy.iter().enumerate().map(move |(index, xy)| {
            let names_one = self.naming[index / 64].bits >> (index % 64) & 1 == 1;
            Keypoint { xy, point: if names_one { points.next() } else { None } }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keypoints_come_back_in_order_with_and_without_a_point() {
        // Words without, with some and with only keypoints that name a point, and one that is not full.
        let names_one = |index: u64| index >= 64 && (index >= 128 || index.is_multiple_of(3));
        let pushed: Vec<Keypoint> = (0..250_u32)
            .map(|index| Keypoint {
                xy: [f64::from(index), 0.1],
                point: names_one(index.into()).then_some(Point3DId(1000 - u64::from(index))),
            })
            .collect();
        let mut keypoints = Keypoints::default();
        for round in 0..2 {
            pushed.iter().for_each(|&keypoint| keypoints.push(keypoint));
            assert_eq!(keypoints.iter().collect::<Vec<_>>(), pushed, "round {round}");
            let by_index: Vec<_> = (0..250).filter_map(|index| keypoints.get(index)).collect();
            assert_eq!(by_index, pushed);
            assert_eq!(keypoints.observation_count(), 21 + 122);
            assert_eq!((keypoints.get(250), keypoints.point(250)), (None, None));
            assert_eq!((keypoints.get(256), keypoints.point(256)), (None, None));
            keypoints.clear();
            assert!(keypoints.is_empty());
        }
    }
}
