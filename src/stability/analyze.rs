//! From runs to an analysis.

use std::collections::BTreeMap;

use super::identity::{DecidedBy, MatchError, match_cameras};
use super::physical::{CameraOfGroup, labels, physical_cameras};
use super::remarks;
use super::run::CameraInRun;
use super::screen::{Screened, image_count, screen};
use super::summary::{Place, compensation, parameters};
use super::{Analysis, Finding, FindingId, Options, Population, Provenance, Run, RunRecord};
use super::{SCHEMA_VERSION, Skipped};
use crate::camera::Model;

/// The runs of one group with what was found out about them.
struct Group<'a> {
    runs: &'a [Run],
    cameras: Vec<CameraInRun<'a>>,
    screened: Vec<Screened>,
    is_used: Vec<bool>,
    /// The class of each camera that is used; runs that are not used have none.
    class: BTreeMap<(usize, u32), usize>,
    decided_by: Option<DecidedBy>,
}

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
    let populations = populations(&groups);
    let mut findings: Vec<Finding> = groups.iter().flat_map(Group::findings).collect();
    findings.extend(remarks::skipped(&skipped));
    findings.extend(remarks::populations(&populations));
    findings.sort_by_key(|finding| finding.id);
    Ok(Analysis {
        schema_version: SCHEMA_VERSION,
        provenance: Provenance { calibstab_version: env!("CARGO_PKG_VERSION").to_owned(), options },
        runs: groups.iter().flat_map(Group::records).collect(),
        skipped,
        populations,
        findings,
    })
}

impl<'a> Group<'a> {
    fn new(runs: &'a [Run], options: &Options) -> Result<Self, MatchError> {
        let cameras: Vec<CameraInRun> =
            runs.iter().enumerate().flat_map(|(index, run)| run.cameras(index)).collect();
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
        Ok(Self { runs, cameras: used, screened, is_used, class, decided_by: matched.by })
    }

    /// The group's physical cameras: the cameras of its runs, by class.
    fn by_class(&self) -> BTreeMap<usize, Vec<&CameraInRun<'a>>> {
        let mut by_class: BTreeMap<usize, Vec<&CameraInRun>> = BTreeMap::new();
        for camera in &self.cameras {
            by_class.entry(self.class[&(camera.run, camera.id.0)]).or_default().push(camera);
        }
        by_class
    }

    fn records(&self) -> Vec<RunRecord> {
        let record = |(index, run): (usize, &Run)| {
            let geometry = run.scene.geometry.as_ref();
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
                flags: self.screened[index].findings.iter().map(|finding| finding.id).collect(),
                is_used: self.is_used[index],
            }
        };
        self.runs.iter().enumerate().map(record).collect()
    }

    fn findings(&self) -> Vec<Finding> {
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
        findings.extend(remarks::duplicates(self.runs, &self.screened));
        findings.extend(self.runs.iter().flat_map(remarks::reading));
        findings.extend(self.runs.iter().flat_map(remarks::unused_cameras));
        if let Some(by) = self.decided_by {
            let text = format!("cameras of different runs were matched by {by}");
            findings.push(remarks::of_group(FindingId::CameraMatch, group, text));
        }
        findings
    }
}

fn populations(groups: &[Group]) -> Vec<Population> {
    let mut cameras: Vec<(usize, Vec<&CameraInRun>)> = Vec::new();
    for (index, group) in groups.iter().enumerate() {
        cameras.extend(group.by_class().into_values().map(|cameras| (index, cameras)));
    }
    let of_group: Vec<CameraOfGroup> = cameras
        .iter()
        .map(|(group, cameras)| CameraOfGroup {
            group: *group,
            ids: cameras.iter().map(|camera| camera.id).collect(),
            image_names: cameras
                .iter()
                .flat_map(|c| c.image_names.iter().flatten().copied())
                .collect(),
        })
        .collect();
    let labels = labels(&of_group, &physical_cameras(&of_group));
    let mut populations: Vec<Population> = Vec::new();
    for ((group, cameras), label) in cameras.iter().zip(labels) {
        populations.extend(populations_of_camera(&groups[*group], cameras, &label));
    }
    populations.sort_by(|a, b| {
        natord::compare(&a.camera, &b.camera)
            .then((&a.model, a.width, a.height).cmp(&(&b.model, b.width, b.height)))
            .then(natord::compare(&a.group, &b.group))
    });
    populations
}

/// One camera of one group: a population for each model and image size that its runs gave it.
fn populations_of_camera(group: &Group, cameras: &[&CameraInRun], label: &str) -> Vec<Population> {
    let mut kinds: BTreeMap<(&str, u64, u64), (&'static Model, Vec<&CameraInRun>)> =
        BTreeMap::new();
    for camera in cameras {
        let model = camera.camera.intrinsics.model();
        let kind = (model.name, camera.camera.width, camera.camera.height);
        kinds.entry(kind).or_insert((model, Vec::new())).1.push(camera);
    }
    let runs = group.runs.iter().enumerate().filter(|(index, _)| group.is_used[*index]);
    let lacking: Vec<&Run> = runs
        .filter(|(index, _)| cameras.iter().all(|camera| camera.run != *index))
        .map(|(_, run)| run)
        .collect();
    let population =
        |((_, width, height), (model, cameras)): ((&str, u64, u64), (&'static Model, Vec<_>))| {
            let mut places: Vec<Place> = cameras
                .into_iter()
                .map(|camera: &CameraInRun| (&group.runs[camera.run], Some(camera)))
                .collect();
            places.extend(lacking.iter().map(|run| (*run, None)));
            places.sort_by(|(a, _), (b, _)| natord::compare(&a.name, &b.name));
            let parameters = parameters(model, &places);
            Population {
                group: group.runs[0].group.clone(),
                camera: label.to_owned(),
                model: model.name.to_owned(),
                width,
                height,
                compensation: compensation(&parameters),
                parameters,
            }
        };
    kinds.into_iter().map(population).collect()
}
