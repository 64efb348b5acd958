//! Angles in plain arithmetic, so that loops over them become SIMD.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// atan2(across, along) for across >= 0, to 2 units in the last place.
#[inline(always)]
pub fn angle(across: f64, along: f64) -> f64 {
    /// The tangent of 22.5 degrees.
    const EIGHTH: f64 = 0.414_213_562_373_095_03;
    /// (t - atan t) / t^3 in powers of t^2, for |t| up to `EIGHTH`: interpolated at Chebyshev's points, 5e-18 of t off.
    const SERIES: [f64; 11] = [
        0.333_333_333_333_333_04,
        -0.199_999_999_999_839_47,
        0.142_857_142_832_169_88,
        -0.111_111_109_319_571_69,
        0.090_909_019_453_640_65,
        -0.076_921_331_464_564_04,
        0.066_639_149_661_220_49,
        -0.058_536_582_024_838_954,
        0.050_647_150_830_605_76,
        -0.038_695_713_623_895_84,
        0.018_583_061_165_678_042,
    ];
    let forward = along.abs();
    // Turned back by 0, 45 or 90 degrees, 22.5 are left.
    let past_first = across > EIGHTH * forward;
    let past_second = EIGHTH * across > forward;
    let choose = |first: f64, second: f64, third: f64| {
        let later = if past_second { third } else { second };
        if past_first { later } else { first }
    };
    let turn = choose(0.0, FRAC_PI_4, FRAC_PI_2);
    let sine = choose(across, across - forward, -forward);
    let cosine = choose(forward, across + forward, across);
    let t = sine / cosine;
    let square = t * t;
    let rest = SERIES.iter().rev().fold(0.0, |sum, term| sum * square + term);
    let angle = turn + (t - t * square * rest);
    if along < 0.0 { PI - angle } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_the_standard_library_to_two_units_in_the_last_place() {
        for index in 0..=200_000 {
            let theta = PI * f64::from(index) / 200_000.0;
            for length in [1e-3, 1.0, 7e5] {
                let (across, along) = (theta.sin().max(0.0) * length, theta.cos() * length);
                let want = across.atan2(along);
                let found = angle(across, along);
                assert!((found - want).abs() <= 2.0 * f64::EPSILON * want, "{across} {along}");
            }
        }
        assert!(angle(f64::NAN, 1.0).is_nan() && angle(1.0, f64::NAN).is_nan());
    }
}
