//! The rule of the verdict: each cause alone, none, and several.

use super::super::clusters::{Clusters, Part};
use super::super::inside::{HeldClass, HeldTest, ResidualMap, Residuals, Tails};
use super::super::overlap::Overlap;
use super::super::remarks;
use super::super::spread::SetAside;
use super::super::testing::simple_radial;
use super::super::{
    Adjustment, Consistency, Options, Prediction, Ratio, RefinedCamera, Refinement, RunRecord,
    SampleState, Stopped, analyze,
};
use super::*;

const VALUES: [[f64; 2]; 6] = [
    [1000.5, -0.025],
    [1001.5, -0.026],
    [1003.5, -0.029],
    [1002.0, -0.02],
    [999.0, -0.023],
    [1000.0, -0.027],
];

/// What a verdict is made from.
struct Case {
    one: Population,
    runs: Vec<RunRecord>,
}

/// So many repeats of one camera about which there is nothing to say but how many they are.
fn case(count: usize) -> Case {
    let runs = simple_radial("g", &VALUES[..count]);
    let mut analysis = analyze(runs, vec![], Options::default()).unwrap();
    Case { one: analysis.populations.remove(0), runs: analysis.runs }
}

fn judged(mut case: Case) -> Verdict {
    let mut populations = [case.one];
    remarks::populations(&mut populations, &case.runs);
    let [one] = populations;
    case.one = one;
    case.one.verdict
}

/// The case, changed.
fn with(count: usize, change: impl FnOnce(&mut Case)) -> Verdict {
    let mut case = case(count);
    change(&mut case);
    judged(case)
}

fn ids(verdict: &Verdict) -> Vec<FindingId> {
    verdict.reasons.iter().map(|reason| reason.id).collect()
}

fn overlap(shared_fraction: f64, independent_factor: Option<f64>) -> Overlap {
    Overlap {
        shared_fraction,
        independent_factor,
        independent_rms_px: None,
        image_count: 6,
        images_per_run: 4.0,
        jackknife_factor: None,
    }
}

/// Runs that differ by so much, as found and corrected.
fn with_birge(found: f64, independent: Option<f64>) -> Prediction {
    let ratio = |birge: f64| Ratio { statistic: 10.0 * birge * birge, p: 1e-4, birge };
    let consistency = Consistency {
        n: 6,
        parameters: vec!["f".to_owned(), "k".to_owned()],
        weighted_mean: vec![1000.0, 0.01],
        weighted_mean_std: vec![1.0, 0.01],
        degrees: 10,
        found: ratio(found),
        independent: independent.map(ratio),
    };
    let consistency = Some(consistency);
    Prediction { spread: None, consistency, parameters: Vec::new(), directions: Vec::new() }
}

/// A test of a held principal point.
fn held(p: f64, effect_px: f64) -> Vec<HeldTest> {
    vec![HeldTest {
        class: HeldClass::PrincipalPoint,
        freed: vec!["cx".to_owned(), "cy".to_owned()],
        model: "SIMPLE_RADIAL".to_owned(),
        n: 6,
        p,
        effect_px: Some(effect_px),
        focal_change: Some(0.01),
        parameters: vec![],
        runs: vec![],
    }]
}

/// Residuals with such a pattern, and points that fit so.
fn residuals(p: f64, effect_px: f64, sigma_ratio: f64) -> Option<Residuals> {
    let map = ResidualMap {
        n: 6,
        columns: 12,
        rows: 9,
        cell_px: [50.0; 2],
        cells: vec![],
        rings: vec![],
    };
    let (points, robust_sigma_px, beyond_share) = (100, 0.5, 0.1);
    let tails = Some(Tails { points, robust_sigma_px, sigma_ratio, beyond_share, p });
    Some(Residuals { n: 6, p, effect_px, sigma_px: 0.5, tails, map, runs: vec![] })
}

fn parts(sizes: [usize; 2]) -> Clusters {
    let part = |size: usize| Part {
        runs: (0..size).map(|run| format!("run{run}")).collect(),
        gap_px: Some(3.0),
        spread_px: None,
        parameters: vec![],
    };
    Clusters { parts: sizes.map(part).into() }
}

