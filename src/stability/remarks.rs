//! What a reader must be told, in words.

use std::collections::BTreeMap;

use super::screen::Screened;
use super::{Finding, FindingId, Population, Run, SampleState, Skipped};
use crate::stats::std_interval_factors;

/// Below this many runs a box plot and most tests say nothing.
const FEW_RUNS: usize = 5;

pub(super) fn of_group(id: FindingId, group: &str, text: String) -> Finding {
    Finding { id, group: Some(group.to_owned()), camera: None, runs: Vec::new(), text }
}

pub(super) fn skipped(skipped: &[Skipped]) -> Option<Finding> {
    let count = skipped.len();
    let runs = if count == 1 { "1 run".to_owned() } else { format!("{count} runs") };
    let text = format!("{runs} could not be read and was skipped");
    let paths = skipped.iter().map(|skipped| skipped.path.clone()).collect();
    let id = FindingId::SkippedRun;
    (count > 0).then_some(Finding { id, group: None, camera: None, runs: paths, text })
}

pub(super) fn duplicates(runs: &[Run], screened: &[Screened]) -> Vec<Finding> {
    let mut copies: BTreeMap<usize, Vec<&Run>> = BTreeMap::new();
    for (run, screened) in runs.iter().zip(screened) {
        if let Some(original) = screened.duplicate_of {
            copies.entry(original).or_insert(vec![&runs[original]]).push(run);
        }
    }
    let finding = |copies: Vec<&Run>| {
        let names: Vec<String> = copies.iter().map(|run| run.name.clone()).collect();
        let text = format!(
            "{} are the same to the last bit and count once: a copied run, or a repeat with the same seed; \
             no stability can be claimed from them",
            names.join(", ")
        );
        let group = Some(runs[0].group.clone());
        Finding { id: FindingId::DuplicateRuns, group, camera: None, runs: names, text }
    };
    copies.into_values().map(finding).collect()
}

pub(super) fn reading(run: &Run) -> Vec<Finding> {
    let finding = |remark: &String| Finding {
        id: FindingId::Reading,
        group: Some(run.group.clone()),
        camera: None,
        runs: vec![run.name.clone()],
        text: format!("{}: {remark}", run.name),
    };
    run.remarks.iter().map(finding).collect()
}

pub(super) fn unused_cameras(run: &Run) -> Vec<Finding> {
    let finding = |id| Finding {
        id: FindingId::UnusedCamera,
        group: Some(run.group.clone()),
        camera: None,
        runs: vec![run.name.clone()],
        text: format!(
            "{}: its camera {id} took no image: what stands there is no estimate and does not count",
            run.name
        ),
    };
    run.unused_cameras().into_iter().map(finding).collect()
}

/// What the populations show: cameras of several kinds, missing cameras, parameters held now and then, few runs.
pub(super) fn populations(populations: &[Population]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for one in populations {
        findings.extend(missing(one));
        findings.extend(mixed_states(one));
    }
    findings.extend(mixed_cameras(populations));
    findings.extend(few_runs(populations));
    findings
}

fn of_camera(id: FindingId, population: &Population, runs: Vec<String>, text: String) -> Finding {
    let (group, camera) = (Some(population.group.clone()), Some(population.camera.clone()));
    Finding { id, group, camera, runs, text }
}

fn missing(population: &Population) -> Option<Finding> {
    let samples = &population.parameters.first()?.samples;
    let runs: Vec<String> = samples
        .iter()
        .filter(|sample| sample.state == SampleState::Failed)
        .map(|sample| sample.run.clone())
        .collect();
    let text = format!("{} did not reconstruct {}", runs.join(", "), population.camera);
    (!runs.is_empty()).then(|| of_camera(FindingId::MissingCamera, population, runs, text))
}

fn mixed_states(population: &Population) -> Vec<Finding> {
    let mixed = population.parameters.iter().filter_map(|parameter| {
        let of = |state| parameter.samples.iter().filter(move |sample| sample.state == state);
        let held: Vec<String> = of(SampleState::PresumedHeld).map(|sample| sample.run.clone()).collect();
        let estimated = of(SampleState::Estimated).count();
        if held.is_empty() || estimated == 0 {
            return None;
        }
        let text = format!(
            "{}: {} is the same to the last bit in {} and so presumed held there; its statistics are of the {estimated} others",
            population.camera, parameter.name, held.join(", ")
        );
        Some(of_camera(FindingId::MixedStates, population, held, text))
    });
    mixed.collect()
}

fn mixed_cameras(populations: &[Population]) -> Vec<Finding> {
    let mut kinds: BTreeMap<(&str, &str), Vec<&Population>> = BTreeMap::new();
    for one in populations {
        kinds.entry((&one.group, &one.camera)).or_default().push(one);
    }
    let finding = |kinds: &Vec<&Population>| {
        let names: Vec<String> = kinds
            .iter()
            .map(|one| format!("{} {} x {}", one.model, one.width, one.height))
            .collect();
        let text = format!(
            "{} is {} in different runs: separate populations, never mixed",
            kinds[0].camera,
            names.join(" and ")
        );
        of_camera(FindingId::MixedCameras, kinds[0], Vec::new(), text)
    };
    kinds.values().filter(|kinds| kinds.len() > 1).map(finding).collect()
}

/// What the group's runs can tell, when they are few.
fn few_runs(populations: &[Population]) -> Vec<Finding> {
    let mut most: BTreeMap<&str, usize> = BTreeMap::new();
    for one in populations {
        let estimates = |state| matches!(state, SampleState::Estimated | SampleState::Unknown);
        let counts =
            one.parameters.iter().map(|p| p.samples.iter().filter(|s| estimates(s.state)).count());
        let most = most.entry(&one.group).or_default();
        *most = (*most).max(counts.max().unwrap_or(0));
    }
    let finding =
        |(group, n): (&str, usize)| Some(of_group(FindingId::FewRuns, group, few_runs_text(n)?));
    most.into_iter().filter_map(finding).collect()
}

fn few_runs_text(n: usize) -> Option<String> {
    match n {
        0 => Some("no parameter was estimated: there is no spread to speak of".to_owned()),
        1 => Some(format!(
            "one run shows no spread: repeat the reconstruction with other seeds or other images, at least {FEW_RUNS} times, \
             and give all runs together"
        )),
        n if n < FEW_RUNS => {
            let [low, high] = std_interval_factors(n, 0.95)?;
            let [low_10, high_10] = std_interval_factors(10, 0.95)?;
            Some(format!(
                "{n} runs tell little: the true std may be anything from {low:.2} to {high:.2} times the one shown (95 %); \
                 with 10 runs it would be {low_10:.2} to {high_10:.2} times"
            ))
        }
        _ => None,
    }
}
