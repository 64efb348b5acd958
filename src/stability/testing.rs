//! Runs for the tests of this room.

use std::collections::BTreeMap;

use super::Run;
use crate::camera::Model;
use crate::scene::{Camera, CameraId, Geometry, Image, ImageId, Keypoints, Points3D, Pose, Scene};

/// A run with these cameras and no images.
pub(super) fn run(group: &str, name: &str, cameras: &[(u32, &str, &[f64])]) -> Run {
    let camera = |&(id, model, params): &(u32, &str, &[f64])| {
        let intrinsics = Model::named(model).unwrap().with_params(params).unwrap();
        (CameraId(id), Camera { intrinsics, width: 1280, height: 960 })
    };
    let cameras = cameras.iter().map(camera).collect();
    let scene = Scene { cameras, geometry: None };
    let (group, name) = (group.to_owned(), name.to_owned());
    Run { group, name, files: vec![], remarks: vec![], scene, refinement: None, inside: None }
}

/// The run with images: each camera's id and the names it took.
pub(super) fn with_images(mut run: Run, taken: &[(u32, &[&str])]) -> Run {
    let pose = Pose { quaternion: [1.0, 0.0, 0.0, 0.0], translation: [0.0; 3] };
    let names = taken.iter().flat_map(|(camera, names)| names.iter().map(|name| (*camera, *name)));
    let images: BTreeMap<ImageId, Image> = (1..)
        .zip(names)
        .map(|(id, (camera, name))| {
            let (name, camera) = (name.to_owned(), CameraId(camera));
            let keypoints = Keypoints::default();
            (ImageId(id), Image { name, camera, cam_from_world: pose, keypoints })
        })
        .collect();
    run.scene.geometry = Some(Geometry { images, points: Points3D::default(), mounting: None });
    run
}

/// Runs of one SIMPLE_RADIAL camera with these focal lengths and distortions.
pub(super) fn simple_radial(group: &str, values: &[[f64; 2]]) -> Vec<Run> {
    (1..)
        .zip(values)
        .map(|(number, [f, k])| {
            run(group, &format!("run{number}"), &[(1, "SIMPLE_RADIAL", &[*f, 640.0, 480.0, *k])])
        })
        .collect()
}
