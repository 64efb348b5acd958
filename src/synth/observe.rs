//! Which image sees which point, and where.

use nalgebra::{Vector2, Vector3};

use super::frame::Frame;
use super::random::{Purpose, Random};
use super::{Estimate, Options, camera_of};

/// Nearer than this, in m, nothing is seen: a single near point would shift by half an image from view to view.
const NEAREST: f64 = 1.0;

/// One point in one image.
#[derive(Debug, Clone, Copy)]
pub struct Sighting {
    /// Its index among the points that are kept.
    pub point: usize,
    /// Where it is seen, in px.
    pub pixel: Vector2<f64>,
}

/// What all images see.
#[derive(Debug, Clone)]
pub struct Sightings {
    /// By image, in the order of the points.
    pub by_image: Vec<Vec<Sighting>>,
    /// Which points are kept, by their index among all.
    kept: Vec<usize>,
    /// How many points some image sees, but too few images.
    pub lost_count: usize,
}

impl Sightings {
    /// What is seen without error.
    pub fn of(truth: &Estimate, options: &Options) -> Self {
        let mut random = Random::new(options.seed, options.run_of_views(), Purpose::Sightings);
        let mut by_image: Vec<Vec<Sighting>> = (0..truth.poses.len())
            .map(|image| {
                let visible = visible(truth, image, options.widest_degrees.to_radians());
                random.choose(options.most_per_image as usize, visible)
            })
            .collect();
        let mut track_lengths = vec![0; truth.points.len()];
        by_image.iter().flatten().for_each(|sighting| track_lengths[sighting.point] += 1);
        let is_kept = |point: usize| track_lengths[point] >= options.least_track.max(1);
        let kept: Vec<usize> = (0..truth.points.len()).filter(|&point| is_kept(point)).collect();
        let mut new_index = vec![None; truth.points.len()];
        kept.iter().enumerate().for_each(|(new, &point)| new_index[point] = Some(new));
        for image in &mut by_image {
            *image = image
                .iter()
                .filter_map(|seen| Some(Sighting { point: new_index[seen.point]?, ..*seen }))
                .collect();
        }
        let seen_count = track_lengths.iter().filter(|&&length| length > 0).count();
        Self { by_image, lost_count: seen_count - kept.len(), kept }
    }

    /// Of all points those that are kept.
    pub fn kept(&self, points: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
        self.kept.iter().map(|&index| points[index]).collect()
    }

    /// The same, each coordinate with an error of this standard deviation; an error may lead out of the image.
    pub fn with_noise(&self, noise_px: f64, random: &mut Random) -> Self {
        let mut noisy = self.clone();
        for sighting in noisy.by_image.iter_mut().flatten() {
            sighting.pixel += noise_px * random.normals().xy();
        }
        noisy
    }
}

/// All that an image could see.
fn visible(truth: &Estimate, image: usize, widest: f64) -> Vec<Sighting> {
    let camera = camera_of(&truth.cameras, image);
    let (frame, axis) = (Frame::of(camera), Frame::axis(&camera.intrinsics));
    let see = |(point, place): (usize, &Vector3<f64>)| {
        let seen = truth.poses[image].transform_point(&(*place).into()).coords;
        if seen.norm() < NEAREST || seen.angle(&axis) > widest {
            return None;
        }
        let pixel = camera.intrinsics.project(&seen).ok()?;
        frame.holds(&pixel).then_some(Sighting { point, pixel })
    };
    truth.points.iter().enumerate().filter_map(see).collect()
}
