//! A scene taken for the truth, and seen again with other noise.

use std::collections::HashMap;

use super::random::{Purpose, Random};
use super::scene::NO_ERROR;
use crate::scene::{Keypoint, Keypoints, Point3D, Points3D, Scene};

/// The scene with every keypoint that is seen as a point where the scene's lens, pose and point put it, plus noise of this standard
/// deviation on x and on y. Keypoints without a point, and those of points that their lens cannot see, stay where they are; the
/// points' errors are not computed. Each run of a seed has noise of its own.
pub fn with_redrawn_noise(mut scene: Scene, noise_px: f64, seed: u64, run: u64) -> Scene {
    let Some(geometry) = &mut scene.geometry else { return scene };
    let mut random = Random::new(seed, run, Purpose::Noise);
    let places: HashMap<_, _> = geometry.points.iter().map(|point| (point.id, point.xyz)).collect();
    let poses = geometry.poses();
    for (image, pose) in geometry.images.values_mut().zip(poses) {
        let lens = &scene.cameras[&image.camera].intrinsics;
        let again = |Keypoint { xy, point }: Keypoint| {
            // Drawn for every keypoint, so that one that cannot be seen changes no other.
            let noise = noise_px * random.normals().xy();
            let seen = point.zip(pose).and_then(|(point, pose)| {
                lens.project(&pose.transform_point(&places[&point].into()).coords).ok()
            });
            Keypoint { xy: seen.map_or(xy, |seen| (seen + noise).into()), point }
        };
        let mut keypoints = Keypoints::default();
        image.keypoints.iter().map(again).for_each(|keypoint| keypoints.push(keypoint));
        image.keypoints = keypoints;
    }
    let mut points = Points3D::default();
    geometry.points.iter().for_each(|point| points.push(Point3D { error_px: NO_ERROR, ..point }));
    geometry.points = points;
    scene
}
