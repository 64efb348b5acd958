//! The cameras of all groups, each a population: its samples and all that they show.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::between::SameCamera;
use super::disagreement::{Background, Disagreement, correlations, disagreement, left_spread};
use super::group::Group;
use super::image_effect::{fill_std_px, folds};
use super::inside::{held_tests, residuals_of};
use super::physical::{CameraOfGroup, labels, physical_cameras, with_sharers};
use super::prediction::{Beside, prediction};
use super::refinement::predicted_correlations;
use super::run::CameraInRun;
use super::spread::SpreadError;
use super::summary::{Place, compensation, parameters};
use super::{AsLeft, Population, Run, Verdict};
use crate::camera::Model;

/// The populations, and which of them are calibrations of one camera.
pub(super) fn populations(groups: &[Group]) -> (Vec<Population>, Vec<SameCamera>) {
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
    let classes = physical_cameras(&of_group);
    let labels = labels(&of_group, &classes);
    let name = |camera: usize| {
        (groups[of_group[camera].group].runs[0].group.clone(), labels[camera].clone())
    };
    let same_cameras = with_sharers(&of_group, &classes)
        .into_iter()
        .map(|(class, members)| SameCamera {
            camera: labels[class].clone(),
            members: members.into_iter().map(name).collect(),
        })
        .collect();
    let mut populations: Vec<Population> = Vec::new();
    let found: Vec<Vec<Population>> = cameras
        .par_iter()
        .zip(&labels)
        .map(|((group, cameras), label)| populations_of_camera(&groups[*group], cameras, label))
        .collect();
    populations.extend(found.into_iter().flatten());
    populations.sort_by(|a, b| {
        natord::compare(&a.camera, &b.camera)
            .then((&a.model, a.width, a.height).cmp(&(&b.model, b.width, b.height)))
            .then(natord::compare(&a.group, &b.group))
    });
    (populations, same_cameras)
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
    let flagged = group.flagged();
    let background = Background { views: &group.views, flagged: &flagged, region: group.region };
    let population = |((_, width, height), (model, cameras)): ((&str, u64, u64), (_, Vec<_>))| {
        let mut places: Vec<Place> = cameras
            .into_iter()
            .map(|camera: &CameraInRun| (&group.runs[camera.run], Some(camera)))
            .collect();
        places.extend(lacking.iter().map(|run| (*run, None)));
        places.sort_by(|(a, _), (b, _)| natord::compare(&a.name, &b.name));
        let name = Name { group: &group.runs[0].group, camera: label, size: [width, height] };
        let as_left =
            group.is_refined.then(|| as_left(model, [width, height], &places, &background));
        Population { as_left, ..of_places(model, &name, &places, &background) }
    };
    kinds.into_iter().map(population).collect()
}

/// What a population is of.
struct Name<'a> {
    group: &'a str,
    camera: &'a str,
    size: [u64; 2],
}

fn of_places(
    model: &'static Model,
    &Name { group, camera, size }: &Name,
    places: &[Place],
    background: &Background,
) -> Population {
    let mut parameters = parameters(model, places);
    let ray_share = fill_std_px(model, size, &mut parameters);
    let Disagreement { spread, without_spread, clusters, overlap } =
        disagreement(model, places, background);
    let sampled: Vec<&CameraInRun> = places
        .iter()
        .filter_map(|(_, camera)| camera.filter(|camera| camera.calibration().is_some()))
        .collect();
    let with_runs: Vec<(&Run, &CameraInRun)> = places
        .iter()
        .filter_map(|(run, camera)| Some((*run, camera.filter(|one| one.calibration().is_some())?)))
        .collect();
    let view = with_runs.first().and_then(|(run, camera)| background.view(run, camera.id));
    let (overlap_known, region) = (overlap.as_ref(), background.region);
    let beside = Beside { spread: spread.as_ref(), overlap: overlap_known, view, region };
    let prediction = prediction(&with_runs, &beside);
    Population {
        group: group.to_owned(),
        camera: camera.to_owned(),
        model: model.name.to_owned(),
        width: size[0],
        height: size[1],
        // Said when all findings are known.
        verdict: Verdict::default(),
        ray_share,
        folds: folds(model, size, &parameters),
        compensation: compensation(&parameters),
        correlations: correlations(&parameters),
        predicted_correlations: predicted_correlations(model, &sampled),
        parameters,
        prediction,
        held: held_tests(&with_runs),
        residuals: residuals_of(&with_runs, overlap.as_ref()),
        spread,
        without_spread,
        clusters,
        overlap,
        as_left: None,
    }
}

/// The same runs before they were refined.
fn as_left(
    model: &'static Model,
    size: [u64; 2],
    places: &[Place],
    background: &Background,
) -> AsLeft {
    let left: Vec<Option<CameraInRun>> =
        places.iter().map(|(run, camera)| camera.map(|camera| camera.as_left(run))).collect();
    let places: Vec<Place> =
        places.iter().zip(&left).map(|((run, _), camera)| (*run, camera.as_ref())).collect();
    let mut parameters = parameters(model, &places);
    fill_std_px(model, size, &mut parameters);
    let (spread, without_spread) = match left_spread(&places, background) {
        Ok(spread) => (Some(spread), None),
        Err(SpreadError::TooFew) => (None, None),
        Err(error) => (None, Some(error.to_string())),
    };
    AsLeft { parameters, spread, without_spread }
}
