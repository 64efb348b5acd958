//! What is suspect about a run before any statistics: copies, impossible cameras, too few images.

use std::collections::BTreeMap;

use super::run::CameraInRun;
use super::{Finding, FindingId, Run};
use crate::camera::ParamClass;
use crate::scene::{Camera, Scene};
use crate::stats::Sorted;

/// COLMAP's bounds of a plausible focal length, in units of the larger image side.
const FOCAL_RATIO: std::ops::RangeInclusive<f64> = 0.1..=10.0;
/// COLMAP bounds no fx / fy; but pixels are square and anamorphic lenses squeeze by 2 at most, and repeats on real data that fell into
/// a wrong basin have 0.4 and 2.6.
const ASPECT_RATIO: std::ops::RangeInclusive<f64> = 0.5..=2.0;
/// COLMAP's bound of a plausible distortion coefficient.
const LARGEST_COEFFICIENT: f64 = 1.0;
/// A run that registered less than this share of its group's median of images is suspect.
const FEW_IMAGES: f64 = 0.6;

/// What is suspect about one run.
#[derive(Debug, Default)]
pub(super) struct Screened {
    /// Index of an identical run of the group.
    pub duplicate_of: Option<usize>,
    /// Why it is suspect.
    pub findings: Vec<Finding>,
}

/// Screens the runs of one group; `runs` are those of it.
pub(super) fn screen(runs: &[Run], cameras: &[CameraInRun]) -> Vec<Screened> {
    let duplicates = duplicates(runs, cameras);
    let median = median_image_count(runs);
    let mut screened: Vec<Screened> = Vec::new();
    for (index, run) in runs.iter().enumerate() {
        let mut findings: Vec<Finding> = Vec::new();
        let mut find = |id, text| {
            let (group, runs) = (Some(run.group.clone()), vec![run.name.clone()]);
            findings.push(Finding { id, group, camera: None, runs, text });
        };
        for camera in cameras.iter().filter(|camera| camera.run == index) {
            if let Some(why) = bogus(camera.camera) {
                let text = format!("{}: its camera {} is no real lens: {why}", run.name, camera.id);
                find(FindingId::BogusCamera, text);
            }
        }
        if let (Some(count), Some(median)) = (image_count(run), median)
            && (count as f64) < FEW_IMAGES * median
        {
            let text =
                format!("{} registered {count} images, the group's median is {median}", run.name);
            find(FindingId::FewImages, text);
        }
        screened.push(Screened { duplicate_of: duplicates[index], findings });
    }
    screened
}

pub(super) fn image_count(run: &Run) -> Option<usize> {
    run.scene.geometry.as_ref().map(|geometry| geometry.images.len())
}

fn median_image_count(runs: &[Run]) -> Option<f64> {
    let counts = runs.iter().filter_map(image_count).map(|count| count as f64).collect();
    Some(Sorted::new(counts)?.median())
}

/// Model, width, height and the bits of the parameters of a camera.
type CameraBits = (&'static str, u64, u64, Vec<u64>);

/// For each run, the first run of the group that it repeats to the last bit.
fn duplicates(runs: &[Run], cameras: &[CameraInRun]) -> Vec<Option<usize>> {
    let mut bits: Vec<Vec<CameraBits>> = vec![Vec::new(); runs.len()];
    for camera in cameras {
        let Camera { intrinsics, width, height } = camera.camera;
        let params = intrinsics.params().iter().map(|value| value.to_bits()).collect();
        bits[camera.run].push((intrinsics.model().name, *width, *height, params));
    }
    bits.iter_mut().for_each(|cameras| cameras.sort());
    let mut alike: BTreeMap<&[CameraBits], Vec<usize>> = BTreeMap::new();
    let mut duplicate_of = vec![None; runs.len()];
    for (index, bits) in bits.iter().enumerate() {
        let alike = alike.entry(bits.as_slice()).or_default();
        let is_copy = |&&other: &&usize| is_same_scene(&runs[other].scene, &runs[index].scene);
        duplicate_of[index] = alike.iter().find(is_copy).copied();
        if duplicate_of[index].is_none() {
            alike.push(index);
        }
    }
    duplicate_of
}

/// Whether two scenes with equal cameras are one. If not, the cameras were held, and the runs are no copies. That an older
/// COLMAP wrote one of them without rigs makes no difference.
fn is_same_scene(one: &Scene, other: &Scene) -> bool {
    match (&one.geometry, &other.geometry) {
        (Some(one), Some(other)) => one.images == other.images && one.points == other.points,
        (None, None) => true,
        _ => false,
    }
}

/// Why no real lens has these intrinsics; none when one could.
fn bogus(camera: &Camera) -> Option<String> {
    let size = [camera.width as f64, camera.height as f64];
    let larger = size[0].max(size[1]);
    let params = camera.intrinsics.model().params.iter().zip(camera.intrinsics.params());
    // A model's principal point is its two coordinates, x before y.
    let mut sides = size.iter();
    let mut reasons: Vec<String> = Vec::new();
    let mut focals = Vec::new();
    for (param, &value) in params {
        let name = param.name;
        match param.class {
            ParamClass::Focal => {
                focals.push(value);
                let ratio = value / larger;
                if !FOCAL_RATIO.contains(&ratio) {
                    reasons.push(format!("{name} is {ratio:.3} times the larger image side"));
                }
            }
            ParamClass::PrincipalPoint => {
                if sides.next().is_some_and(|&side| !(0.0..=side).contains(&value)) {
                    reasons.push(format!("{name} = {value:.3} px is outside the image"));
                }
            }
            ParamClass::Extra if param.is_small && value.abs() > LARGEST_COEFFICIENT => {
                reasons.push(format!("{name} = {value:.3} is beyond {LARGEST_COEFFICIENT}"));
            }
            ParamClass::Extra | ParamClass::Metadata => {}
        }
    }
    if let [fx, fy] = focals[..]
        && !ASPECT_RATIO.contains(&(fx / fy))
    {
        reasons.push(format!("fx / fy is {:.3}", fx / fy));
    }
    (!reasons.is_empty()).then(|| reasons.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Model;

    fn camera(model: &str, params: &[f64]) -> Camera {
        let intrinsics = Model::named(model).unwrap().with_params(params).unwrap();
        Camera { intrinsics, width: 752, height: 480 }
    }

    #[test]
    fn a_plausible_camera_is_not_bogus() {
        let params = [465.7, 465.0, 376.0, 240.0, -0.27, 0.067, 0.0014, -0.0004];
        assert_eq!(bogus(&camera("OPENCV", &params)), None);
        // Rational coefficients trade with each other: 12 is no fault.
        let params = [465.7, 465.0, 376.0, 240.0, 12.0, 3.0, 0.0, 0.0, 0.1, 12.3, 5.0, 0.5];
        assert_eq!(bogus(&camera("FULL_OPENCV", &params)), None);
    }

    #[test]
    fn each_bound_of_colmap_is_checked_and_named() {
        let good = [465.7, 465.0, 376.0, 240.0, -0.27, 0.067, 0.0014, -0.0004];
        for (index, value, word) in [
            (0, 75.1, "fx is"),
            (1, 7521.0, "fy is"),
            (1, -465.0, "fy is"),
            (1, 150.0, "fx / fy"),
            (2, 752.5, "cx"),
            (3, -0.5, "cy"),
            (3, 500.0, "cy"),
            (4, -1.01, "k1"),
            (7, 1.5, "p2"),
        ] {
            let mut params = good;
            params[index] = value;
            let why = bogus(&camera("OPENCV", &params)).unwrap();
            assert!(why.starts_with(word), "{why}");
        }
    }
}
