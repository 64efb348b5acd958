//! The groups that have one camera, ranked and tested pair by pair.

use super::super::deviations::{self, cameras};
use super::super::{Parameter, Population, SampleState};
use super::{GroupComparison, PairTest, ParameterTest, RankedGroup, SameCamera, TestMethod};
use crate::stats::{
    Repeats, brown_forsythe, f_test, f_test_power, holm, samples_needed,
    std_interval_factors_of_degrees,
};

/// From so many samples in both groups on, the test that needs no normal samples can reject; with three it never does.
const ENOUGH_FOR_BROWN_FORSYTHE: usize = 10;
/// Beyond so many groups the pairs are hundreds: no one reads them, and Holm's correction leaves nothing.
pub(in super::super) const MOST_GROUPS: usize = 24;
const LEVEL: f64 = 0.05;
const POWER: f64 = 0.8;
const RATIO: f64 = 2.0;

/// Every camera that several groups have, compared.
pub(in super::super) fn comparisons(
    populations: &[Population],
    same: &[SameCamera],
) -> Vec<GroupComparison> {
    let mut all = Vec::new();
    for SameCamera { camera, members } in same {
        let is_member =
            |one: &&Population| members.contains(&(one.group.clone(), one.camera.clone()));
        let mut members: Vec<&Population> = populations.iter().filter(is_member).collect();
        members.sort_by_key(|one| (one.width, one.height));
        let of_one_size = members.chunk_by(|a, b| (a.width, a.height) == (b.width, b.height));
        all.extend(of_one_size.filter(|members| members.len() > 1).map(|m| comparison(camera, m)));
    }
    all.sort_by(|a, b| natord::compare(&a.camera, &b.camera));
    all
}

/// A group's calibrations of the camera, and how far they spread.
struct Contender<'a> {
    population: &'a Population,
    n: usize,
    spread: Option<Repeats>,
    raw_spread_px: Option<f64>,
}

fn comparison(camera: &str, members: &[&Population]) -> GroupComparison {
    let size = [members[0].width, members[0].height];
    let groups: Vec<_> = members.iter().map(|one| cameras(one)).collect();
    let seen = deviations::apart(&groups, size);
    let image_share = seen.as_ref().map(|seen| seen.image_share);
    // Calibrations that were all held have no spread.
    let spread = |rows: &Vec<Vec<f64>>| Repeats::new(rows.clone()).filter(|one| one.std() > 0.0);
    let contenders =
        members.iter().zip(&groups).enumerate().map(|(index, (population, cameras))| {
            let aligned = seen.as_ref().and_then(|seen| seen.aligned.as_ref());
            Contender {
                population,
                n: cameras.len(),
                spread: aligned.and_then(|rows| spread(&rows[index])),
                raw_spread_px: seen.as_ref().and_then(|s| spread(&s.raw[index])).map(|s| s.std()),
            }
        });
    let mut contenders: Vec<Contender> = contenders.collect();
    let std = |one: &Contender| one.spread.as_ref().map_or(f64::INFINITY, Repeats::std);
    contenders.sort_by(|a, b| {
        std(a).total_cmp(&std(b)).then(natord::compare(&a.population.group, &b.population.group))
    });
    let is_few = contenders.len() <= MOST_GROUPS;
    let pairs: Vec<[&Contender; 2]> = contenders
        .iter()
        .enumerate()
        .filter(|_| is_few)
        .flat_map(|(index, less)| contenders[index + 1..].iter().map(move |more| [more, less]))
        .collect();
    let mut spreads: Vec<PairTest> = pairs.iter().filter_map(|pair| spread_test(*pair)).collect();
    correct(&mut spreads.iter_mut().collect::<Vec<_>>());
    let mut parameters: Vec<ParameterTest> =
        pairs.iter().flat_map(|pair| parameter_tests(*pair)).collect();
    correct(&mut parameters.iter_mut().map(|one| &mut one.test).collect::<Vec<_>>());
    GroupComparison {
        camera: camera.to_owned(),
        width: size[0],
        height: size[1],
        image_share,
        ranking: contenders.iter().map(ranked).collect(),
        spreads,
        parameters,
    }
}

