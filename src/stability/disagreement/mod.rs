//! What one population shows beyond its parameters one by one: spread, parts that disagree, what the runs share.

pub(super) mod remarks;

use std::collections::{BTreeMap, BTreeSet};

use super::clusters::{Clusters, Part, PartParameter, parts};
use super::overlap::{Overlap, overlap};
use super::run::CameraInRun;
use super::spread::{Calibration, Compared, Region, Spread, SpreadError, View};
use super::summary::{Place, parameters};
use super::{Correlations, LeftSpread, Parameter, Run, SampleState};
use crate::camera::Model;
use crate::scene::CameraId;
use crate::stats::pearson;

/// What is known of the runs of a group besides their cameras.
pub(super) struct Background<'a> {
    /// What each camera observed, by run and camera.
    pub views: &'a BTreeMap<(&'a str, CameraId), View>,
    /// Runs that are suspect.
    pub flagged: &'a BTreeSet<&'a str>,
    pub region: Option<Region>,
}

impl Background<'_> {
    /// What this camera of this run observed.
    pub(super) fn view<'b>(&'b self, run: &'b Run, camera: CameraId) -> Option<&'b View> {
        let views: &BTreeMap<(&'b str, CameraId), View> = self.views;
        views.get(&(run.name.as_str(), camera))
    }
}

/// What one population shows.
pub(super) struct Disagreement {
    pub spread: Option<Spread>,
    pub without_spread: Option<String>,
    pub clusters: Option<Clusters>,
    pub overlap: Option<Overlap>,
}

pub(super) fn disagreement(
    model: &'static Model,
    places: &[Place],
    background: &Background,
) -> Disagreement {
    let calibrations = calibrations(places, background);
    let cameras: Vec<_> =
        places.iter().filter_map(|(run, camera)| sampled(run, camera.as_ref()?)).collect();
    match Compared::new(&calibrations, background.region) {
        Ok(compared) => Disagreement {
            clusters: clusters(model, places, background, &compared),
            overlap: overlap(&cameras, Some(compared.spread.rotated.rms_px)),
            spread: Some(compared.spread),
            without_spread: None,
        },
        Err(error) => Disagreement {
            spread: None,
            without_spread: (error != SpreadError::TooFew).then(|| error.to_string()),
            clusters: None,
            overlap: overlap(&cameras, None),
        },
    }
}

/// A camera that is a sample, with its run.
fn sampled<'a>(run: &'a Run, camera: &CameraInRun) -> Option<(&'a Run, CameraId)> {
    camera.calibration().map(|_| (run, camera.id))
}

/// The spread of a population before it was refined, in short.
pub(super) fn left_spread(
    places: &[Place],
    background: &Background,
) -> Result<LeftSpread, SpreadError> {
    let spread = Compared::new(&calibrations(places, background), background.region)?.spread;
    Ok(LeftSpread {
        n: spread.n,
        region: spread.region,
        cell_share: spread.cell_share,
        raw_rms_px: spread.raw.rms_px,
        rotated_rms_px: spread.rotated.rms_px,
        moved_rms_px: spread.moved.map(|moved| moved.measure.rms_px),
    })
}

fn calibrations<'a>(places: &[Place<'a>], background: &Background) -> Vec<Calibration<'a>> {
    let calibration = |(run, camera): &Place<'a>| {
        let camera = (*camera)?;
        Some(Calibration {
            run: &run.name,
            camera_id: camera.id.0,
            camera: camera.calibration()?,
            is_flagged: background.flagged.contains(run.name.as_str()),
            view: background.views.get(&(run.name.as_str(), camera.id)).cloned(),
        })
    };
    places.iter().filter_map(calibration).collect()
}

/// The parts that the runs fall into, and each run that was set aside as one of its own; none when all agree.
fn clusters(
    model: &'static Model,
    places: &[Place],
    background: &Background,
    compared: &Compared,
) -> Option<Clusters> {
    let spread = &compared.spread;
    let found = parts(&compared.distances);
    if found.len() + spread.set_aside.len() < 2 {
        return None;
    }
    let key = |index: usize| (spread.runs[index].run.as_str(), spread.runs[index].camera_id);
    let mut told: Vec<Part> = Vec::new();
    for members in &found {
        let gaps = members.iter().flat_map(|&one| {
            let others = (0..spread.n).filter(|other| !members.contains(other));
            others.map(move |other| compared.distances[one][other])
        });
        let gap_px = gaps.reduce(f64::min);
        let keys: BTreeSet<_> = members.iter().map(|&index| key(index)).collect();
        told.push(Part { gap_px, ..part(model, places, background, &keys) });
    }
    for aside in &spread.set_aside {
        let keys = BTreeSet::from([(aside.run.as_str(), aside.camera_id)]);
        told.push(part(model, places, background, &keys));
    }
    Some(Clusters { parts: told })
}

fn part(
    model: &'static Model,
    places: &[Place],
    background: &Background,
    keys: &BTreeSet<(&str, u32)>,
) -> Part {
    let is_in = |(run, camera): &&Place| {
        camera.is_some_and(|camera| keys.contains(&(run.name.as_str(), camera.id.0)))
    };
    let members: Vec<Place> = places.iter().filter(is_in).copied().collect();
    let name = |(run, camera): &Place| {
        let of_run = places.iter().filter(|(other, _)| other.name == run.name).count();
        match camera {
            Some(camera) if of_run > 1 => format!("{}:{}", run.name, camera.id),
            _ => run.name.clone(),
        }
    };
    let measured = Compared::new(&calibrations(&members, background), background.region).ok();
    let of_parameter = |parameter: Parameter| {
        let statistics = parameter.statistics?;
        let (n, mean, std) = (statistics.n, statistics.mean, statistics.std);
        Some(PartParameter { name: parameter.name, n, mean, std })
    };
    Part {
        runs: members.iter().map(name).collect(),
        gap_px: None,
        spread_px: measured.map(|c| [c.spread.raw.rms_px, c.spread.rotated.rms_px]),
        parameters: parameters(model, &members).into_iter().filter_map(of_parameter).collect(),
    }
}

/// Pearson's correlation of any two parameters that have statistics, over the runs that estimated both.
pub(super) fn correlations(parameters: &[Parameter]) -> Correlations {
    let shown: Vec<&Parameter> = parameters.iter().filter(|p| p.statistics.is_some()).collect();
    let correlation = |one: &Parameter, other: &Parameter| {
        let pairs = one.samples.iter().zip(&other.samples).filter_map(|(one, other)| {
            let value = |sample: &super::Sample| {
                sample.value.filter(|_| sample.state == SampleState::Estimated)
            };
            Some([value(one)?, value(other)?])
        });
        pearson(&pairs.collect::<Vec<_>>())
    };
    Correlations {
        parameters: shown.iter().map(|parameter| parameter.name.clone()).collect(),
        matrix: shown
            .iter()
            .map(|one| shown.iter().map(|other| correlation(one, other)).collect())
            .collect(),
    }
}