/// The adjustment of a run that leaves the camera open.
fn open() -> Refinement {
    let camera = RefinedCamera {
        camera_id: 1,
        images: 2,
        failure: None,
        as_left: vec![],
        refined: vec![],
        free: vec![],
        covariance: None,
        clustered: None,
        undetermined: vec!["f +1 with k -0.0002".to_owned()],
    };
    let adjustment = Adjustment {
        stopped: Stopped::Converged,
        iterations: 1,
        initial_cost: 1.0,
        cost: 1.0,
        images: 2,
        points: 2,
        observations: 4,
        unprojectable: 0,
        lone_points: 0,
        of_lone_points: 0,
        components: 1,
        unknowns: 4,
        rank: 3,
        sigma_px: None,
        cameras: vec![camera],
    };
    Refinement { failure: None, adjustment: Some(adjustment) }
}

fn lose(case: &mut Case, count: usize) {
    for parameter in &mut case.one.parameters {
        for sample in &mut parameter.samples[..count] {
            (sample.state, sample.value) = (SampleState::Failed, None);
        }
    }
}

fn hold(case: &mut Case) {
    for sample in case.one.parameters.iter_mut().flat_map(|one| &mut one.samples) {
        sample.state = SampleState::Held;
    }
}

fn set_aside(case: &mut Case) {
    let aside = SetAside { run: "run6".to_owned(), camera_id: 1, without_ray: 0.2 };
    case.one.spread.as_mut().unwrap().set_aside.push(aside);
}

#[test]
fn without_a_finding_it_is_repeatable_to_the_spread() {
    let case = case(6);
    let spread = case.one.spread.clone().unwrap();
    let verdict = judged(case);
    assert_eq!((verdict.kind, verdict.n, ids(&verdict)), (VerdictKind::Repeatable, 6, vec![]));
    assert_eq!(verdict.spread_px, Some(spread.rotated.rms_px));
    assert_eq!(verdict.spread_interval_95, Some(spread.rotated_interval_95));
    let [low, high] = spread.rotated_interval_95;
    assert!(0.0 < low && low < spread.rotated.rms_px && spread.rotated.rms_px < high);
    // More degrees than of one parameter, no more than of both: f and k move the image differently.
    assert!(spread.degrees > 5.0 && spread.degrees <= 10.0, "{}", spread.degrees);
}

#[test]
fn what_runs_share_is_allowed_for_in_spread_and_interval() {
    let plain = judged(case(6));
    let shared = with(6, |case| case.one.overlap = Some(overlap(0.36, Some(1.25))));
    assert_eq!(shared.kind, VerdictKind::Repeatable);
    let ratio = shared.spread_px.unwrap() / plain.spread_px.unwrap();
    assert!((ratio - 1.25).abs() < 1e-15);
    for side in 0..2 {
        let of = |verdict: &Verdict| verdict.spread_interval_95.unwrap()[side];
        assert!((of(&shared) / of(&plain) - 1.25).abs() < 1e-15);
    }
}

type Change = fn(&mut Case);

