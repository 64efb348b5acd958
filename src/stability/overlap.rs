//! Observations that runs share: repeats that look at the same measurements show less than independent ones would.

use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};

use schemars::JsonSchema;
use serde::Serialize;

use super::Run;
use crate::scene::CameraId;

/// Above this shared fraction repeats show the solver's repeatability only, and no correction helps.
pub(super) const MOST_SHARED: f64 = 0.9;

/// How much of what they observed the runs share.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Overlap {
    /// Shared fraction of the observations: over all pairs of runs, those of the same image and the same keypoint, relative to
    /// the mean count of the two.
    pub shared_fraction: f64,
    /// What independent repeats would show of spread and std, as a multiple of what these do: 1 / sqrt(1 - shared fraction).
    /// None above 0.9: then these repeats show the solver's repeatability only.
    pub independent_factor: Option<f64>,
    /// The rotation-aligned spread of independent repeats, RMS in px.
    pub independent_rms_px: Option<f64>,
    /// Images that the camera took, in all runs together.
    pub image_count: usize,
    /// Images of a run, on average.
    pub images_per_run: f64,
    /// If each run is a random draw of the images: the std of a calibration from all of them, as a multiple of the std between
    /// the runs (delete-d jackknife, sqrt(m / (N - m))). None where runs have all images.
    pub jackknife_factor: Option<f64>,
}

/// What the runs of one camera share; none unless all have images, or with fewer than two.
pub(super) fn overlap(cameras: &[(&Run, CameraId)], rms_px: Option<f64>) -> Option<Overlap> {
    if cameras.len() < 2 || cameras.iter().any(|(run, _)| run.scene.geometry.is_none()) {
        return None;
    }
    let mut names: BTreeSet<&str> = BTreeSet::new();
    let mut taken = 0;
    let mut all: Vec<u64> = Vec::new();
    for (run, camera) in cameras {
        let images = run.scene.geometry.iter().flat_map(|geometry| geometry.images.values());
        // One keypoint of one image may stand twice in a file, and is one measurement.
        let mut observed: Vec<u64> = Vec::new();
        for image in images.filter(|image| image.camera == *camera) {
            names.insert(&image.name);
            taken += 1;
            let seen = image.keypoints.iter().filter(|keypoint| keypoint.point.is_some());
            observed.extend(seen.map(|keypoint| identity(&image.name, keypoint.xy)));
        }
        observed.sort_unstable();
        observed.dedup();
        all.extend(observed);
    }
    if all.is_empty() {
        return None;
    }
    let shared_fraction = shared_fraction(all, cameras.len());
    let is_correctable = shared_fraction <= MOST_SHARED;
    let factor = is_correctable.then(|| 1.0 / (1.0 - shared_fraction).sqrt());
    let images_per_run = taken as f64 / cameras.len() as f64;
    let left = names.len() as f64 - images_per_run;
    Some(Overlap {
        shared_fraction,
        independent_factor: factor,
        independent_rms_px: factor.zip(rms_px).map(|(factor, px)| factor * px),
        image_count: names.len(),
        images_per_run,
        jackknife_factor: (left > 0.0).then(|| (images_per_run / left).sqrt()),
    })
}

fn identity(name: &str, xy: [f64; 2]) -> u64 {
    let mut hasher = DefaultHasher::new();
    (name, xy.map(f64::to_bits)).hash(&mut hasher);
    hasher.finish()
}

/// An observation of c runs is shared by c (c - 1) / 2 of their pairs.
fn shared_fraction(mut all: Vec<u64>, runs: usize) -> f64 {
    all.sort_unstable();
    let shared: usize = all.chunk_by(|a, b| a == b).map(|same| same.len() * (same.len() - 1)).sum();
    shared as f64 / (all.len() * (runs - 1)) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shared_fraction_is_that_of_pairs() {
        // Three runs of four observations: 1 and 2 share two, 3 shares one with both.
        let all = vec![1, 2, 3, 4, 1, 2, 5, 6, 1, 7, 8, 9];
        // 2 + 1 + 1 of 3 pairs of 4
        assert!((shared_fraction(all, 3) - 4.0 / 12.0).abs() < 1e-15);
        assert!((shared_fraction(vec![1, 2, 1, 2, 1, 2], 3) - 1.0).abs() < 1e-15);
        assert!(shared_fraction(vec![1, 2, 3, 4], 2).abs() < 1e-15);
    }
}
