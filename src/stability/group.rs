//! One group: its runs, which of them count, and which of their cameras are the same.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::identity::{DecidedBy, MatchError, match_cameras};
use super::run::CameraInRun;
use super::screen::{Screened, image_count, screen};
use super::spread::{Region, View};
use super::view::views;
use super::{Finding, FindingId, Options, RefinementOptions, Run, RunRecord, refinement, remarks};
use crate::scene::CameraId;

/// The runs of one group with what was found out about them.
pub(super) struct Group<'a> {
    pub runs: &'a [Run],
    cameras: Vec<CameraInRun<'a>>,
    screened: Vec<Screened>,
    pub is_used: Vec<bool>,
    /// Whether all of the runs were refined.
    pub is_refined: bool,
    refinement: Option<&'a RefinementOptions>,
    /// The class of each camera that is used; runs that are not used have none.
    class: BTreeMap<(usize, u32), usize>,
    decided_by: Option<DecidedBy>,
    /// What each camera observed.
    pub views: BTreeMap<(&'a str, CameraId), View>,
    pub region: Option<Region>,
}

impl<'a> Group<'a> {
    pub(super) fn new(runs: &'a [Run], options: &'a Options) -> Result<Self, MatchError> {
        // All or none: a population never mixes refined values with those that COLMAP left.
        let is_refined = runs.iter().all(|run| run.refinement.is_some());
        let of_run = |(index, run): (usize, &'a Run)| {
            if is_refined { run.refined_cameras(index) } else { run.cameras(index) }
        };
        let cameras: Vec<CameraInRun> = runs.iter().enumerate().flat_map(of_run).collect();
        let screened = screen(runs, &cameras);
        let is_used: Vec<bool> = screened
            .iter()
            .map(|screened| {
                let is_excluded = options.exclude_flagged && !screened.findings.is_empty();
                screened.duplicate_of.is_none() && !is_excluded
            })
            .collect();
        let used: Vec<CameraInRun> =
            cameras.iter().filter(|camera| is_used[camera.run]).cloned().collect();
        let matched = match_cameras(runs, &used, options.match_by, options.pool)?;
        let class = used
            .iter()
            .enumerate()
            .map(|(index, camera)| ((camera.run, camera.id.0), matched.classes.class(index)))
            .collect();
        let of_run = |run: &'a Run| {
            views(&run.scene).into_iter().map(|(camera, view)| ((run.name.as_str(), camera), view))
        };
        let seen: Vec<Vec<_>> = runs.par_iter().map(|run| of_run(run).collect()).collect();
        let views = seen.into_iter().flatten().collect();
        let (decided_by, region) = (matched.by, options.region);
        let (cameras, refinement) = (used, options.refinement.as_ref());
        Ok(Self {
            runs,
            cameras,
            screened,
            is_used,
            is_refined,
            refinement,
            class,
            decided_by,
            views,
            region,
        })
    }

    /// The names of runs that are suspect.
    pub(super) fn flagged(&self) -> BTreeSet<&'a str> {
        let runs = self.runs.iter().zip(&self.screened);
        runs.filter(|(_, s)| !s.findings.is_empty()).map(|(run, _)| run.name.as_str()).collect()
    }

    /// The group's physical cameras: the cameras of its runs, by class.
    pub(super) fn by_class(&self) -> BTreeMap<usize, Vec<&CameraInRun<'a>>> {
        let mut by_class: BTreeMap<usize, Vec<&CameraInRun>> = BTreeMap::new();
        for camera in &self.cameras {
            by_class.entry(self.class[&(camera.run, camera.id.0)]).or_default().push(camera);
        }
        by_class
    }

    pub(super) fn records(&self) -> Vec<RunRecord> {
        let record = |(index, run): (usize, &Run)| {
            let geometry = run.scene.geometry.as_ref();
            let flags: BTreeSet<FindingId> =
                self.screened[index].findings.iter().map(|finding| finding.id).collect();
            RunRecord {
                group: run.group.clone(),
                run: run.name.clone(),
                files: run.files.clone(),
                image_count: image_count(run),
                point_count: geometry.map(|geometry| geometry.points.len()),
                observation_count: geometry.map(|geometry| geometry.points.observation_count()),
                duplicate_of: self.screened[index]
                    .duplicate_of
                    .map(|of| self.runs[of].name.clone()),
                flags: flags.into_iter().collect(),
                is_used: self.is_used[index],
                refinement: refinement::record(run),
            }
        };
        self.runs.iter().enumerate().map(record).collect()
    }

    pub(super) fn findings(&self) -> Vec<Finding> {
        let group = &self.runs[0].group;
        let mut findings: Vec<Finding> =
            self.screened.iter().flat_map(|screened| screened.findings.clone()).collect();
        for finding in &mut findings {
            let is_used = self
                .runs
                .iter()
                .zip(&self.is_used)
                .any(|(run, is_used)| *is_used && finding.runs.contains(&run.name));
            finding.text.push_str(if is_used { "; it stays in" } else { "; it is left out" });
        }
        if let Some(how) = self.refinement {
            findings.extend(refinement::remarks::of_runs(self.runs, how));
        }
        findings.extend(remarks::duplicates(self.runs, &self.screened));
        findings.extend(self.runs.iter().flat_map(remarks::reading));
        findings.extend(self.runs.iter().flat_map(remarks::unused_cameras));
        if self.decided_by != Some(DecidedBy::Pool) {
            findings.extend(remarks::camera_per_image(group, &self.cameras));
        }
        if let Some(by) = self.decided_by {
            let text = format!("cameras of different runs were matched by {by}");
            findings.push(remarks::of_group(FindingId::CameraMatch, group, text));
        }
        findings
    }
}
