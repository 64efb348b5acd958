//! From runs to an analysis.

use super::between::comparisons;
use super::components::components;
use super::group::Group;
use super::identity::MatchError;
use super::populations::populations;
use super::remarks;
use super::{Analysis, Finding, Options, Provenance, Run, RunRecord, SCHEMA_VERSION, Skipped};

/// Analyses runs: how repeatable the parameters of each camera are within each group.
pub fn analyze(
    mut runs: Vec<Run>,
    skipped: Vec<Skipped>,
    options: Options,
) -> Result<Analysis, MatchError> {
    runs.sort_by(|a, b| {
        natord::compare(&a.group, &b.group).then(natord::compare(&a.name, &b.name))
    });
    let groups = runs
        .chunk_by(|a, b| a.group == b.group)
        .map(|runs| Group::new(runs, &options))
        .collect::<Result<Vec<_>, _>>()?;
    let (mut populations, same_cameras) = populations(&groups);
    let mut findings: Vec<Finding> = groups.iter().flat_map(Group::findings).collect();
    findings.extend(remarks::skipped(&skipped));
    let runs: Vec<RunRecord> = groups.iter().flat_map(Group::records).collect();
    findings.extend(remarks::populations(&mut populations, &runs));
    findings.sort_by_key(|finding| finding.id);
    Ok(Analysis {
        schema_version: SCHEMA_VERSION,
        provenance: Provenance { calibstab_version: env!("CARGO_PKG_VERSION").to_owned(), options },
        runs,
        skipped,
        comparisons: comparisons(&populations, &same_cameras),
        components: components(&populations),
        populations,
        findings,
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{run, simple_radial, with_images};
    use super::super::{FindingId, MatchRule, SampleState, Statistics};
    use super::*;

    fn analysis(runs: Vec<Run>) -> Analysis {
        analyze(runs, vec![], Options::default()).unwrap()
    }

    fn statistics<'a>(analysis: &'a Analysis, parameter: &str) -> &'a Statistics {
        let parameters = analysis.populations.iter().flat_map(|one| &one.parameters);
        let mut found = parameters.filter(|one| one.name == parameter);
        found.next().unwrap().statistics.as_ref().unwrap()
    }

    fn ids(analysis: &Analysis) -> Vec<FindingId> {
        analysis.findings.iter().map(|finding| finding.id).collect()
    }

    const VALUES: [[f64; 2]; 4] =
        [[1000.5, -0.25], [1001.5, -0.26], [1003.5, -0.29], [1002.0, -0.2]];

    #[test]
    fn neither_order_nor_names_of_runs_change_a_bit() {
        let plain = analysis(simple_radial("g", &VALUES));
        let mut turned = VALUES;
        turned.reverse();
        turned.swap(0, 2);
        let other = analysis(simple_radial("another", &turned));
        for name in ["f", "k"] {
            let bits = |analysis: &Analysis| {
                let s = statistics(analysis, name);
                [s.mean, s.std, s.q1, s.median, s.q3, s.mad_std, s.std_interval_95[1]]
                    .map(f64::to_bits)
            };
            assert_eq!(bits(&plain), bits(&other), "{name}");
        }
        let correlation = |analysis: &Analysis| {
            analysis.populations[0].compensation[0].correlation.map(f64::to_bits)
        };
        assert_eq!(correlation(&plain), correlation(&other));
    }

    #[test]
    fn a_principal_point_at_the_centre_is_held_and_has_no_statistics() {
        let analysis = analysis(simple_radial("g", &VALUES));
        let cx = &analysis.populations[0].parameters[1];
        assert_eq!((cx.name.as_str(), cx.statistics.is_none()), ("cx", true));
        assert!(cx.samples.iter().all(|sample| sample.state == SampleState::PresumedHeld));
    }

    #[test]
    fn copies_of_a_run_count_once_and_are_reported() {
        let [a, b] = [VALUES[0], VALUES[1]];
        let analysis = analysis(simple_radial("g", &[a, b, a, a]));
        assert_eq!(statistics(&analysis, "f").n, 2);
        let duplicate_of: Vec<Option<&str>> =
            analysis.runs.iter().map(|run| run.duplicate_of.as_deref()).collect();
        assert_eq!(duplicate_of, [None, None, Some("run1"), Some("run1")]);
        assert!(ids(&analysis).contains(&FindingId::DuplicateRuns));
    }

    #[test]
    fn equal_cameras_of_unequal_reconstructions_are_held_and_no_copies() {
        let one = run("g", "a", &[(1, "SIMPLE_RADIAL", &[1000.0, 640.0, 480.0, 0.1])]);
        let two = Run { name: "b".to_owned(), ..one.clone() };
        let runs = vec![
            with_images(one, &[(1, &["1.jpg", "2.jpg"])]),
            with_images(two, &[(1, &["2.jpg"])]),
        ];
        let analysis = analysis(runs);
        assert!(!ids(&analysis).contains(&FindingId::DuplicateRuns));
        let parameters = &analysis.populations[0].parameters;
        assert!(parameters.iter().all(|one| one.statistics.is_none()));
        assert!(parameters.iter().all(|one| one.samples[0].state == SampleState::PresumedHeld));
    }

    #[test]
    fn a_flagged_run_stays_in_unless_it_is_excluded() {
        let runs = simple_radial("g", &[[1000.5, -0.25], [1001.5, -0.26], [100_000.0, -0.29]]);
        let kept = analysis(runs.clone());
        assert_eq!(statistics(&kept, "f").n, 3);
        assert_eq!(kept.runs[2].flags, [FindingId::BogusCamera]);
        let options = Options { exclude_flagged: true, ..Options::default() };
        let without = analyze(runs, vec![], options).unwrap();
        assert_eq!(statistics(&without, "f").n, 2);
        assert!(!without.runs[2].is_used);
        assert!(without.findings.iter().any(|finding| finding.text.ends_with("it is left out")));
    }

    const FISHEYE: [f64; 4] = [500.0, 640.0, 480.0, 0.01];
    const RADIAL: [f64; 4] = [900.0, 640.0, 480.0, 0.02];

    /// Two runs of two cameras; in the second the ids are swapped and the values grew by 1.
    fn swapped(first: [&[&str]; 2], second: [&[&str]; 2]) -> Vec<Run> {
        let moved = |params: [f64; 4]| [params[0] + 1.0, 640.0, 480.0, params[3] + 0.001];
        let cameras: [(u32, &str, &[f64]); 2] =
            [(1, "SIMPLE_RADIAL", &RADIAL), (2, "SIMPLE_RADIAL", &FISHEYE)];
        let (radial, fisheye) = (moved(RADIAL), moved(FISHEYE));
        let turned: [(u32, &str, &[f64]); 2] =
            [(2, "SIMPLE_RADIAL", &radial), (1, "SIMPLE_RADIAL", &fisheye)];
        vec![
            with_images(run("g", "a", &cameras), &[(1, first[0]), (2, first[1])]),
            with_images(run("g", "b", &turned), &[(2, second[0]), (1, second[1])]),
        ]
    }

    #[test]
    fn cameras_are_matched_by_their_images_and_not_by_their_ids() {
        let shared = swapped(
            [&["l1.jpg", "l2.jpg"], &["r1.jpg", "r2.jpg"]],
            [&["l2.jpg", "l3.jpg"], &["r2.jpg", "r3.jpg"]],
        );
        let folders =
            swapped([&["l/1.jpg", "l/2.jpg"], &["r/1.jpg"]], [&["l/7.jpg"], &["r/7.jpg"]]);
        let patterns =
            swapped([&["1_cam0.jpg"], &["1_cam1.jpg"]], [&["7_cam0.jpg"], &["7_cam1.jpg"]]);
        for (runs, rule) in [(shared, "share"), (folders, "folder"), (patterns, "pattern")] {
            let analysis = analysis(runs);
            let stds: Vec<f64> = analysis
                .populations
                .iter()
                .map(|one| one.parameters[0].statistics.as_ref().unwrap().std)
                .collect();
            assert_eq!(stds.len(), 2, "{rule}");
            assert!(
                stds.iter().all(|std| (std - 0.5_f64.sqrt()).abs() < 1e-12),
                "{rule}: {stds:?}"
            );
            let text = analysis.findings.iter().find(|f| f.id == FindingId::CameraMatch);
            assert!(text.unwrap().text.contains(rule), "{rule}");
        }
    }

    #[test]
    fn a_tie_is_an_error_that_names_the_option() {
        let runs = swapped(
            [&["1.jpg", "2.jpg"], &["3.jpg", "4.jpg"]],
            [&["1.jpg", "3.jpg"], &["2.jpg", "4.jpg"]],
        );
        let error = analyze(runs.clone(), vec![], Options::default()).unwrap_err();
        assert!(matches!(error, MatchError::Tie { shared: 1, .. }), "{error:?}");
        assert!(error.to_string().contains("--match id"), "{error}");
        let by_id = Options { match_by: Some(MatchRule::Id), ..Options::default() };
        assert!(analyze(runs, vec![], by_id).is_ok());
    }

    #[test]
    fn a_rule_that_was_asked_for_and_cannot_decide_is_an_error() {
        let runs = swapped([&["a.jpg"], &["b1.jpg"]], [&["c_2.jpg"], &["9.jpg"]]);
        let asked = |rule| {
            let options = Options { match_by: Some(rule), ..Options::default() };
            analyze(runs.clone(), vec![], options).unwrap_err()
        };
        assert!(matches!(asked(MatchRule::Images), MatchError::NoCommonImages { .. }));
        assert!(matches!(asked(MatchRule::Single), MatchError::NotSingle { count: 2, .. }));
        assert_eq!(analysis(runs.clone()).populations.len(), 2);
    }

    #[test]
    fn one_camera_that_took_what_two_did_is_an_error_within_a_group() {
        let names: &[&str] = &["1.jpg", "2.jpg", "3.jpg", "4.jpg"];
        let mut runs =
            swapped([&["1.jpg", "2.jpg"], &["3.jpg", "4.jpg"]], [&["1.jpg"], &["3.jpg"]]);
        runs.truncate(1);
        runs.push(with_images(run("g", "z", &[(1, "SIMPLE_RADIAL", &RADIAL)]), &[(1, names)]));
        let error = analyze(runs, vec![], Options::default()).unwrap_err();
        assert!(matches!(error, MatchError::Tie { shared: 2, .. }), "{error:?}");
    }

    #[test]
    fn most_shared_images_win_over_a_stray_one() {
        let runs = swapped(
            [&["l1.jpg", "l2.jpg", "l3.jpg"], &["r1.jpg", "r2.jpg"]],
            [&["l1.jpg", "l2.jpg"], &["r1.jpg", "r2.jpg", "l3.jpg"]],
        );
        let analysis = analysis(runs);
        assert!((statistics(&analysis, "f").std - 0.5_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn pooled_cameras_of_one_run_are_samples_of_one_camera() {
        let runs = swapped([&["1.jpg"], &["2.jpg"]], [&["1.jpg"], &["2.jpg"]]);
        let options = Options { pool: true, ..Options::default() };
        let analysis = analyze(runs, vec![], options).unwrap();
        assert_eq!(analysis.populations.len(), 1);
        assert_eq!(statistics(&analysis, "f").n, 4);
    }

    #[test]
    fn a_run_without_a_camera_is_a_failed_sample_of_it() {
        let mut runs = swapped([&["1.jpg"], &["2.jpg"]], [&["1.jpg"], &["2.jpg"]]);
        runs.push(with_images(
            run("g", "c", &[(1, "SIMPLE_RADIAL", &[904.0, 640.0, 480.0, 0.5])]),
            &[(1, &["1.jpg"])],
        ));
        let analysis = analysis(runs);
        let states: Vec<SampleState> = analysis.populations[1].parameters[0]
            .samples
            .iter()
            .map(|sample| sample.state)
            .collect();
        let estimated = SampleState::Estimated;
        assert_eq!(states, [estimated, estimated, SampleState::Failed]);
        assert!(ids(&analysis).contains(&FindingId::MissingCamera));
    }

    #[test]
    fn different_models_of_one_camera_are_never_mixed() {
        let mut runs = simple_radial("g", &VALUES);
        runs.push(run("g", "x", &[(1, "SIMPLE_PINHOLE", &[1000.0, 640.0, 480.0])]));
        let analysis = analysis(runs);
        let kinds: Vec<(&str, usize)> = analysis
            .populations
            .iter()
            .map(|one| (one.model.as_str(), one.parameters[0].samples.len()))
            .collect();
        assert_eq!(kinds, [("SIMPLE_PINHOLE", 1), ("SIMPLE_RADIAL", 4)]);
        assert!(ids(&analysis).contains(&FindingId::MixedCameras));
    }

    #[test]
    fn nothing_gives_an_empty_analysis() {
        assert!(analysis(vec![]).populations.is_empty());
    }
}
