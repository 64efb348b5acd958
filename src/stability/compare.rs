//! Calibrations of the same cameras set against each other, or against a known one. Any models, any files.

use std::collections::BTreeMap;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::identity::match_cameras;
use super::run::CameraInRun;
use super::spread::{
    Calibration, Compared, Difference, Region, Spread, SpreadError, View, difference,
    difference_of_rays,
};
use super::view::views;
use super::{InputFile, MatchError, MatchRule, Run, SCHEMA_VERSION};
use crate::camera::Grid;
use crate::scene::CameraId;

/// Calibrations of the same cameras, compared.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Comparison {
    /// The version of this shape.
    pub schema_version: u32,
    /// The calibstab that made it.
    pub calibstab_version: String,
    /// The calibrations that were read, by name.
    pub runs: Vec<(String, Vec<InputFile>)>,
    /// The known calibration, if one was given: one of `runs`.
    pub reference: Option<String>,
    /// By what cameras were taken for the same; none: there was nothing to match.
    pub matched_by: Option<String>,
    /// Each camera.
    pub cameras: Vec<ComparedCamera>,
    /// Cameras that stand in one calibration only, or not in the reference.
    pub left_out: Vec<String>,
}

/// One camera, compared.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ComparedCamera {
    /// What it is called.
    pub camera: String,
    /// Width of its images, in px.
    pub width: u64,
    /// Height of its images, in px.
    pub height: u64,
    /// The run, the CAMERA_ID and the model of each calibration of it.
    pub calibrations: Vec<(String, u32, String)>,
    /// Of two calibrations: from the first to the second, and back.
    pub differences: Vec<Difference>,
    /// How far they disagree, the reference left out; none with fewer than two.
    pub spread: Option<Spread>,
    /// How far they are off the reference.
    pub to_reference: Option<ToReference>,
}

/// How far calibrations are off a known one.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ToReference {
    /// Of each: where the reference sees what it sees at a pixel.
    pub runs: Vec<Difference>,
    /// The same of their mean, the rotation-aligned consensus of their rays: what no repeating takes away. None with fewer than
    /// two.
    pub mean: Option<Difference>,
}

/// Why calibrations could not be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// There is nothing to compare with.
    #[error("wanted two calibrations or more, or one and `--reference`")]
    TooFew,
    /// Their cameras could not be matched.
    #[error(transparent)]
    Match(#[from] MatchError),
    /// They have no camera in common.
    #[error("they have no camera in common: {}; `--match single` takes the only camera of each for the same", .0.join(", "))]
    NothingMatched(Vec<String>),
    /// A camera could not be compared.
    #[error("{camera}: {why}")]
    Camera {
        /// The camera.
        camera: String,
        /// Why not.
        why: SpreadError,
    },
}

/// Compares calibrations, with each other and with a reference if there is one. Cameras are matched as `analyze` does; where
/// each calibration has one camera, that is it.
pub fn compare(
    mut runs: Vec<Run>,
    reference: Option<Run>,
    match_by: Option<MatchRule>,
    region: Option<Region>,
) -> Result<Comparison, CompareError> {
    let reference_index = reference.is_some().then_some(runs.len());
    runs.extend(reference);
    if runs.len() < 2 {
        return Err(CompareError::TooFew);
    }
    let cameras: Vec<CameraInRun> =
        runs.iter().enumerate().flat_map(|(index, run)| run.cameras(index)).collect();
    let is_single = cameras.len() == runs.len()
        && cameras.iter().enumerate().all(|(index, camera)| camera.run == index);
    let rule = match_by.or(is_single.then_some(MatchRule::Single));
    let matched = match_cameras(&runs, &cameras, rule, false)?;
    let mut classes: BTreeMap<usize, Vec<&CameraInRun>> = BTreeMap::new();
    for (index, camera) in cameras.iter().enumerate() {
        classes.entry(matched.classes.class(index)).or_default().push(camera);
    }
    let seen: Vec<_> = runs.par_iter().map(|run| views(&run.scene)).collect();
    let mut compared = Vec::new();
    let mut left_out = Vec::new();
    for cameras in classes.values() {
        let label = label(cameras);
        let has_reference = cameras.iter().any(|camera| Some(camera.run) == reference_index);
        if cameras.len() < 2 || reference_index.is_some() && !has_reference {
            let names: Vec<&str> = cameras.iter().map(|c| runs[c.run].name.as_str()).collect();
            left_out.push(format!("{label} of {}", names.join(", ")));
            continue;
        }
        let (known, unknown): (Vec<_>, Vec<_>) =
            cameras.iter().partition(|camera| Some(camera.run) == reference_index);
        let unknown: Vec<Calibration> =
            unknown.into_iter().map(|c| calibration(&runs, &seen, c)).collect();
        let known = known.first().map(|camera| calibration(&runs, &seen, camera));
        let one = compared_camera(&label, &unknown, known.as_ref(), region)
            .map_err(|why| CompareError::Camera { camera: label, why })?;
        compared.push(one);
    }
    if compared.is_empty() {
        return Err(CompareError::NothingMatched(left_out));
    }
    Ok(Comparison {
        schema_version: SCHEMA_VERSION,
        calibstab_version: env!("CARGO_PKG_VERSION").to_owned(),
        reference: reference_index.map(|index| runs[index].name.clone()),
        matched_by: matched
            .by
            .filter(|_| !is_single || match_by.is_some())
            .map(|by| by.to_string()),
        runs: runs.into_iter().map(|run| (run.name, run.files)).collect(),
        cameras: compared,
        left_out,
    })
}

