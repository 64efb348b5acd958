//! What is suspect about a run before any statistics: copies, impossible cameras, too few images.

use std::collections::BTreeMap;

use super::run::CameraInRun;
use super::{Finding, FindingId, Run};
use crate::scene::{Camera, Scene};
use crate::stats::Sorted;

/// A run that registered less than this share of its group's median of images is suspect.
pub(super) const FEW_IMAGES: f64 = 0.6;

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
            if let Some(why) = camera.camera.implausible() {
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
