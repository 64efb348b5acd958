//! Bundle Adjustment in the Large: a real problem, read, written and copied.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use calibstab::bal;
use calibstab::bundle::{self, Refine, Which};
use calibstab::camera::ParamClass;
use calibstab::least_squares::Reason;
use calibstab::scene::{CameraId, Scene};
use calibstab::{colmap, synth};
use nalgebra::{Quaternion, UnitQuaternion, Vector2, Vector3};

/// The real problem, which is not part of the package.
#[allow(clippy::print_stderr)] // a test that is skipped says so
fn problem() -> Option<PathBuf> {
    let shared = match std::env::var_os("CALIBSTAB_SHARED") {
        Some(shared) => PathBuf::from(shared),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
    };
    let file = shared.join("data/bal/problem-16-22106-pre.txt");
    if !file.is_file() {
        eprintln!("skipped: no {}; CALIBSTAB_SHARED names the folder shared", file.display());
        return None;
    }
    Some(file)
}

/// Half the sum of squared residuals, and how many there are.
fn cost(scene: &Scene) -> (f64, usize) {
    let geometry = scene.geometry.as_ref().unwrap();
    let (mut sum, mut count) = (0.0, 0);
    for point in geometry.points.iter() {
        for element in point.track {
            let image = &geometry.images[&element.image];
            let [w, x, y, z] = image.cam_from_world.quaternion;
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
            let seen =
                turn * Vector3::from(point.xyz) + Vector3::from(image.cam_from_world.translation);
            let pixel = scene.cameras[&image.camera].intrinsics.project(&seen).unwrap();
            let observed = image.keypoints.get(element.keypoint as usize).unwrap();
            sum += (pixel - Vector2::from(observed.xy)).norm_squared();
            count += 1;
        }
    }
    (sum / 2.0, count)
}

#[test]
fn the_initial_cost_of_a_real_problem_is_what_ceres_prints() {
    let Some(file) = problem() else { return };
    let scene = bal::read(&file).unwrap();
    let (cost, count) = cost(&scene);
    assert_eq!((scene.cameras.len(), count), (16, 83_718));
    assert!((cost - 4.185660e+06).abs() <= 0.5, "{cost}");
}

#[test]
fn adjustment_ends_where_ceres_does() {
    let Some(file) = problem() else { return };
    let all = [ParamClass::Focal, ParamClass::Extra].map(Which::Class).to_vec();
    let refine = Refine { others: all, ..Refine::default() };
    let options = bundle::Options { refine, ..bundle::Options::default() };
    let adjusted = bundle::adjust(bal::read(&file).unwrap(), &options, &mut |_| {}).unwrap();
    let outcome = adjusted.outcome;
    assert_eq!((outcome.reason, outcome.observations), (Reason::Converged, 83_718));
    assert!((outcome.initial_cost - 4.185660e+06).abs() <= 0.5, "{}", outcome.initial_cost);
    // Ceres prints 1.803390e+04.
    assert!((outcome.cost - 1.803390e+04).abs() <= 0.005, "{}", outcome.cost);
    assert!((cost(&adjusted.scene).0 / outcome.cost - 1.0).abs() < 1e-9);
}

#[test]
fn a_real_problem_comes_back_from_its_scene_number_by_number() {
    let Some(file) = problem() else { return };
    let text = fs::read_to_string(&file).unwrap();
    let back = bal::encode(&bal::read(&file).unwrap()).unwrap();
    let (mut words, mut of_back) = (text.split_whitespace(), back.split_whitespace());
    let first_of_cameras = 3 + 4 * 83_718;
    let mut rotations = 0;
    for index in 0.. {
        let (Some(word), Some(again)) = (words.next(), of_back.next()) else { break };
        let (number, again): (f64, f64) = (word.parse().unwrap(), again.parse().unwrap());
        let is_rotation = (first_of_cameras..first_of_cameras + 9 * 16).contains(&index)
            && (index - first_of_cameras) % 9 < 3;
        // Rotations go by way of quaternions, which keep them to some roundings of 1.
        let allowed = if is_rotation { 1e-15 } else { 0.0 };
        assert!((number - again).abs() <= allowed, "number {index}: {number} became {again}");
        rotations += usize::from(is_rotation);
    }
    assert!(rotations == 48 && words.next().is_none() && of_back.next().is_none());
}

#[test]
fn copy_reads_a_problem_and_says_that_colmap_will_not_read_its_cameras() {
    let folder = tempfile::tempdir().unwrap();
    let (problem, out) = (folder.path().join("problem.txt"), folder.path().join("out"));
    let text = "1 2 2\n0 0 -1.5 2\n0 1 3 -4\n0.1 0 0 0 0 -5 500 -0.1 0.01\n0 0 0\n1 1 1\n";
    fs::write(&problem, text).unwrap();
    let copy = |form: &str| {
        let mut command = Command::cargo_bin("calibstab").unwrap();
        command.arg("copy").args([&problem, &out]).arg(form).output().unwrap()
    };
    let done = copy("--text");
    assert!(done.status.success());
    let talk = String::from_utf8(done.stderr).unwrap();
    assert!(talk.contains("BAL_STRICT is calibstab's own, COLMAP will not read"), "{talk}");
    let copied = colmap::read(&out).unwrap();
    assert_eq!(copied, bal::read(&problem).unwrap());
    assert_eq!(copied.cameras[&CameraId(1)].intrinsics.params(), [500.0, -0.1, 0.01]);
    assert_eq!(copy("--binary").status.code(), Some(2));

    fs::write(&problem, text.replace("0 1 3", "0 2 3")).unwrap();
    let refused = copy("--text");
    let errors = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(errors.contains("problem.txt:3:3: the point of observation 1 is 2"), "{errors}");
}

#[test]
fn a_scene_that_the_format_cannot_hold_is_refused() {
    let mut options = synth::Options { image_count: 4, point_count: 2000, ..Default::default() };
    let run = |options: &synth::Options| synth::make(options).unwrap().run;
    assert_eq!(bal::encode(&run(&options)), Err(bal::WriteError::Rigs));
    let without_rigs = |mut scene: Scene| {
        scene.geometry.as_mut().unwrap().mounting = None;
        scene
    };
    let other = bal::encode(&without_rigs(run(&options))).unwrap_err();
    assert!(other.to_string().contains("a camera of model OPENCV"), "{other}");
    let strict = calibstab::camera::Model::named("BAL_STRICT").unwrap();
    options.cameras = vec![synth::camera(strict, 640, 480).unwrap()];
    let scene = without_rigs(run(&options));
    let back = bal::parse(bal::encode(&scene).unwrap().as_bytes()).unwrap();
    let (before, after) = (cost(&scene), cost(&back));
    assert!(before.1 > 200 && before.1 == after.1);
    assert!((before.0 / after.0 - 1.0).abs() < 1e-12, "{before:?} {after:?}");
    let alone = Scene { geometry: None, ..scene };
    assert_eq!(bal::encode(&alone), Err(bal::WriteError::NoGeometry));
}