fn calibration<'a>(
    runs: &'a [Run],
    seen: &[BTreeMap<CameraId, View>],
    camera: &CameraInRun<'a>,
) -> Calibration<'a> {
    Calibration {
        run: &runs[camera.run].name,
        camera_id: camera.id.0,
        camera: camera.camera,
        is_flagged: false,
        view: seen[camera.run].get(&camera.id).cloned(),
    }
}

/// The ids it has, the first calibration's first.
fn label(cameras: &[&CameraInRun]) -> String {
    let mut ids: Vec<u32> = cameras.iter().map(|camera| camera.id.0).collect();
    ids.dedup();
    let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
    format!("camera {}", ids.join("/"))
}

fn compared_camera(
    label: &str,
    calibrations: &[Calibration],
    reference: Option<&Calibration>,
    region: Option<Region>,
) -> Result<ComparedCamera, SpreadError> {
    let compared = match Compared::new(calibrations, region) {
        Ok(compared) => Some(compared),
        Err(SpreadError::TooFew) => None,
        Err(error) => return Err(error),
    };
    let differences = match (calibrations, reference) {
        ([one, other], None) => {
            vec![difference(one, other, region)?, difference(other, one, region)?]
        }
        _ => Vec::new(),
    };
    let to_reference = match reference {
        Some(reference) => Some(to_reference(calibrations, reference, compared.as_ref(), region)?),
        None => None,
    };
    let told = |one: &Calibration| {
        (one.run.to_owned(), one.camera_id, one.camera.intrinsics.model().name.to_owned())
    };
    let camera = calibrations[0].camera;
    Ok(ComparedCamera {
        camera: label.to_owned(),
        width: camera.width,
        height: camera.height,
        calibrations: calibrations.iter().chain(reference).map(told).collect(),
        differences,
        spread: compared.map(|compared| compared.spread),
        to_reference,
    })
}

fn to_reference(
    calibrations: &[Calibration],
    reference: &Calibration,
    compared: Option<&Compared>,
    region: Option<Region>,
) -> Result<ToReference, SpreadError> {
    let runs = calibrations
        .par_iter()
        .map(|one| {
            // Where the run looked is where it can be told right from wrong.
            let known = Calibration { view: one.view.clone(), ..reference.clone() };
            difference(one, &known, region)
        })
        .collect::<Result<_, _>>()?;
    let mean = |compared: &Compared| {
        let camera = calibrations[0].camera;
        let grid = Grid::new(camera.width, camera.height);
        let rays = compared.spread.cells.iter().copied().zip(compared.mean_rays.iter().copied());
        let names = ["the mean", reference.run];
        difference_of_rays(&grid, &rays.collect::<Vec<_>>(), &reference.camera.intrinsics, names)
    };
    Ok(ToReference { runs, mean: compared.map(mean).transpose()? })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{run, simple_radial};
    use super::*;

    #[test]
    fn calibrations_are_compared_with_each_other_and_with_a_known_one() {
        let runs = simple_radial("", &[[1000.0, -0.1], [1010.0, -0.1], [990.0, -0.1]]);
        let known = [1005.0, 1005.0, 640.0, 480.0, -0.1, 0.0, 0.0, 0.0];
        let known = run("", "known", &[(7, "OPENCV", &known)]);
        let found = compare(runs, Some(known), None, None).unwrap();
        assert_eq!(found.reference.as_deref(), Some("known"));
        let camera = &found.cameras[0];
        let to_reference = camera.to_reference.as_ref().unwrap();
        assert_eq!((to_reference.runs.len(), camera.spread.as_ref().unwrap().n), (3, 3));
        // f is off by -5, 5, -15; the mean by -5: nearly in proportion.
        let px = |difference: &Difference| difference.rotated.rms_px;
        let mean = px(to_reference.mean.as_ref().unwrap());
        for (run, times) in to_reference.runs.iter().zip([1.0, 1.0, 3.0]) {
            assert!((px(run) / mean / times - 1.0).abs() < 0.03, "{} {mean}", px(run));
        }
    }

    #[test]
    fn cameras_without_a_partner_are_named_and_none_is_an_error() {
        let params: &[f64] = &[1000.0, 640.0, 480.0, -0.1];
        let one = run("", "a", &[(1, "SIMPLE_RADIAL", params), (2, "SIMPLE_RADIAL", params)]);
        let other = run("", "b", &[(2, "SIMPLE_RADIAL", params), (3, "SIMPLE_RADIAL", params)]);
        let found = compare(vec![one.clone(), other], None, None, None).unwrap();
        assert_eq!(found.left_out, ["camera 1 of a", "camera 3 of b"]);
        assert_eq!(found.cameras[0].differences.len(), 2);
        let stranger = run("", "c", &[(8, "SIMPLE_RADIAL", params), (9, "SIMPLE_RADIAL", params)]);
        let error = compare(vec![one.clone(), stranger], None, None, None).unwrap_err();
        assert!(matches!(error, CompareError::NothingMatched(_)), "{error}");
        assert_eq!(compare(vec![one], None, None, None).unwrap_err(), CompareError::TooFew);
    }
}
