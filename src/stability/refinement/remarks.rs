//! What is to be said of the adjustments of a group's runs.

use std::collections::BTreeMap;

use super::super::remarks::of_group;
use super::super::{Finding, FindingId, Run};
use super::apply::{failure_of_camera, failure_of_run};
use super::{Refined, RefinementOptions};
use crate::bundle::Outcome;

/// Everything that refining these runs of one group calls for; they were to be refined so.
pub(in crate::stability) fn of_runs(runs: &[Run], how: &RefinementOptions) -> Vec<Finding> {
    if runs.iter().any(|run| run.refinement.is_none()) {
        return not_refined(runs).into_iter().collect();
    }
    let mut findings = vec![refined(runs, how)];
    findings.extend(failures(runs));
    findings.extend(left_out(runs));
    findings
}

/// Runs that cannot be refined keep the others of their group from it: two kinds of values are never mixed.
fn not_refined(runs: &[Run]) -> Option<Finding> {
    let lacking = || runs.iter().filter(|run| !run.is_refinable());
    if [0, runs.len()].contains(&lacking().count()) {
        return None;
    }
    let text = format!(
        "none of its runs was refined, as there are no images and points in {}: all are as COLMAP left them",
        listed(lacking())
    );
    let names = lacking().map(|run| run.name.clone()).collect();
    Some(Finding { runs: names, ..of_group(FindingId::NotRefined, &runs[0].group, text) })
}

fn outcomes(runs: &[Run]) -> impl Iterator<Item = (&Run, &Outcome)> {
    runs.iter().filter_map(|run| Some((run, run.refinement.as_ref()?.as_ref().ok()?)))
}

fn refined(runs: &[Run], how: &RefinementOptions) -> Finding {
    let is_done = |result: &Refined| failure_of_run(result).is_none();
    let done = runs.iter().filter(|run| run.refinement.as_ref().is_some_and(is_done));
    let sigmas = outcomes(runs).filter_map(|(_, outcome)| outcome.sigma_px);
    let [low, high] = sigmas
        .fold([f64::INFINITY, 0.0_f64], |[low, high], sigma| [low.min(sigma), high.max(sigma)]);
    let noise = match how.loss == "squared" && low <= high {
        true => format!("; noise of a coordinate {low:.3} to {high:.3} px"),
        false => String::new(),
    };
    let RefinementOptions { mode, refine, loss, .. } = how;
    let text = format!(
        "{} of {} runs were refined: {mode} with {} free, {loss} loss{noise}",
        done.count(),
        runs.len(),
        refine.join(", "),
    );
    of_group(FindingId::Refinement, &runs[0].group, text)
}

/// Runs and cameras that refining came to nothing for, those of one reason together.
fn failures(runs: &[Run]) -> Vec<Finding> {
    let mut by_reason: BTreeMap<String, Vec<&Run>> = BTreeMap::new();
    for run in runs {
        let Some(result) = &run.refinement else { continue };
        if let Some(why) = failure_of_run(result) {
            by_reason.entry(format!("refining failed: {why}")).or_default().push(run);
            continue;
        }
        let cameras = result.iter().flat_map(|outcome| {
            let used = run.cameras(0).into_iter().map(|camera| camera.id).collect::<Vec<_>>();
            let of_run = outcome.cameras.iter().filter(move |camera| used.contains(&camera.id));
            of_run.filter_map(|camera| Some((camera.id, failure_of_camera(outcome, camera)?)))
        });
        for (id, why) in cameras {
            by_reason.entry(format!("camera {id} was not refined: {why}")).or_default().push(run);
        }
    }
    let finding = |(why, runs): (String, Vec<&Run>)| {
        let text = format!("{}: {why}; no sample", listed(runs.iter().copied()));
        let names = runs.iter().map(|run| run.name.clone()).collect();
        let group = &runs[0].group;
        Finding { runs: names, ..of_group(FindingId::RefinementFailed, group, text) }
    };
    by_reason.into_iter().map(finding).collect()
}

/// What did not take part, and what hangs together by nothing.
fn left_out(runs: &[Run]) -> Vec<Finding> {
    type Count = fn(&Outcome) -> usize;
    let kinds: [(Count, &str); 5] = [
        (
            |outcome| outcome.dropped.unprojectable,
            "observations cannot be projected at the start and were left out of the adjustment",
        ),
        (
            |outcome| outcome.dropped.lone_points,
            "points are seen by fewer than two images and were left out of the adjustment",
        ),
        (
            |outcome| outcome.components.saturating_sub(1),
            "parts share no point with the rest: their places, directions and sizes are unrelated",
        ),
        (
            |outcome| {
                let open = outcome.covariance.as_ref().map_or(0, |found| found.open.len());
                outcome.unknowns.saturating_sub(outcome.rank + open)
            },
            "unknowns of poses or points are not determined",
        ),
        (
            |outcome| if outcome.rigs_dissolved { outcome.images } else { 0 },
            "images of rigs moved freely: the rigs did not bind them",
        ),
    ];
    let finding = |(count, what): (Count, &str)| {
        let concerned: Vec<(&Run, usize)> = outcomes(runs)
            .map(|(run, outcome)| (run, count(outcome)))
            .filter(|(_, count)| *count > 0)
            .collect();
        let total: usize = concerned.iter().map(|(_, count)| count).sum();
        let text = format!("{total} {what} ({})", listed(concerned.iter().map(|(run, _)| *run)));
        let names = concerned.iter().map(|(run, _)| run.name.clone()).collect();
        (total > 0).then(|| {
            let group = &runs[0].group;
            Finding { runs: names, ..of_group(FindingId::Refinement, group, text) }
        })
    };
    kinds.into_iter().filter_map(finding).collect()
}

/// The names of runs; of many the first ones and how many more there are.
fn listed<'a>(runs: impl Iterator<Item = &'a Run>) -> String {
    /// A sentence with more is not read.
    const NAMED: usize = 6;
    let mut names: Vec<String> = runs.map(|run| run.name.clone()).collect();
    let more = names.len().saturating_sub(NAMED);
    if more > 0 {
        names.truncate(NAMED);
        names.push(format!("{more} more"));
    }
    names.join(", ")
}
