//! Every real reconstruction that we have reads, and the same one in two forms reads the same.

use std::collections::BTreeMap;
use std::path::PathBuf;

use calibstab::colmap::{Form, ModelFiles, find, read};
use calibstab::scene::{Geometry, Image, ImageId, Keypoint, Point3DId, Points3D, Scene};

/// The folder of models, which is not part of the package.
#[allow(clippy::print_stderr)] // a test that is skipped says so
fn data() -> Option<PathBuf> {
    let shared = match std::env::var_os("CALIBSTAB_SHARED") {
        Some(shared) => PathBuf::from(shared),
        None => PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared")),
    };
    let data = shared.join("data");
    if !data.is_dir() {
        eprintln!("skipped: no {}; CALIBSTAB_SHARED names the folder above it", data.display());
        return None;
    }
    Some(data)
}

fn geometry(scene: &Scene) -> &Geometry {
    let Some(geometry) = &scene.geometry else { panic!("no images and points") };
    geometry
}

/// What the faces for models larger than memory hand out.
fn one_by_one(model: &ModelFiles) -> (BTreeMap<ImageId, Image>, Points3D) {
    let (mut images, mut points) = (BTreeMap::new(), Points3D::default());
    let read = model
        .for_each_image(|id, image| assert!(images.insert(id, image).is_none()))
        .and_then(|()| model.for_each_point(|point| points.push(point)));
    read.unwrap_or_else(|error| panic!("{error}"));
    (images, points)
}

#[test]
fn every_model_reads() {
    let Some(data) = data() else { return };
    let models = find(&data).expect("models");
    let (mut binary_count, mut mounted_count, mut observation_count) = (0, 0, 0);
    for model in &models {
        let scene = model.read().unwrap_or_else(|error| panic!("{error}"));
        let geometry = geometry(&scene);
        let keypoints = geometry.images.values().flat_map(|image| image.keypoints.iter());
        let seen = keypoints.filter(|keypoint| keypoint.point.is_some()).count();
        assert_eq!(seen, geometry.points.observation_count(), "{}", model.run().display());
        assert!(seen > 0, "{}", model.run().display());
        observation_count += seen;
        binary_count += usize::from(model.form == Form::Binary);
        mounted_count += usize::from(geometry.mounting.is_some());
        assert_eq!(model.paths().count(), if geometry.mounting.is_some() { 5 } else { 3 });
        let (images, points) = one_by_one(model);
        assert!(images == geometry.images && points == geometry.points, "{model:?}");
    }
    assert_eq!((models.len(), binary_count, mounted_count), (83, 3, 81));
    assert!(observation_count > 500_000, "{observation_count}");
}

/// Everything that does not depend on the order of the file, but the mounting.
fn content(scene: &Scene) -> impl PartialEq + std::fmt::Debug {
    let geometry = geometry(scene);
    let points: BTreeMap<Point3DId, _> = geometry
        .points
        .iter()
        .map(|point| (point.id, (point.xyz, point.rgb, point.track.collect::<Vec<_>>())))
        .collect();
    let keypoints: Vec<Keypoint> =
        geometry.images.values().flat_map(|image| image.keypoints.iter()).collect();
    let images: Vec<_> = geometry
        .images
        .iter()
        .map(|(&id, image)| (id, image.name.clone(), image.camera, image.cam_from_world))
        .collect();
    (scene.cameras.clone(), images, keypoints, points)
}

#[test]
fn one_model_in_two_forms_is_one_scene_apart_from_its_mounting() {
    let Some(data) = data() else { return };
    let formats = data.join("formats");
    let scene = |name: &str| read(&formats.join(name)).unwrap_or_else(|error| panic!("{error}"));
    let twins = [("text_legacy", "text_same_as_legacy"), ("binary_legacy", "binary")];
    for (legacy, new) in twins {
        let (legacy, new) = (scene(legacy), scene(new));
        assert!(content(&legacy) == content(&new));
        assert!(geometry(&legacy).mounting.is_none() && geometry(&new).mounting.is_some());
    }
    let (crlf, lf) = (scene("text_crlf"), scene("text_same_as_legacy"));
    assert!(content(&crlf) == content(&lf));
    assert_eq!(geometry(&crlf).mounting, geometry(&lf).mounting);
}

#[test]
fn the_odd_model_keeps_its_empty_image_and_its_unused_camera() {
    let Some(data) = data() else { return };
    let scene = read(&data.join("formats/text_odd")).unwrap_or_else(|error| panic!("{error}"));
    let ids: Vec<u32> = scene.cameras.keys().map(|id| id.0).collect();
    assert_eq!(ids, [1, 2, 77]);
    let counts: Vec<usize> =
        geometry(&scene).images.values().map(|image| image.keypoints.len()).collect();
    assert_eq!(counts[0], 0);
    assert!(counts[1..].iter().all(|&count| count > 0));
}
