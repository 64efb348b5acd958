//! Numbers that nearly always fit in half of their type, kept in that half.
//!
//! COLMAP's ids and indices are 32 or 64 bits wide and small; the keypoints of its own detector are whole `f32`s.

use super::points::TrackElement;
use super::{ImageId, Point3DId};

/// A number and the half that it may fit in: what is narrowed and widened again is the same to the last bit.
pub trait Halves: Copy {
    /// Half as wide.
    type Half: Copy + std::fmt::Debug + PartialEq;
    /// The half, if nothing is lost.
    fn narrow(self) -> Option<Self::Half>;
    /// What the half stands for.
    fn widen(half: Self::Half) -> Self;
}

/// A list that is narrow until a number that does not fit is pushed.
#[derive(Debug, Clone, PartialEq)]
pub struct Compact<Wide: Halves> {
    /// All numbers, while all fit.
    narrow: Vec<Wide::Half>,
    /// All numbers, from the first that does not fit on: one of the two lists is empty.
    wide: Vec<Wide>,
}

impl<Wide: Halves> Default for Compact<Wide> {
    fn default() -> Self {
        Self { narrow: Vec::new(), wide: Vec::new() }
    }
}

impl<Wide: Halves> Compact<Wide> {
    /// Adds one at the end.
    #[inline]
    pub fn push(&mut self, number: Wide) {
        if self.wide.is_empty() {
            if let Some(half) = number.narrow() {
                self.narrow.push(half);
                return;
            }
            self.widen();
        }
        self.wide.push(number);
    }

    /// Adds all of the other's at the end.
    pub fn append(&mut self, mut other: Self) {
        if self.wide.is_empty() && other.wide.is_empty() {
            self.narrow.append(&mut other.narrow);
        } else {
            self.widen();
            other.widen();
            self.wide.append(&mut other.wide);
        }
    }

    #[cold]
    fn widen(&mut self) {
        self.wide.extend(std::mem::take(&mut self.narrow).into_iter().map(Wide::widen));
    }

    /// Forgets all, and keeps the room.
    pub fn clear(&mut self) {
        self.narrow.clear();
        self.wide.clear();
    }

    /// How many there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.narrow.len() + self.wide.len()
    }

    /// The one at this index.
    #[inline]
    pub fn get(&self, index: usize) -> Option<Wide> {
        match self.narrow.get(index) {
            Some(&half) => Some(Wide::widen(half)),
            None => self.wide.get(index).copied(),
        }
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = Wide> {
        self.narrow.iter().map(|&half| Wide::widen(half)).chain(self.wide.iter().copied())
    }
}

/// A place in px.
impl Halves for [f64; 2] {
    type Half = [f32; 2];

    #[inline]
    #[allow(clippy::cast_possible_truncation)] // looked at right after
    fn narrow(self) -> Option<[f32; 2]> {
        let half = self.map(|coordinate| coordinate as f32);
        (Self::widen(half).map(f64::to_bits) == self.map(f64::to_bits)).then_some(half)
    }

    #[inline]
    fn widen(half: [f32; 2]) -> Self {
        half.map(f64::from)
    }
}

/// An index.
impl Halves for usize {
    type Half = u32;

    #[inline]
    fn narrow(self) -> Option<u32> {
        self.try_into().ok()
    }

    #[inline]
    fn widen(half: u32) -> Self {
        half as usize
    }
}

impl Halves for Point3DId {
    type Half = u32;

    #[inline]
    fn narrow(self) -> Option<u32> {
        self.0.try_into().ok()
    }

    #[inline]
    fn widen(half: u32) -> Self {
        Self(half.into())
    }
}

impl Halves for TrackElement {
    type Half = [u16; 2];

    #[inline]
    fn narrow(self) -> Option<[u16; 2]> {
        Some([self.image.0.try_into().ok()?, self.keypoint.try_into().ok()?])
    }

    #[inline]
    fn widen([image, keypoint]: [u16; 2]) -> Self {
        Self { image: ImageId(image.into()), keypoint: keypoint.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What comes back of these numbers, and whether they are kept in halves.
    fn kept<Wide: Halves>(numbers: &[Wide]) -> (Vec<Wide>, bool) {
        let mut list = Compact::default();
        for &number in numbers {
            list.push(number);
        }
        assert_eq!(list.len(), numbers.len());
        let by_index: Vec<Wide> = (0..list.len()).filter_map(|index| list.get(index)).collect();
        assert!(list.get(numbers.len()).is_none() && by_index.len() == list.len());
        (list.iter().collect(), list.wide.is_empty())
    }

    #[test]
    fn places_are_halved_only_when_no_bit_is_lost() {
        let bits = |places: &[[f64; 2]]| places.iter().flatten().map(|x| x.to_bits()).collect();
        let exact = [
            [0.5, 1234.56787109375],
            [-0.0, f64::from(f32::MAX)],
            [0.0, f64::from(f32::MIN_POSITIVE)],
        ];
        let check = |places: &[[f64; 2]], wanted: bool| {
            let (back, is_narrow) = kept(places);
            let (back, pushed): (Vec<u64>, Vec<u64>) = (bits(&back), bits(places));
            assert_eq!((back, is_narrow), (pushed, wanted), "{places:?}");
        };
        check(&exact, true);
        for odd in [0.1, 1e39, 1e-60, f64::MAX, 16_777_217.0] {
            for place in [[odd, 0.5], [0.5, odd]] {
                check(&[exact[0], exact[1], place, exact[2]], false);
            }
        }
    }

    #[test]
    fn ids_and_tracks_are_halved_up_to_the_end_of_the_half() {
        let ids = [0, 7, u32::MAX.into()].map(Point3DId);
        assert_eq!(kept(&ids), (ids.to_vec(), true));
        let ids = [0, 1 << 32, 7, u64::MAX].map(Point3DId);
        assert_eq!(kept(&ids), (ids.to_vec(), false));
        let element = |image, keypoint| TrackElement { image: ImageId(image), keypoint };
        let track = [element(1, 65_535), element(65_535, 0)];
        assert_eq!(kept(&track), (track.to_vec(), true));
        for odd in [element(65_536, 0), element(0, 65_536), element(u32::MAX, u32::MAX)] {
            let track = [track[0], odd, track[1]];
            assert_eq!(kept(&track), (track.to_vec(), false));
        }
    }

    #[test]
    fn appending_is_pushing_whatever_fits() {
        let (small, large) = ([1, 2].map(Point3DId), [3, 1 << 40].map(Point3DId));
        let list = |ids: &[Point3DId]| {
            let mut list = Compact::default();
            ids.iter().for_each(|&id| list.push(id));
            list
        };
        let mut checked = 0;
        for first in [&small[..], &large, &[]] {
            for second in [&small[..], &large, &[]] {
                let mut appended = list(first);
                appended.append(list(second));
                assert_eq!(appended, list(&[first, second].concat()));
                checked += 1;
            }
        }
        assert_eq!(checked, 9);
    }
}
