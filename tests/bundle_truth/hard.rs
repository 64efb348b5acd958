//! Hard scenes: what they determine is found, and the rest is said.

use std::path::{Path, PathBuf};

use calibstab::bundle::{Adjusted, Loss, Options};
use calibstab::colmap;
use calibstab::least_squares;
use calibstab::scene::{CameraId, Geometry, ImageId, Point3D, Point3DId, Points3D, Scene};
use calibstab::synth::{self, Synthetic, Views, World};
use nalgebra::{UnitQuaternion, Vector3};

use super::{adjust, all_free, excess, largest};

fn room(world: World, views: Views, image_count: u32) -> Synthetic {
    let options = synth::Options {
        image_count,
        point_count: 800,
        most_per_image: 200,
        start_off: 0.005,
        world,
        views,
        ..synth::Options::default()
    };
    synth::make(&options).unwrap()
}

/// The largest error of an intrinsic in stds, and the std of the focal length.
fn errors(adjusted: &Adjusted, truth: &Scene) -> (f64, f64) {
    let covariance = adjusted.outcome.covariance.as_ref().unwrap();
    let stds = covariance.stds().unwrap();
    let off = excess(&adjusted.scene, truth, covariance);
    (largest(off.iter().zip(&stds).map(|(off, std)| off / std)), stds[0])
}

#[test]
fn scenes_that_determine_little_give_honest_stds() {
    let Synthetic { truth, run, .. } = room(World::Room, Views::Ring, 16);
    let (_, room_std) = errors(&adjust(&run, &all_free()), &truth);
    let mut checked = 0;
    // With principal points held, as COLMAP has it; how many times worse focal lengths are determined, at least.
    for (what, world, views, image_count, worse) in [
        ("a plane", World::Plane, Views::Ring, 16, 1.0),
        ("forward motion", World::Room, Views::Forward, 16, 10.0),
        ("two images", World::Room, Views::Ring, 2, 100.0),
    ] {
        let Synthetic { truth, run, .. } = room(world, views, image_count);
        let adjusted = adjust(&run, &Options::default());
        assert_eq!(adjusted.outcome.rank, adjusted.outcome.unknowns, "{what}");
        let (off, std) = errors(&adjusted, &truth);
        assert!(off < 4.0, "{what}: {off:.1} std");
        assert!(std > worse * room_std, "{what}: {std} px, in a room {room_std}");
        checked += 1;
    }
    assert_eq!(checked, 3);
}

#[test]
fn pure_rotation_tells_focal_lengths_and_that_depths_are_open() {
    let Synthetic { truth, run, .. } = room(World::Room, Views::Rotation, 16);
    let adjusted = adjust(&run, &Options::default());
    let outcome = &adjusted.outcome;
    assert!(outcome.cost < outcome.initial_cost && outcome.rank < outcome.unknowns);
    let [found, want] =
        [&adjusted.scene, &truth].map(|scene| scene.cameras[&CameraId(1)].intrinsics.params()[0]);
    assert!((found / want - 1.0).abs() < 0.01, "{found}, truth {want}");
}

/// The real models, which are not part of the package.
#[allow(clippy::print_stderr)] // a test that is skipped says so
fn data() -> Option<PathBuf> {
    let shared = match std::env::var_os("CALIBSTAB_SHARED") {
        Some(shared) => PathBuf::from(shared),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
    };
    let data = shared.join("data");
    if !data.is_dir() {
        eprintln!("skipped: no {}; CALIBSTAB_SHARED names the folder above it", data.display());
        return None;
    }
    Some(data)
}