fn ranked(contender: &Contender) -> RankedGroup {
    let Contender { population, n, spread, raw_spread_px } = contender;
    let degrees = spread.as_ref().map(Repeats::degrees);
    let spread_px = spread.as_ref().map(Repeats::std);
    let factors = degrees.and_then(|degrees| std_interval_factors_of_degrees(degrees, 1.0 - LEVEL));
    RankedGroup {
        group: population.group.clone(),
        camera: population.camera.clone(),
        model: population.model.clone(),
        n: *n,
        spread_px,
        raw_spread_px: *raw_spread_px,
        spread_interval_95: spread_px.zip(factors).map(|(std, factors)| factors.map(|f| f * std)),
        degrees,
    }
}

fn spread_test(pair: [&Contender; 2]) -> Option<PairTest> {
    let [more, less] = [pair[0].spread.as_ref()?, pair[1].spread.as_ref()?];
    pair_test(pair.map(|one| one.population), [more, less])
}

/// Of every parameter that both estimated, where they have the same ones.
fn parameter_tests(pair: [&Contender; 2]) -> Vec<ParameterTest> {
    let [one, other] = pair.map(|contender| contender.population);
    if one.model != other.model {
        return Vec::new();
    }
    let test = |(a, b): (&Parameter, &Parameter)| {
        let [x, y] = [estimated(a)?, estimated(b)?];
        let test = if x.std() >= y.std() {
            pair_test([one, other], [&x, &y])
        } else {
            pair_test([other, one], [&y, &x])
        };
        Some(ParameterTest { parameter: a.name.clone(), test: test? })
    };
    one.parameters.iter().zip(&other.parameters).filter_map(test).collect()
}

fn estimated(parameter: &Parameter) -> Option<Repeats> {
    let samples = parameter.samples.iter();
    let values: Vec<f64> = samples
        .filter(|sample| sample.state == SampleState::Estimated)
        .filter_map(|sample| sample.value)
        .collect();
    Repeats::of_numbers(&values)
}

/// The test of samples of which the first varies more.
fn pair_test(populations: [&Population; 2], samples: [&Repeats; 2]) -> Option<PairTest> {
    let (n, std) = (samples.map(Repeats::n), samples.map(Repeats::std));
    let degrees = samples.map(Repeats::degrees);
    let is_enough = n.iter().all(|n| *n >= ENOUGH_FOR_BROWN_FORSYTHE);
    let (method, test) = if is_enough {
        (TestMethod::BrownForsythe, brown_forsythe(&samples)?)
    } else {
        (TestMethod::F, f_test([std[0], degrees[0]], [std[1], degrees[1]])?)
    };
    // The two lose little by taking the columns as in the poorer one.
    let columns =
        (0..2).map(|side| degrees[side] / (n[side] - 1) as f64).fold(f64::INFINITY, f64::min);
    let ratio = std[0] / std[1];
    Some(PairTest {
        groups: populations.map(|one| one.group.clone()),
        models: populations.map(|one| one.model.clone()),
        n,
        std,
        ratio,
        method,
        f: test.f,
        degrees: test.degrees,
        p: test.p,
        p_holm: test.p,
        power_at_2: f_test_power(RATIO, degrees, LEVEL)?,
        n_for_2: samples_needed(RATIO, columns, LEVEL, POWER),
        n_for_ratio: samples_needed(ratio, columns, LEVEL, POWER),
    })
}

fn correct(tests: &mut [&mut PairTest]) {
    let p: Vec<f64> = tests.iter().map(|test| test.p).collect();
    for (test, corrected) in tests.iter_mut().zip(holm(&p)) {
        test.p_holm = corrected;
    }
}