/// How many runs, what is changed about them, and what the verdict must be.
fn causes() -> [(usize, Change, VerdictKind, &'static [FindingId]); 30] {
    use FindingId::*;
    use VerdictKind::*;
    [
        (6, |_| (), Repeatable, &[]),
        (5, |_| (), Repeatable, &[]),
        (4, |_| (), Doubtful, &[FewRuns]),
        (2, |_| (), Doubtful, &[FewRuns]),
        (1, |_| (), NotDetermined, &[NotRepeated]),
        (1, |c| c.one.parameters[0].predicted_std = Some(1.0), Doubtful, &[FewRuns]),
        (6, |c| c.one.spread.as_mut().unwrap().cell_share = 0.6, Repeatable, &[]),
        (6, |c| c.one.spread.as_mut().unwrap().cell_share = 0.59, Doubtful, &[SmallRegion]),
        (6, |c| c.one.folds = Some(true), Doubtful, &[Fold]),
        (6, |c| c.one.overlap = Some(overlap(0.95, None)), Doubtful, &[SharedObservations]),
        (6, |c| c.one.prediction = Some(with_birge(1.51, None)), Doubtful, &[Birge]),
        (6, |c| c.one.prediction = Some(with_birge(1.2, Some(1.49))), Repeatable, &[]),
        (6, |c| c.one.prediction = Some(with_birge(1.2, Some(1.51))), Doubtful, &[Birge]),
        // Of so many runs a copy leaves enough.
        (6, |c| c.runs[0].duplicate_of = Some("run1".to_owned()), Repeatable, &[]),
        (6, |c| c.one.held = held(9e-4, 0.51), Doubtful, &[HeldParameter]),
        (6, |c| c.one.held = held(9e-4, 0.49), Repeatable, &[]),
        (6, |c| c.one.held = held(1.1e-3, 9.0), Repeatable, &[]),
        (6, |c| c.one.residuals = residuals(9e-4, 0.11, 1.0), Doubtful, &[ResidualPattern]),
        (6, |c| c.one.residuals = residuals(9e-4, 0.09, 1.0), Repeatable, &[]),
        (6, |c| c.one.residuals = residuals(1.1e-3, 9.0, 1.0), Repeatable, &[]),
        // Sigma knows of points that do not fit: they are said and bear on no verdict.
        (6, |c| c.one.residuals = residuals(9e-4, 0.0, 1.6), Repeatable, &[]),
        (6, |c| c.one.clusters = Some(parts([4, 2])), Doubtful, &[Clusters]),
        (6, |c| c.one.clusters = Some(parts([5, 1])), Doubtful, &[OutlierRun]),
        (6, set_aside, Doubtful, &[OutlierRun]),
        (6, |c| c.one.spread = None, Doubtful, &[NoSpread]),
        (6, |c| lose(c, 1), Doubtful, &[LostRuns]),
        (6, hold, NotDetermined, &[NoEstimate]),
        (
            6,
            |c| c.runs[..3].iter_mut().for_each(|run| run.refinement = Some(open())),
            NotDetermined,
            &[OpenDirection],
        ),
        (6, |c| c.runs[0].refinement = Some(open()), Repeatable, &[]),
        (
            1,
            |c| {
                c.one.parameters[0].predicted_std = Some(1.0);
                c.runs[0].duplicate_of = Some("run0".to_owned());
            },
            Doubtful,
            &[DuplicateRuns, FewRuns],
        ),
    ]
}

#[test]
fn each_cause_alone_gives_its_verdict() {
    let mut seen: Vec<FindingId> = Vec::new();
    for (index, (count, change, kind, want)) in causes().into_iter().enumerate() {
        let verdict = with(count, change);
        assert_eq!(
            (verdict.kind, ids(&verdict)),
            (kind, want.to_vec()),
            "case {index}: {verdict:?}"
        );
        assert!(verdict.reasons.iter().all(|reason| !reason.text.starts_with("camera 1")));
        seen.extend(want);
    }
    let weighs = |id: &FindingId| id.at_best() > VerdictKind::Repeatable;
    let untested: Vec<FindingId> =
        FindingId::all().filter(weighs).filter(|id| !seen.contains(id)).collect();
    assert_eq!(untested, [], "kinds of finding that bear on a verdict and are in no case");
}

#[test]
fn points_that_do_not_fit_are_told_where_there_are_surely_many() {
    let is_told = |p: f64, sigma_ratio: f64| {
        let mut case = case(6);
        case.one.residuals = residuals(p, 0.0, sigma_ratio);
        let findings = remarks::populations(&mut [case.one], &case.runs);
        findings.iter().any(|finding| finding.id == FindingId::HeavyTails)
    };
    assert!(is_told(9e-4, 1.41) && !is_told(9e-4, 1.39) && !is_told(1.1e-3, 1.6));
}

#[test]
fn what_weighs_most_decides_and_is_said_first() {
    let verdict = with(6, |case| {
        case.one.folds = Some(true);
        case.one.overlap = Some(overlap(0.95, None));
        case.runs.iter_mut().for_each(|run| run.refinement = Some(open()));
    });
    assert_eq!(verdict.kind, VerdictKind::NotDetermined);
    let want = [FindingId::OpenDirection, FindingId::SharedObservations, FindingId::Fold];
    assert_eq!(ids(&verdict), want);
}

#[test]
fn what_was_held_has_no_spread_to_repeat_to() {
    let verdict = with(6, hold);
    assert_eq!((verdict.n, verdict.spread_px, verdict.spread_interval_95), (0, None, None));
}
