use super::super::spread::Region;
use super::super::testing::{run, with_images};
use super::super::{Analysis, FindingId, Options, RefinementOptions, Run, SampleState, analyze};
use crate::bundle::{
    BundleError, CameraOutcome, Covariance, Dropped, FreeParam, OpenDirection, Outcome,
};
use crate::camera::Model;
use crate::least_squares::Reason;
use crate::scene::{Camera, CameraId};

/// A run, with an image that no other has, of one SIMPLE_RADIAL camera that COLMAP left at f = 1000, and its refinement to these values, f and k free.
fn refined(name: &str, [f, k]: [f64; 2], covariance: Option<Covariance>) -> Run {
    let left = [1000.0, 640.0, 480.0, 0.01];
    let run = with_images(run("g", name, &[(1, "SIMPLE_RADIAL", &left)]), &[(1, &["1.jpg", name])]);
    let before = run.scene.cameras[&CameraId(1)];
    let intrinsics = Model::named("SIMPLE_RADIAL").unwrap().with_params(&[f, 640.0, 480.0, k]);
    let after = Camera { intrinsics: intrinsics.unwrap(), ..before };
    let camera = CameraOutcome {
        at_bound: Vec::new(),
        id: CameraId(1),
        before,
        after,
        free: vec![0, 3],
        images: 1,
        implausible: None,
    };
    let outcome = Outcome {
        reason: Reason::Converged,
        initial_cost: 2.0,
        cost: 1.0,
        iterations: 3,
        images: 1,
        points: 9,
        observations: 9,
        dropped: Dropped::default(),
        components: 1,
        unknowns: 10,
        rank: 10,
        sigma_px: Some(0.5),
        cameras: vec![camera],
        covariance,
        rigs_dissolved: false,
    };
    Run { refinement: Some(Ok(outcome)), ..run }
}

/// The covariance of f and k.
fn covariance(matrix: Option<[[f64; 2]; 2]>, open: &[(usize, f64)]) -> Option<Covariance> {
    let param = |place, name| FreeParam { camera: CameraId(1), place, name };
    let open = match open {
        [] => vec![],
        changes => vec![OpenDirection { changes: changes.to_vec() }],
    };
    let matrix = matrix.map(|rows| rows.map(|row| row.to_vec()).to_vec());
    Some(Covariance { params: vec![param(0, "f"), param(3, "k")], matrix, open })
}

fn three_runs() -> Vec<Run> {
    let values = [[1001.0, 0.02], [1003.0, 0.03], [1008.0, 0.01]];
    let matrices =
        [[[4.0, -0.01], [-0.01, 1e-4]], [[9.0, 0.0], [0.0, 1e-4]], [[5.0, -0.02], [-0.02, 1e-4]]];
    let runs = values.into_iter().zip(matrices).zip(["a", "b", "c"]);
    runs.map(|((values, matrix), name)| refined(name, values, covariance(Some(matrix), &[])))
        .collect()
}

fn analysis(runs: Vec<Run>) -> Analysis {
    let refinement = RefinementOptions {
        mode: "self-calibration".to_owned(),
        refine: vec!["focal".to_owned(), "extra".to_owned()],
        priors: Vec::new(),
        bounds: Vec::new(),
        loss: "squared".to_owned(),
        stop: "decrement".to_owned(),
    };
    analyze(
        runs,
        vec![],
        Options { refinement: Some(refinement), region: Some(Region::All), ..Options::default() },
    )
    .unwrap()
}

fn states(analysis: &Analysis, parameter: usize) -> Vec<SampleState> {
    let samples = &analysis.populations[0].parameters[parameter].samples;
    samples.iter().map(|sample| sample.state).collect()
}

fn told(analysis: &Analysis, id: FindingId) -> Vec<&str> {
    let findings = analysis.findings.iter().filter(|finding| finding.id == id);
    findings.map(|finding| finding.text.as_str()).collect()
}

#[test]
fn what_the_adjustment_held_is_held_and_what_it_moved_is_estimated() {
    let analysis = analysis(three_runs());
    // As COLMAP left them the runs are equal, and all of it would be presumed held.
    let left = &analysis.populations[0].as_left.as_ref().unwrap().parameters[0];
    assert!(left.samples.iter().all(|sample| sample.state == SampleState::PresumedHeld));
    assert_eq!(states(&analysis, 0), [SampleState::Estimated; 3]);
    assert_eq!(states(&analysis, 1), [SampleState::Held; 3]);
    let statistics = analysis.populations[0].parameters[0].statistics.as_ref().unwrap();
    assert!((statistics.mean - 1004.0).abs() < 1e-12, "{statistics:?}");
    assert!((statistics.std - 13.0_f64.sqrt()).abs() < 1e-12, "{statistics:?}");
}

