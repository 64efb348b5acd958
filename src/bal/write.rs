//! From a scene to a problem's text.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::rotation::angle_axis;
use crate::camera::Intrinsics;
use crate::scene::{ImageId, Scene};

/// A scene that the format cannot hold.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WriteError {
    /// There are cameras alone.
    #[error("the scene has neither images nor points")]
    NoGeometry,
    /// The format knows no rigs.
    #[error("the scene has rigs, which the format cannot hold")]
    Rigs,
    /// Another model than the format's.
    #[error(
        "image {image} was taken by a camera of model {model}; the format knows only f, k1 and k2"
    )]
    Model {
        /// The first such image.
        image: ImageId,
        /// The camera's model.
        model: &'static str,
    },
    /// A track names an image or a keypoint that is not there.
    #[error("a track names keypoint {keypoint} of image {image}, which is not there")]
    NoKeypoint {
        /// The image.
        image: ImageId,
        /// The keypoint.
        keypoint: u32,
    },
}

/// The scene as a problem: an image with its camera becomes a camera, observations come in the order of points and tracks.
///
/// Numbers are written with as many digits as bring them back. Image sizes, keypoints of no point and cameras of no image
/// have no place in the format.
pub fn encode(scene: &Scene) -> Result<String, WriteError> {
    let geometry = scene.geometry.as_ref().ok_or(WriteError::NoGeometry)?;
    if geometry.mounting.is_some() {
        return Err(WriteError::Rigs);
    }
    let (mut observations, mut cameras, mut points) = (String::new(), String::new(), String::new());
    let mut numbers = BTreeMap::new();
    for (number, (&id, image)) in geometry.images.iter().enumerate() {
        numbers.insert(id, (number, &image.keypoints));
        let lens = scene.cameras.get(&image.camera).map(|camera| camera.intrinsics);
        let lens = match lens {
            Some(Intrinsics::BalStrict(lens)) => lens,
            other => {
                let model = other.map_or("unknown", |lens| lens.model().name);
                return Err(WriteError::Model { image: id, model });
            }
        };
        let pose = image.cam_from_world;
        lines(&mut cameras, &[angle_axis(pose.quaternion), pose.translation, lens].concat());
    }
    for (number, point) in geometry.points.iter().enumerate() {
        lines(&mut points, &point.xyz);
        for element in point.track {
            let (image, keypoint) = (element.image, element.keypoint);
            let missing = WriteError::NoKeypoint { image, keypoint };
            let Some((camera, keypoints)) = numbers.get(&image) else { return Err(missing) };
            let Some(seen) = keypoints.get(keypoint as usize) else { return Err(missing) };
            let [x, y] = seen.xy;
            // Writing to a string cannot fail.
            let _ = writeln!(observations, "{camera} {number} {x:e} {y:e}");
        }
    }
    let counts =
        [geometry.images.len(), geometry.points.len(), geometry.points.observation_count()];
    let [images, seen_points, count] = counts;
    Ok(format!("{images} {seen_points} {count}\n{observations}{cameras}{points}"))
}

fn lines(text: &mut String, numbers: &[f64]) {
    for number in numbers {
        let _ = writeln!(text, "{number:e}");
    }
}
