//! What a reader must be told, in words.

use std::collections::{BTreeMap, BTreeSet};

use super::disagreement::remarks as disagreements;
use super::inside::remarks as inside;
use super::prediction::remarks as prediction;
use super::refinement::clustered;
use super::run::CameraInRun;
use super::screen::Screened;
use super::verdict::{basis, verdict};
use super::{Finding, FindingId, Population, Run, RunRecord, SampleState, Skipped};

pub(super) fn of_group(id: FindingId, group: &str, text: String) -> Finding {
    Finding { id, group: Some(group.to_owned()), camera: None, runs: Vec::new(), text }
}

/// A p-value as text: `p = 3e-77`, and what is beyond telling from none as `p < 1e-99`.
pub fn p_in_words(p: f64) -> String {
    if p < 1e-99 {
        "p < 1e-99".to_owned()
    } else if p < 1e-3 {
        format!("p = {p:.0e}")
    } else {
        format!("p = {p:.3}")
    }
}

pub(super) fn skipped(skipped: &[Skipped]) -> Vec<Finding> {
    let finding = |Skipped { path, reason }: &Skipped| {
        let reason = reason.lines().next().unwrap_or_default();
        let text = format!("{path} was skipped, as it could not be read: {reason}");
        Finding {
            id: FindingId::SkippedRun,
            group: None,
            camera: None,
            runs: vec![path.clone()],
            text,
        }
    };
    skipped.iter().map(finding).collect()
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
            listed(&names)
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

/// COLMAP gives every image a camera of its own unless told otherwise; most users mean one.
pub(super) fn camera_per_image(group: &str, cameras: &[CameraInRun]) -> Option<Finding> {
    let took_one =
        |camera: &CameraInRun| camera.image_names.as_ref().is_some_and(|names| names.len() == 1);
    let is_per_image =
        cameras.iter().all(took_one) && cameras.windows(2).any(|pair| pair[0].run == pair[1].run);
    let text = "each of its cameras took one image: `--pool` takes them for samples of one physical camera";
    is_per_image.then(|| of_group(FindingId::CameraPerImage, group, text.to_owned()))
}

/// What the populations show; each is given its verdict from what there is to say of it.
pub(super) fn populations(populations: &mut [Population], runs: &[RunRecord]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for one in populations.iter_mut() {
        let own = of_population(one, runs);
        one.verdict = verdict(one, &own);
        findings.extend(own);
    }
    let mut groups: BTreeMap<&str, Vec<&Population>> = BTreeMap::new();
    for one in &*populations {
        groups.entry(&one.group).or_default().push(one);
    }
    for (group, populations) in &groups {
        findings.extend(missing(group, populations));
        findings.extend(without_ray(group, populations));
    }
    findings.extend(mixed_cameras(populations));
    findings
}

/// What there is to say of one population. `FindingId::at_best` says which of these kinds bear on its verdict.
fn of_population(one: &Population, runs: &[RunRecord]) -> Vec<Finding> {
    let mut findings = mixed_states(one);
    findings.extend(disagreements::of_population(one));
    findings.extend(prediction::of_population(one));
    findings.extend(clustered::of_population(one, runs));
    findings.extend(inside::of_population(one));
    findings.extend(basis::of_population(one, runs));
    findings
}

pub(super) fn of_camera(
    id: FindingId,
    population: &Population,
    runs: Vec<String>,
    text: String,
) -> Finding {
    let (group, camera) = (Some(population.group.clone()), Some(population.camera.clone()));
    Finding { id, group, camera, runs, text }
}

/// A sentence that lists more cameras than this is not read.
const LISTED: usize = 4;

/// Runs in a sentence: all of a few, the first of many; a finding's `runs` has them all.
pub(super) fn listed(runs: &[String]) -> String {
    const MOST_NAMED: usize = 8;
    if runs.len() <= MOST_NAMED {
        return runs.join(", ");
    }
    format!("{} and {} more", runs[..LISTED].join(", "), runs.len() - LISTED)
}

/// Cameras that some runs of the group lack.
fn missing(group: &str, populations: &[&Population]) -> Option<Finding> {
    let mut cameras: Vec<String> = Vec::new();
    let mut runs: BTreeSet<String> = BTreeSet::new();
    for population in populations {
        let samples = population.parameters.iter().take(1).flat_map(|parameter| &parameter.samples);
        let lacking = samples.filter(|sample| sample.camera_id.is_none());
        let lacking: Vec<String> = lacking.map(|sample| sample.run.clone()).collect();
        if !lacking.is_empty() {
            cameras.push(format!("{} is missing in {}", population.camera, listed(&lacking)));
            runs.extend(lacking);
        }
    }
    let count = cameras.len();
    if count > LISTED {
        cameras.truncate(LISTED);
        cameras.push(format!("{} more cameras are missing in some runs", count - LISTED));
    }
    let id = FindingId::MissingCamera;
    let finding =
        Finding { runs: runs.into_iter().collect(), ..of_group(id, group, cameras.join("; ")) };
    (count > 0).then_some(finding)
}

/// Cameras whose std in px leaves a part of the image out.
fn without_ray(group: &str, populations: &[&Population]) -> Option<Finding> {
    let is_meant = |one: &&&Population| {
        one.folds != Some(true) && one.parameters.iter().any(|p| p.statistics.is_some())
    };
    let mut cameras: Vec<String> = populations
        .iter()
        .filter(is_meant)
        .filter_map(|one| {
            let left_out = one.ray_share.map(|share| 100.0 * (1.0 - share)).filter(|&p| p > 0.0)?;
            Some(format!("{left_out:.2} % of the image of {}, {}", one.camera, one.model))
        })
        .collect();
    let count = cameras.len();
    if count > LISTED {
        cameras.truncate(LISTED);
        cameras.push(format!("a part of {} more", count - LISTED));
    }
    let text = format!(
        "{} has no ray in the mean of the runs: std px leaves it out",
        cameras.join(" and ")
    );
    (count > 0).then(|| of_group(FindingId::NoRay, group, text))
}

fn mixed_states(population: &Population) -> Vec<Finding> {
    let mixed = population.parameters.iter().filter_map(|parameter| {
        let is_held = |state| matches!(state, SampleState::Held | SampleState::PresumedHeld);
        let held = parameter.samples.iter().filter(|sample| is_held(sample.state));
        let of = |state| parameter.samples.iter().filter(move |sample| sample.state == state);
        let is_certain = of(SampleState::Held).count() > 0;
        let held: Vec<String> = held.map(|sample| sample.run.clone()).collect();
        let estimated = of(SampleState::Estimated).count();
        if held.is_empty() || estimated == 0 {
            return None;
        }
        let runs = listed(&held);
        let how = match is_certain {
            true => format!("was held in {runs} by the refinement"),
            false => format!("is the same to the last bit in {runs} and so presumed held there"),
        };
        let text = format!(
            "{}: {} {how}; its statistics are of the {estimated} others",
            population.camera, parameter.name
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
