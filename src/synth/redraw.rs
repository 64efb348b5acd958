//! A scene taken for the truth, and seen again with other noise.

use std::collections::HashMap;

use super::random::{Purpose, Random};
use super::scene::NO_ERROR;
use crate::scene::{Keypoint, Keypoints, Point3D, Points3D, Scene};

/// What is seen of a scene but for the noise: every keypoint where the scene's lens, pose and point put it.
#[derive(Debug, Clone)]
pub struct Noiseless {
    /// Of every keypoint, in the order of the images: the pixel, and whether it is one that noise is added to.
    images: Vec<Vec<([f64; 2], bool)>>,
}

impl Noiseless {
    /// What is seen of a scene. Keypoints without a point, and those of points that their lens cannot see, stay where they are.
    pub fn of(scene: &Scene) -> Self {
        let Some(geometry) = &scene.geometry else { return Self { images: Vec::new() } };
        let places: HashMap<_, _> =
            geometry.points.iter().map(|point| (point.id, point.xyz)).collect();
        let poses = geometry.poses();
        let image = |(image, pose): (&crate::scene::Image, _)| {
            let lens = &scene.cameras[&image.camera].intrinsics;
            let exact = |Keypoint { xy, point }: Keypoint| {
                let seen =
                    point.zip(pose).and_then(|(point, pose): (_, nalgebra::Isometry3<f64>)| {
                        lens.project(&pose.transform_point(&places[&point].into()).coords).ok()
                    });
                seen.map_or((xy, false), |seen| (seen.into(), true))
            };
            image.keypoints.iter().map(exact).collect()
        };
        Self { images: geometry.images.values().zip(poses).map(image).collect() }
    }

    /// The pixels with noise of this standard deviation on x and on y, in the order of the images. Each run of a seed has noise of its own.
    pub fn with_noise(&self, noise_px: f64, seed: u64, run: u64) -> Vec<Vec<[f64; 2]>> {
        let mut random = Random::new(seed, run, Purpose::Noise);
        let mut noisy = |&([x, y], is_seen): &([f64; 2], bool)| {
            // Drawn for every keypoint, so that one that cannot be seen changes no other; a third goes unused in every version.
            let noise = [random.normal(), random.normal()].map(|noise| noise_px * noise);
            random.pass_normal();
            if is_seen { [x + noise[0], y + noise[1]] } else { [x, y] }
        };
        self.images.iter().map(|image| image.iter().map(&mut noisy).collect()).collect()
    }
}

/// The scene with the pixels of [`Noiseless::with_noise`]; the points' errors are not computed.
pub fn with_redrawn_noise(mut scene: Scene, noise_px: f64, seed: u64, run: u64) -> Scene {
    let pixels = Noiseless::of(&scene).with_noise(noise_px, seed, run);
    let Some(geometry) = &mut scene.geometry else { return scene };
    for (image, pixels) in geometry.images.values_mut().zip(pixels) {
        let mut keypoints = Keypoints::default();
        for (keypoint, xy) in image.keypoints.iter().zip(pixels) {
            keypoints.push(Keypoint { xy, ..keypoint });
        }
        image.keypoints = keypoints;
    }
    let mut points = Points3D::default();
    geometry.points.iter().for_each(|point| points.push(Point3D { error_px: NO_ERROR, ..point }));
    geometry.points = points;
    scene
}
