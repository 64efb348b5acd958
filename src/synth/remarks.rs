//! What a user should know of a synthetic reconstruction: what was left out, and what COLMAP will make of it.

use std::f64::consts::FRAC_PI_2;

use super::frame::Frame;
use super::observe::Sightings;
use super::{Estimate, Options, camera_of};

/// A sentence for each thing that was met.
pub fn remarks(
    truth: &Estimate,
    start: &Estimate,
    seen: &Sightings,
    options: &Options,
) -> Vec<String> {
    let idle = truth.cameras.len().saturating_sub(truth.poses.len());
    let blind = seen.by_image.iter().filter(|image| image.is_empty()).count();
    let (mut beyond, mut unseen) = (0, 0);
    for (image, sightings) in seen.by_image.iter().enumerate() {
        let axis = Frame::axis(&camera_of(&truth.cameras, image).intrinsics);
        for sighting in sightings {
            let place = truth.points[sighting.point];
            let ray = truth.poses[image].transform_point(&place.into()).coords;
            beyond += usize::from(ray.angle(&axis) > FRAC_PI_2);
            unseen += usize::from(start.project(image, &start.points[sighting.point]).is_none());
        }
    }
    let least = options.least_track;
    [
        (idle, "cameras took no image".to_owned()),
        (blind, "images see nothing".to_owned()),
        (seen.lost_count, format!("points were seen by fewer than {least} images and left out")),
        (beyond, "observations lie more than 90 degrees off the axis, where COLMAP's fisheyes see nothing".to_owned()),
        (unseen, "observations cannot be seen by the cameras of the run's start".to_owned()),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{count} {what}"))
    .collect()
}
