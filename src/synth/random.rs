//! Seeded random numbers: xoshiro256++, seeded by SplitMix64.
//!
//! Its own, since the generators of libraries may change between versions, and a seed must give the same scene in all of ours.
//!
//! D. Blackman, S. Vigna, Scrambled Linear Pseudorandom Number Generators, 2021; <https://prng.di.unimi.it>

use std::f64::consts::TAU;

use nalgebra::Vector3;

/// What numbers are drawn for: each purpose has a stream of its own, so that more of one changes nothing of another.
#[derive(Debug, Clone, Copy)]
pub enum Purpose {
    /// Where the points are.
    World,
    /// From where images are taken.
    Views,
    /// Which of the visible points an image sees.
    Sightings,
    /// The errors of pixels.
    Noise,
    /// How far off the start is.
    Start,
    /// Which images are taken out of a reconstruction.
    Selection,
}

/// A stream of random numbers.
pub struct Random {
    state: [u64; 4],
}

impl Random {
    /// The stream of this purpose in this run.
    pub fn new(seed: u64, run: u64, purpose: Purpose) -> Self {
        let of_seed = split_mix(&mut { seed });
        let of_run = split_mix(&mut { of_seed ^ run });
        Self::of_seed(of_run ^ purpose as u64)
    }

    fn of_seed(mut seed: u64) -> Self {
        Self { state: std::array::from_fn(|_| split_mix(&mut seed)) }
    }

    /// 64 bits.
    pub fn bits(&mut self) -> u64 {
        let s = &mut self.state;
        let drawn = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let shifted = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= shifted;
        s[3] = s[3].rotate_left(45);
        drawn
    }

    /// A number from `low` on and below `high`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        // The upper 53 bits, as many as a double holds.
        let share = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * share
    }

    /// A number around 0 with standard deviation 1, normally distributed (Box and Muller, 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform(0.0, 1.0)).ln()).sqrt();
        radius * (TAU * self.uniform(0.0, 1.0)).cos()
    }

    /// Passes over a normally distributed number.
    pub fn pass_normal(&mut self) {
        self.bits();
        self.bits();
    }

    /// A point of a box around the origin with these half sides.
    pub fn in_box(&mut self, half: [f64; 3]) -> Vector3<f64> {
        Vector3::from(half.map(|half| self.uniform(-half, half)))
    }

    /// Three normally distributed numbers.
    pub fn normals(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal())
    }

    /// The numbers below `count` in an order of chance.
    pub fn order(&mut self, count: usize) -> Vec<usize> {
        let mut keyed: Vec<(u64, usize)> = (0..count).map(|at| (self.bits(), at)).collect();
        keyed.sort_unstable();
        keyed.into_iter().map(|(_, at)| at).collect()
    }

    /// This many of the numbers, or all of them, in their order.
    pub fn choose<T>(&mut self, count: usize, from: Vec<T>) -> Vec<T> {
        let mut is_chosen = vec![false; from.len()];
        self.order(from.len()).into_iter().take(count).for_each(|at| is_chosen[at] = true);
        from.into_iter().zip(is_chosen).filter(|(_, chosen)| *chosen).map(|(one, _)| one).collect()
    }
}

/// The next number of SplitMix64.
fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_generators_give_the_numbers_of_rand_xoshiro_0_7() {
        let mut state = 1_477_776_061_723_855_037;
        let mixed: [u64; 3] = std::array::from_fn(|_| split_mix(&mut state));
        let wanted = [1985237415132408290, 2979275885539914483, 13511426838097143398];
        assert_eq!(mixed, wanted);
        let mut random = Random { state: [1, 2, 3, 4] };
        let drawn: [u64; 4] = std::array::from_fn(|_| random.bits());
        assert_eq!(drawn, [41943041, 58720359, 3588806011781223, 3591011842654386]);
        let mut random = Random::of_seed(0);
        let drawn: [u64; 4] = std::array::from_fn(|_| random.bits());
        let wanted =
            [5987356902031041503, 7051070477665621255, 6633766593972829180, 211316841551650330];
        assert_eq!(drawn, wanted);
    }

    #[test]
    fn normal_numbers_have_the_moments_of_the_normal_distribution() {
        let mut random = Random::new(1, 1, Purpose::Noise);
        let count = 100_000;
        let drawn: Vec<f64> = (0..count).map(|_| random.normal()).collect();
        // The k-th moment of N numbers has the variance (E x^2k - (E x^k)^2) / N: 4.5 of its deviations are allowed.
        for (power, mean, variance) in
            [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)]
        {
            let moment = drawn.iter().map(|x| x.powi(power)).sum::<f64>() / f64::from(count);
            let allowed = 4.5 * f64::sqrt(variance / f64::from(count));
            assert!((moment - mean).abs() < allowed, "moment {power} is {moment}");
        }
    }

    #[test]
    fn what_is_passed_over_is_what_would_have_been_drawn() {
        let [mut one, mut other] = [0, 0].map(|run| Random::new(1, run, Purpose::Noise));
        one.normal();
        other.pass_normal();
        assert_eq!(one.normal().to_bits(), other.normal().to_bits());
    }

    #[test]
    fn purposes_runs_and_seeds_have_streams_of_their_own() {
        let mut first = std::collections::BTreeSet::new();
        for (seed, run) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 1), (1, 2)] {
            for purpose in [
                Purpose::World,
                Purpose::Views,
                Purpose::Sightings,
                Purpose::Noise,
                Purpose::Start,
                Purpose::Selection,
            ] {
                first.insert(Random::new(seed, run, purpose).bits());
            }
        }
        assert_eq!(first.len(), 36);
    }

    #[test]
    fn each_is_chosen_equally_often_and_order_is_kept() {
        let mut random = Random::new(1, 1, Purpose::Sightings);
        let mut times = [0_u32; 10];
        for _ in 0..10_000 {
            let chosen = random.choose(3, (0..10).collect());
            assert!(chosen.len() == 3 && chosen.is_sorted());
            chosen.iter().for_each(|&one: &usize| times[one] += 1);
        }
        // 3000 of each are expected, with a deviation of sqrt(10000 * 0.3 * 0.7) = 46.
        assert!(times.iter().all(|&times| times.abs_diff(3000) < 230), "{times:?}");
        assert_eq!(random.choose(5, vec![1, 2]), [1, 2]);
    }
}