#[test]
fn runs_that_failed_are_adjusted_and_absurd_cameras_called_no_real_lens() {
    let Some(data) = data() else { return };
    let stop = least_squares::Options { max_iterations: 25, ..Default::default() };
    let mut checked = 0;
    for (run, is_bogus) in [
        ("failed_runs/castle_p30_opencv_exh_subsets_run01", true),
        ("failed_runs/euroc_v1_a_opencv_exh_2cam_run01", true),
        // It broke off, but what there is of it is sound.
        ("failed_runs/euroc_v1_a_opencv_exh_2cam_run03", false),
        ("euroc_v1_a/opencv_exh_2cam/run04", true),
    ] {
        let scene = colmap::find_one(&data.join(run)).unwrap().read().unwrap();
        for loss in [Loss::Squared, Loss::Cauchy(1.0)] {
            let outcome = adjust(&scene, &Options { loss, stop, ..Options::default() }).outcome;
            assert!(outcome.cost.is_finite() && outcome.cost <= outcome.initial_cost, "{run}");
            for camera in &outcome.cameras {
                assert!(camera.after.intrinsics.params().iter().all(|value| value.is_finite()));
                let why = &camera.implausible;
                assert_eq!(why.is_some(), is_bogus, "{run} {why:?}");
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 14);
}

/// A scene beside it, of another camera, whose every camera and point is within 1e-12 of one place.
fn with_collapsed_cluster(scene: &Scene) -> Scene {
    let mut both = scene.clone();
    let camera = CameraId(50);
    let image_id = |id: ImageId| ImageId(id.0 + 500);
    let point_id = |id: Point3DId| Point3DId(id.0 + 100_000);
    both.cameras.insert(camera, scene.cameras[&CameraId(1)]);
    let Geometry { images, points, .. } = scene.geometry.as_ref().unwrap();
    let mut all = Points3D::default();
    points.iter().for_each(|p| {
        let Point3D { id, xyz, rgb, error_px, track } = p;
        all.push(Point3D { id, xyz, rgb, error_px, track: track.collect::<Vec<_>>() });
    });
    let place = Vector3::new(0.3, -0.2, 0.7);
    let shrunk = |xyz: [f64; 3]| -> [f64; 3] { (place + Vector3::from(xyz) * 1e-13).into() };
    let target = both.geometry.as_mut().unwrap();
    target.mounting = None;
    for (&id, image) in images {
        let mut copy = image.clone();
        copy.camera = camera;
        let [w, x, y, z] = image.cam_from_world.quaternion;
        let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        let centre = -(turn.inverse() * Vector3::from(image.cam_from_world.translation));
        let centre = Vector3::from(shrunk(centre.into()));
        copy.cam_from_world.translation = (-(turn * centre)).into();
        copy.keypoints.clear();
        for mut keypoint in image.keypoints.iter() {
            keypoint.point = keypoint.point.map(point_id);
            copy.keypoints.push(keypoint);
        }
        target.images.insert(image_id(id), copy);
    }
    for Point3D { id, xyz, rgb, error_px, track } in points.iter() {
        let track: Vec<_> = track
            .map(|mut element| {
                element.image = image_id(element.image);
                element
            })
            .collect();
        all.push(Point3D { id: point_id(id), xyz: shrunk(xyz), rgb, error_px, track });
    }
    target.points = all;
    both
}

#[test]
fn a_collapsed_cluster_of_cameras_and_points_does_not_disturb_the_rest() {
    let mut scene = room(World::Room, Views::Ring, 16).run;
    scene.geometry.as_mut().unwrap().mounting = None;
    let alone = adjust(&scene, &Options::default());
    let both = adjust(&with_collapsed_cluster(&scene), &Options::default());
    let outcome = &both.outcome;
    assert_eq!(outcome.components, 2);
    assert!(outcome.cost.is_finite() && outcome.cost <= outcome.initial_cost);
    let covariance = alone.outcome.covariance.as_ref().unwrap();
    let stds = covariance.stds().unwrap();
    let off = excess(&both.scene, &alone.scene, covariance);
    let off = largest(off.iter().zip(&stds).map(|(off, std)| off / std));
    assert!(off < 1e-3, "{off:.1e}");
}
