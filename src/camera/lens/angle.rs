//! Angles in plain arithmetic, so that loops over them become SIMD.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// atan2(across, along) for across >= 0, to 2 units in the last place.
#[inline(always)]
pub fn angle(across: f64, along: f64) -> f64 {
    /// The tangent of 22.5 degrees.
    const EIGHTH: f64 = 0.414_213_562_373_095_03;
    /// (t - atan t) / t^3 in powers of t^2, for |t| up to `EIGHTH`: interpolated at Chebyshev's points, 5e-18 of t off.
    const SERIES: [f64; 12] = [
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
        0.0,
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
    let rest = series(&SERIES, square);
    let angle = turn + (t - t * square * rest);
    if along < 0.0 { PI - angle } else { angle }
}

/// c0 + c1 s + c2 s^2 + ... of an even count of terms: even and odd powers apart, as neither then waits for the other.
#[inline(always)]
fn series<const K: usize>(terms: &[f64; K], s: f64) -> f64 {
    let s2 = s * s;
    let (pairs, _) = terms.as_chunks::<2>();
    let add = |[even, odd]: [f64; 2], [a, b]: &[f64; 2]| [even * s2 + a, odd * s2 + b];
    let [even, odd] = pairs.iter().rev().fold([0.0; 2], add);
    even + s * odd
}

/// sin and cos of 0 to 180 degrees, to 2 units in the last place.
#[inline(always)]
pub fn sine_and_cosine(angle: f64) -> [f64; 2] {
    /// What the double of 90 degrees lacks.
    const REST: f64 = 6.123_233_995_736_766e-17;
    /// Coefficients for |t| up to 45 degrees: FreeBSD's k_sin.c and k_cos.c, 2^-58 of the sine and cosine off.
    const SINE: [f64; 6] = [
        -1.666_666_666_666_663_2e-1,
        8.333_333_333_322_49e-3,
        -1.984_126_982_985_795e-4,
        2.755_731_370_707_006_8e-6,
        -2.505_076_025_340_686_3e-8,
        1.589_690_995_211_55e-10,
    ];
    const COSINE: [f64; 6] = [
        4.166_666_666_666_66e-2,
        -1.388_888_888_887_411e-3,
        2.480_158_728_947_673e-5,
        -2.755_731_435_139_066_3e-7,
        2.087_572_321_298_175e-9,
        -1.135_964_755_778_819_5e-11,
    ];
    // Turned back by 0, 90 or 180 degrees, 45 are left.
    let (past_first, past_second) = (angle > FRAC_PI_4, angle > 3.0 * FRAC_PI_4);
    let choose = |first: f64, second: f64, third: f64| {
        let later = if past_second { third } else { second };
        if past_first { later } else { first }
    };
    let t = angle - choose(0.0, FRAC_PI_2, PI) - choose(0.0, REST, 2.0 * REST);
    let square = t * t;
    let sine = t + t * square * series(&SINE, square);
    let cosine = 1.0 - (0.5 * square - square * square * series(&COSINE, square));
    [choose(sine, cosine, -sine), choose(cosine, -sine, -cosine)]
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

    #[test]
    fn sines_and_cosines_are_those_of_the_standard_library_to_two_units_in_the_last_place() {
        for index in 0..=200_000 {
            let theta = PI * f64::from(index) / 200_000.0;
            let (sine, cosine) = theta.sin_cos();
            for (found, want) in sine_and_cosine(theta).into_iter().zip([sine, cosine]) {
                assert!((found - want).abs() <= 2.0 * f64::EPSILON * want.abs(), "{theta} {found}");
            }
        }
    }
}