#[test]
fn one_refined_run_is_an_estimate_with_a_predicted_std() {
    let analysis = analysis(three_runs().into_iter().take(1).collect());
    assert_eq!(states(&analysis, 0), [SampleState::Estimated]);
    let f = &analysis.populations[0].parameters[0];
    assert!(f.statistics.is_none());
    assert_eq!((f.samples[0].predicted_std, f.predicted_std), (Some(2.0), Some(2.0)));
}

#[test]
fn predictions_are_those_of_the_mean_covariance() {
    let analysis = analysis(three_runs());
    let population = &analysis.populations[0];
    let [f, cx, _, k] = &population.parameters[..] else { panic!("four parameters") };
    // The mean of 4, 9 and 5, and of -0.01, 0 and -0.02.
    assert!((f.predicted_std.unwrap() - 6.0_f64.sqrt()).abs() < 1e-12);
    assert!((k.predicted_std.unwrap() - 0.01).abs() < 1e-14);
    assert_eq!(cx.predicted_std, None);
    let correlations = population.predicted_correlations.as_ref().unwrap();
    assert_eq!(correlations.parameters, ["f", "k"]);
    let both = correlations.matrix[1][0].unwrap();
    assert!((both - -0.01 / (6.0_f64 * 1e-4).sqrt()).abs() < 1e-12, "{both}");
}

#[test]
fn a_camera_that_the_observations_do_not_determine_is_no_sample() {
    let mut runs = three_runs();
    runs.push(refined("d", [7000.0, 0.5], covariance(None, &[(0, 1.0), (1, -2e-4)])));
    let analysis = analysis(runs);
    assert_eq!(states(&analysis, 0)[3], SampleState::Failed);
    assert_eq!(states(&analysis, 1)[3], SampleState::Failed);
    assert_eq!(analysis.populations[0].parameters[0].statistics.as_ref().unwrap().n, 3);
    let told = told(&analysis, FindingId::RefinementFailed);
    let want = "d: camera 1 was not refined: the observations do not determine f +1 with k -0.0002; no sample";
    assert_eq!(told, [want]);
    // The others are what they would be without it.
    let without = self::analysis(three_runs());
    let spread = |analysis: &Analysis| analysis.populations[0].spread.as_ref().unwrap().raw.rms_px;
    assert_eq!(spread(&analysis).to_bits(), spread(&without).to_bits());
}

#[test]
fn runs_that_fail_for_one_reason_are_named_together_and_keep_what_colmap_left() {
    let mut runs = three_runs();
    for run in &mut runs[1..] {
        run.refinement = Some(Err(BundleError::NoCost));
    }
    let analysis = analysis(runs);
    let (estimated, failed) = (SampleState::Estimated, SampleState::Failed);
    assert_eq!(states(&analysis, 3), [estimated, failed, failed]);
    let told = told(&analysis, FindingId::RefinementFailed);
    assert!(told.len() == 1 && told[0].starts_with("b, c: refining failed: "), "{told:?}");
    let left = &analysis.populations[0].as_left.as_ref().unwrap().parameters[0].samples;
    assert_eq!(left[2].value, Some(1000.0));
    let record = analysis.runs[1].refinement.as_ref().unwrap();
    assert!(record.failure.is_some() && record.adjustment.is_none());
}

#[test]
fn out_of_steps_or_stuck_is_failed_and_rounding_is_not() {
    for (reason, state) in [
        (Reason::Converged, SampleState::Estimated),
        (Reason::Rounding, SampleState::Estimated),
        (Reason::IterationLimit, SampleState::Failed),
        (Reason::Stuck, SampleState::Failed),
    ] {
        let mut runs = three_runs();
        if let Some(Ok(outcome)) = &mut runs[0].refinement {
            outcome.reason = reason;
        }
        assert_eq!(states(&analysis(runs), 0)[0], state, "{reason:?}");
    }
}

#[test]
fn refined_and_unrefined_runs_are_never_mixed() {
    let mut runs = three_runs();
    runs[1].refinement = None;
    let analysis = analysis(runs);
    assert!(analysis.populations[0].as_left.is_none());
    assert_eq!(states(&analysis, 0), [SampleState::PresumedHeld; 3]);
}
