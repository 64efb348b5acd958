//! Seeded chance: SplitMix64 (G. L. Steele et al., Fast Splittable Pseudorandom Number Generators, 2014).
//!
//! Its own, since the generators of libraries may change between versions, and a seed must always give the same images.

/// A stream of random numbers.
#[derive(Debug, Clone)]
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 bits.
    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    /// The numbers below `count` in an order of chance.
    pub(super) fn order(&mut self, count: usize) -> Vec<usize> {
        let mut keyed: Vec<(u64, usize)> = (0..count).map(|at| (self.bits(), at)).collect();
        keyed.sort_unstable();
        keyed.into_iter().map(|(_, at)| at).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_that_are_published() {
        let mut random = Random::new(1_234_567);
        // Of the reference implementation, <https://rosettacode.org/wiki/Pseudo-random_numbers/Splitmix64>.
        let wanted = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973];
        assert_eq!([random.bits(), random.bits()], wanted);
    }

    #[test]
    fn every_place_comes_first_about_as_often() {
        let mut first = [0; 5];
        (0..5000).for_each(|seed| first[Random::new(seed).order(5)[0]] += 1);
        // 1000 each, with a standard deviation of 28.
        assert!(first.iter().all(|&count| (850..1150).contains(&count)), "{first:?}");
    }
}
