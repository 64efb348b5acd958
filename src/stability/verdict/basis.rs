//! What a verdict rests on: how many runs, what they determine, how much of the image.

use super::super::remarks::{listed, of_camera};
use super::super::{
    Finding, FindingId, Parameter, Population, RefinedCamera, RunRecord, Sample, SampleState,
};
use crate::stats::std_interval_factors;

/// Below this many runs a box plot and most tests say nothing.
pub(in crate::stability) const FEW_RUNS: usize = 5;
/// A spread over less of the image than this leaves out where calibrations differ most.
pub(in crate::stability) const LEAST_REGION: f64 = 0.6;
/// A direction that this share of the runs leave open is the experiment's; one that fewer do is theirs, and they do not count.
pub(in crate::stability) const OPEN_IN_SHARE: f64 = 0.5;

/// What there is to say of the runs, observations and cells that a population's numbers are from.
pub(in crate::stability) fn of_population(one: &Population, runs: &[RunRecord]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut find = |id, runs, text: String| {
        let text = format!("{}: {text}", one.camera);
        findings.push(of_camera(id, one, runs, text));
    };
    let open = open_directions(one, runs);
    if let Some((open, words)) = &open {
        let text = format!("the observations of {} do not determine {words}", listed(open));
        find(FindingId::OpenDirection, open.clone(), text);
    }
    let n = calibration_count(one);
    let lost = lost_runs(one);
    if !lost.is_empty() && open.is_none_or(|(open, _)| open.len() < lost.len()) {
        let text = format!("{} gave no calibration, as refining it failed there", listed(&lost));
        find(FindingId::LostRuns, lost, text);
    }
    if let Some((id, text)) = few_runs(one, n) {
        find(id, Vec::new(), text);
    }
    let is_copy = |run: &&RunRecord| run.group == one.group && run.duplicate_of.is_some();
    let copies: Vec<String> = runs.iter().filter(is_copy).map(|run| run.run.clone()).collect();
    if n < 2 && !copies.is_empty() {
        let text = format!(
            "{} are copies of other runs: without them there is nothing to compare",
            listed(&copies)
        );
        find(FindingId::DuplicateRuns, copies, text);
    }
    if let Some(spread) = one.spread.as_ref().filter(|spread| spread.cell_share < LEAST_REGION) {
        let percent = 100.0 * spread.cell_share;
        let text = format!(
            "only {percent:.0} % of the image was compared (region {}): how the rest repeats is not known",
            spread.region
        );
        find(FindingId::SmallRegion, Vec::new(), text);
    }
    if one.folds == Some(true) {
        find(FindingId::Fold, Vec::new(), fold(one));
    }
    findings
}

/// Calibrations that estimated a parameter and, where there is a spread, are part of it.
pub(in crate::stability) fn calibration_count(one: &Population) -> usize {
    let is_estimate =
        |sample: &&Sample| matches!(sample.state, SampleState::Estimated | SampleState::Unknown);
    let of_parameter = |p: &Parameter| p.samples.iter().filter(is_estimate).count();
    let estimated = one.parameters.iter().map(of_parameter).max().unwrap_or(0);
    one.spread.as_ref().map_or(estimated, |spread| spread.n.min(estimated))
}

/// The samples of the first parameter: one for each run, or camera of a run, that the population is about.
pub(in crate::stability) fn samples(one: &Population) -> impl Iterator<Item = &Sample> {
    one.parameters.iter().take(1).flat_map(|parameter| &parameter.samples)
}

/// The runs that leave a direction open, when they are many of those that have the camera, and that of the first in words.
fn open_directions(one: &Population, runs: &[RunRecord]) -> Option<(Vec<String>, String)> {
    let cameras: Vec<&Sample> = samples(one).filter(|sample| sample.camera_id.is_some()).collect();
    let mut open: Vec<String> = Vec::new();
    let mut words = None;
    for sample in &cameras {
        let camera = refined_camera(sample, &one.group, runs);
        if let Some(direction) = camera.and_then(|camera| camera.undetermined.first()) {
            open.push(sample.run.clone());
            words = words.or(Some(direction.clone()));
        }
    }
    let is_most = open.len() as f64 >= OPEN_IN_SHARE * cameras.len() as f64;
    words.filter(|_| is_most).map(|words| (open, words))
}

/// The camera of a run's adjustment that a sample is of.
pub(in crate::stability) fn refined_camera<'a>(
    sample: &Sample,
    group: &str,
    runs: &'a [RunRecord],
) -> Option<&'a RefinedCamera> {
    let run = runs.iter().find(|run| run.group == group && run.run == sample.run)?;
    let mut cameras = run.refinement.as_ref()?.adjustment.as_ref()?.cameras.iter();
    cameras.find(|camera| Some(camera.camera_id) == sample.camera_id)
}

/// The runs that have the camera and no calibration of it.
fn lost_runs(one: &Population) -> Vec<String> {
    let is_lost =
        |sample: &&Sample| sample.state == SampleState::Failed && sample.camera_id.is_some();
    samples(one).filter(is_lost).map(|sample| sample.run.clone()).collect()
}

/// What so few runs can tell.
fn few_runs(one: &Population, n: usize) -> Option<(FindingId, String)> {
    let has_covariance = one.parameters.iter().any(|one| one.predicted_std.is_some());
    match n {
        0 => {
            let text = "no parameter was estimated: there is no spread to speak of".to_owned();
            Some((FindingId::NoEstimate, text))
        }
        1 => {
            let id = if has_covariance { FindingId::FewRuns } else { FindingId::NotRepeated };
            let text = format!(
                "one run shows no spread: repeat the reconstruction with other seeds or other images, \
                 at least {FEW_RUNS} times, and give all runs together; or make samples out of it (`calibstab resample`)"
            );
            Some((id, text))
        }
        n if n < FEW_RUNS => {
            let [low, high] = std_interval_factors(n, 0.95)?;
            let [low_10, high_10] = std_interval_factors(10, 0.95)?;
            let text = format!(
                "{n} runs tell little: the true std may be anything from {low:.2} to {high:.2} times the one shown (95 %); \
                 with 10 runs it would be {low_10:.2} to {high_10:.2} times"
            );
            Some((FindingId::FewRuns, text))
        }
        _ => None,
    }
}

fn fold(one: &Population) -> String {
    let percent = 100.0 * (1.0 - one.ray_share.unwrap_or(1.0));
    let rest = match percent > 0.0 {
        true => format!("{percent:.2} % of it has no ray, and std px leaves that out"),
        false => "the outermost corners have no ray".to_owned(),
    };
    format!("the mean of the runs folds inside the image: {rest}")
}
