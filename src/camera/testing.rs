//! What the tests of all models share.

use nalgebra::Vector3;

use super::{Intrinsics, MODELS, examples};

/// Points over the whole sphere of directions at distances from 0.1 to 100.
pub fn points() -> impl Iterator<Item = Vector3<f64>> {
    // Multiples of the plastic numbers' inverses fill a square evenly.
    (1..=2000).map(|index| {
        let index = f64::from(index);
        let [a, b, c] = [0.819_172_513_396_164_5, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3]
            .map(|step| (index * step).fract());
        let (z, longitude) = (2.0 * a - 1.0, std::f64::consts::TAU * b);
        let across = (1.0 - z * z).sqrt();
        Vector3::new(across * longitude.cos(), across * longitude.sin(), z)
            * 10_f64.powf(3.0 * c - 1.0)
    })
}

/// What is no number, or not a finite one.
pub const WILD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

/// Runs a law on every example; each model must have been checked often enough.
pub fn hold(law: impl Fn(&Intrinsics) -> usize, least: usize) {
    let mut counts: std::collections::BTreeMap<&str, usize> = std::collections::BTreeMap::new();
    for example in examples() {
        *counts.entry(example.model().name).or_default() += law(&example);
    }
    assert_eq!(counts.len(), MODELS.len());
    assert!(counts.values().all(|count| *count >= least), "{counts:?}");
}

/// Uniform in [-1, 1), the same numbers at every run (Marsaglia, Xorshift RNGs, 2003).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
