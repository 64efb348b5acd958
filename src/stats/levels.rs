//! How often the tests err, and find what is there, by simulation.

use super::testing::Random;
use super::{Repeats, brown_forsythe, f_test, f_test_power, holm};

const LEVEL: f64 = 0.05;

fn normal(random: &mut Random, n: usize, std: f64) -> Repeats {
    let values: Vec<f64> = (0..n).map(|_| std * random.normal()).collect();
    Repeats::of_numbers(&values).unwrap()
}

fn p_of_f(one: &Repeats, other: &Repeats) -> f64 {
    f_test([one.std(), one.degrees()], [other.std(), other.degrees()]).unwrap().p
}

/// The share of trials that come out true, and three standard errors of a share that is truly `expected`.
fn share(trials: u32, expected: f64, mut trial: impl FnMut() -> bool) -> (f64, f64) {
    let count: u32 = (0..trials).map(|_| u32::from(trial())).sum();
    let error = (expected * (1.0 - expected) / f64::from(trials)).sqrt();
    (f64::from(count) / f64::from(trials), 3.0 * error)
}

#[test]
fn holms_correction_of_independent_tests_errs_in_five_percent() {
    let mut random = Random(1);
    // Some of three true hypotheses is rejected when the least p is below a third of the level.
    let expected = 1.0 - (1.0 - LEVEL / 3.0).powi(3);
    let (found, error) = share(6000, expected, || {
        let tests: [f64; 3] = std::array::from_fn(|_| {
            p_of_f(&normal(&mut random, 6, 2.0), &normal(&mut random, 4, 2.0))
        });
        holm(&tests).iter().any(|p| *p < LEVEL)
    });
    assert!((found - expected).abs() < error, "{found}, expected {expected} +- {error}");
}

#[test]
fn all_pairs_of_equal_groups_err_in_no_more_than_five_percent() {
    let mut random = Random(2);
    let (found, error) = share(4000, LEVEL, || {
        let groups: [Repeats; 4] = std::array::from_fn(|_| normal(&mut random, 6, 1.0));
        let pairs = (0..4).flat_map(|a| (0..a).map(move |b| (a, b)));
        let tests: Vec<f64> = pairs.map(|(a, b)| p_of_f(&groups[a], &groups[b])).collect();
        holm(&tests).iter().any(|p| *p < LEVEL)
    });
    assert!(found < LEVEL + error && found > 0.02, "{found}");
}

/// Rows of a smooth field: a few effects of unequal size, as those of a lens.
fn fields(random: &mut Random, n: usize, sizes: &[f64]) -> Repeats {
    let row = |random: &mut Random| {
        let effects: Vec<f64> = sizes.iter().map(|size| size * random.normal()).collect();
        let at = |column: u32| {
            let wave =
                |order: u32| (f64::from(order * column) * std::f64::consts::TAU / 30.0).cos();
            (1_u32..).zip(&effects).map(|(order, effect)| effect * wave(order)).sum::<f64>()
        };
        (0..30).map(at).collect::<Vec<f64>>()
    };
    Repeats::new((0..n).map(|_| row(random)).collect()).unwrap()
}

#[test]
fn spreads_of_equal_fields_are_told_apart_in_no_more_than_five_percent() {
    for (n, sizes) in
        [(3, [1.0, 0.6, 0.3, 0.2]), (6, [1.0, 0.6, 0.3, 0.2]), (6, [1.0, 0.2, 0.1, 0.1])]
    {
        let mut random = Random(3);
        let (mut by_parameters, trials) = (0_u32, 3000);
        let (found, error) = share(trials, LEVEL, || {
            let [one, other] = std::array::from_fn(|_| fields(&mut random, n, &sizes));
            let degrees = 4.0 * (n - 1) as f64;
            let naive = f_test([one.std(), degrees], [other.std(), degrees]).unwrap().p;
            by_parameters += u32::from(naive < LEVEL);
            p_of_f(&one, &other) < LEVEL
        });
        assert!(found < LEVEL + error, "n = {n}, {sizes:?}: {found}");
        // What p (n - 1) degrees would do: the reason for counting columns.
        assert!(by_parameters > trials / 10, "{by_parameters} of {trials}");
    }
}

#[test]
fn the_power_is_how_often_the_f_test_finds_a_ratio() {
    let expected = f_test_power(2.5, [5.0, 7.0], LEVEL).unwrap();
    let mut random = Random(4);
    let (found, error) = share(4000, expected, || {
        p_of_f(&normal(&mut random, 6, 2.5), &normal(&mut random, 8, 1.0)) < LEVEL
    });
    assert!((found - expected).abs() < error, "{found}, expected {expected}");
}

#[test]
fn samples_with_long_tails_mislead_the_f_test_and_not_brown_forsythe() {
    let mut random = Random(5);
    // Student's t with 3 degrees
    let sample = |random: &mut Random| {
        let value = |random: &mut Random| {
            let square: f64 = (0..3).map(|_| random.normal().powi(2)).sum();
            random.normal() / (square / 3.0).sqrt()
        };
        let values: Vec<f64> = (0..20).map(|_| value(random)).collect();
        Repeats::of_numbers(&values).unwrap()
    };
    let mut misled = 0_u32;
    let (found, error) = share(3000, LEVEL, || {
        let [one, other] = [sample(&mut random), sample(&mut random)];
        misled += u32::from(p_of_f(&one, &other) < LEVEL);
        brown_forsythe(&[&one, &other]).unwrap().p < LEVEL
    });
    assert!(found < LEVEL + error, "{found}");
    assert!(misled > 600, "{misled} of 3000: a fifth and more were seen with 20 samples");
}
