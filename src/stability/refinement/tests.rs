use super::super::{Analysis, FindingId, Run, SampleState};
use super::testing::{analysis, covariance, refined};
use crate::bundle::BundleError;
use crate::least_squares::Reason;

fn three_runs() -> Vec<Run> {
    let values = [[1001.0, 0.02], [1003.0, 0.03], [1008.0, 0.01]];
    let matrices =
        [[[4.0, -0.01], [-0.01, 1e-4]], [[9.0, 0.0], [0.0, 1e-4]], [[5.0, -0.02], [-0.02, 1e-4]]];
    let runs = values.into_iter().zip(matrices).zip(["a", "b", "c"]);
    runs.map(|((values, matrix), name)| refined(name, values, covariance(Some(matrix), &[])))
        .collect()
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
