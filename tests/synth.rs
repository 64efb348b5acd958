//! Synthetic reconstructions: exact where they claim to be, off by what they claim, the same for the same seed.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use calibstab::camera::{MODELS, Model};
use calibstab::colmap;
use calibstab::scene::{Camera, Geometry, Scene};
use calibstab::synth::{Options, SynthError, Views, World, camera, make};
use nalgebra::{Quaternion, UnitQuaternion, Vector2, Vector3};
use tempfile::TempDir;

fn with_camera(model: &Model) -> Options {
    let cameras = vec![camera(model, 640, 480).unwrap()];
    Options { cameras, image_count: 12, point_count: 800, start_off: 0.0, ..Options::default() }
}

fn geometry(scene: &Scene) -> &Geometry {
    scene.geometry.as_ref().unwrap()
}

/// What one observation is off by, in px; none where the camera does not see the point. And the angle off +Z.
fn residuals(scene: &Scene) -> Vec<(Option<Vector2<f64>>, f64)> {
    let Geometry { images, points, .. } = geometry(scene);
    let mut residuals = Vec::new();
    for point in points.iter() {
        for element in point.track {
            let image = &images[&element.image];
            let [w, x, y, z] = image.cam_from_world.quaternion;
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
            let shift = Vector3::from(image.cam_from_world.translation);
            let seen = turn * Vector3::from(point.xyz) + shift;
            let pixel = scene.cameras[&image.camera].intrinsics.project(&seen).ok();
            let keypoint = image.keypoints.get(element.keypoint as usize).unwrap();
            assert_eq!(keypoint.point, Some(point.id));
            let angle = seen.angle(&Vector3::z());
            residuals.push((pixel.map(|pixel| pixel - Vector2::from(keypoint.xy)), angle));
        }
    }
    residuals
}

#[test]
fn without_noise_every_model_projects_to_its_pixels_and_with_noise_beside_them_by_it() {
    let mut beyond_90_degrees = 0;
    for model in MODELS {
        let exact = make(&Options { noise_px: 0.0, ..with_camera(model) }).unwrap();
        assert_eq!(exact.run, exact.truth, "{}", model.name);
        let seen = residuals(&exact.truth);
        assert!(seen.len() > 500, "{}: {}", model.name, seen.len());
        for (residual, _) in &seen {
            assert!(residual.unwrap().norm() < 1e-10, "{}: {residual:?}", model.name);
        }
        let looks_ahead = seen.iter().any(|(_, angle)| *angle < 0.5);
        let wide = seen.iter().any(|(_, angle)| *angle > FRAC_PI_2 && *angle < PI);
        beyond_90_degrees += usize::from(looks_ahead && wide);

        let noisy = make(&Options { noise_px: 0.5, ..with_camera(model) }).unwrap();
        assert_eq!(noisy.truth, exact.truth, "{}", model.name);
        let errors: Vec<f64> =
            residuals(&noisy.run).iter().map(|(residual, _)| residual.unwrap().norm()).collect();
        // A Rayleigh distribution: mean sigma sqrt(pi / 2), variance sigma^2 (2 - pi / 2). Once in 15 000, 4 deviations.
        let (n, mean) = (errors.len() as f64, errors.iter().sum::<f64>() / errors.len() as f64);
        let off = (mean - 0.5 * FRAC_PI_2.sqrt()) / (0.5 * (2.0 - FRAC_PI_2).sqrt() / n.sqrt());
        assert!(off.abs() < 4.0, "{}: {mean} is {off} deviations off", model.name);
        let of_points: Vec<f64> = geometry(&noisy.run).points.iter().map(|p| p.error_px).collect();
        let tracks = geometry(&noisy.run).points.iter().map(|point| point.track.len() as f64);
        let again: f64 = of_points.iter().zip(tracks).map(|(error, length)| error * length).sum();
        assert!((again / n / mean - 1.0).abs() < 1e-9, "{}", model.name);
    }
    assert!(beyond_90_degrees >= 8, "{beyond_90_degrees}");
}

#[test]
fn a_start_is_off_by_what_was_asked_for_and_its_principal_point_is_not() {
    let mut options = Options { start_off: 0.01, noise_px: 0.0, ..with_camera(&MODELS[1]) };
    options.cameras = vec![options.cameras[0]; 40];
    options.image_count = 400;
    let made = make(&options).unwrap();
    let rms = |values: &[f64]| {
        let squares = values.iter().map(|value| value * value).sum::<f64>();
        (values.len(), (squares / values.len() as f64).sqrt())
    };
    let mut focal = Vec::new();
    for (id, Camera { intrinsics: of_truth, .. }) in &made.truth.cameras {
        let (truth, start) = (of_truth.params(), made.run.cameras[id].intrinsics.params());
        assert_eq!(truth[2..], start[2..]);
        focal.extend([start[0] / truth[0] - 1.0, start[1] / truth[1] - 1.0]);
    }
    let (truth, start) = (geometry(&made.truth), geometry(&made.run));
    let places = truth.points.iter().zip(start.points.iter());
    let places: Vec<f64> =
        places.flat_map(|(a, b)| [0, 1, 2].map(|axis| a.xyz[axis] - b.xyz[axis])).collect();
    let turn = |geometry: &Geometry| -> Vec<UnitQuaternion<f64>> {
        let turn =
            |[w, x, y, z]: [f64; 4]| UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        geometry.images.values().map(|image| turn(image.cam_from_world.quaternion)).collect()
    };
    let turns: Vec<f64> = turn(truth)
        .iter()
        .zip(&turn(start))
        .flat_map(|(a, b)| -> [f64; 3] { (b * a.inverse()).scaled_axis().into() })
        .collect();
    // A standard deviation of n numbers is known to 1 / sqrt(2 n) of itself.
    for (values, want) in [(&focal, 0.01), (&places, 0.01), (&turns, 0.001)] {
        let (n, found) = rms(values);
        let allowed = 4.0 / (2.0 * n as f64).sqrt();
        assert!(n >= 80 && (found / want - 1.0).abs() < allowed, "{n}: {found}, want {want}");
    }
}

#[test]
fn what_is_left_out_is_said_and_what_is_kept_is_seen_often_enough() {
    let made =
        make(&Options { point_count: 3000, least_track: 3, ..with_camera(&MODELS[0]) }).unwrap();
    let points = &geometry(&made.truth).points;
    assert!(points.len() > 100 && points.iter().all(|point| point.track.len() >= 3));
    let left_out: usize = made.remarks[0].split(' ').next().unwrap().parse().unwrap();
    assert!(made.remarks[0].ends_with("seen by fewer than 3 images and left out"));
    let all =
        make(&Options { point_count: 3000, least_track: 1, ..with_camera(&MODELS[0]) }).unwrap();
    assert_eq!(geometry(&all.truth).points.len(), points.len() + left_out);
    assert!(all.remarks.is_empty(), "{:?}", all.remarks);

    let mut few = with_camera(&MODELS[0]);
    few.cameras = vec![few.cameras[0]; 3];
    let few = make(&Options { image_count: 1, ..few }).unwrap();
    assert_eq!(few.truth.cameras.len(), 3);
    assert_eq!(geometry(&few.truth).points.len(), 0);
    let said = few.remarks.join("\n");
    assert!(
        said.contains("2 cameras took no image") && said.contains("1 images see nothing"),
        "{said}"
    );
}

#[test]
fn the_widest_angle_and_the_most_points_of_an_image_are_kept_to() {
    let wide = Model::named("OPENCV_FISHEYE").unwrap();
    let degrees = |widest_degrees: f64| {
        let options = Options { widest_degrees, most_per_image: 50, ..with_camera(wide) };
        let made = make(&options).unwrap();
        let images = &geometry(&made.truth).images;
        assert!(images.values().all(|image| (1..=50).contains(&image.keypoints.len())));
        let angles = residuals(&made.truth).into_iter().map(|(_, angle)| angle.to_degrees());
        (angles.fold(0.0, f64::max), made.remarks.iter().any(|r| r.contains("90 degrees")))
    };
    let (all, some) = (degrees(180.0), degrees(80.0));
    assert!(all.0 > 95.0 && all.1, "{all:?}");
    assert!((75.0..=80.0).contains(&some.0) && !some.1, "{some:?}");
}

#[test]
fn runs_share_the_room_and_on_request_the_views() {
    let run = |run: u32, own_views: bool| {
        make(&Options { run, own_views, noise_px: 0.5, ..with_camera(&MODELS[0]) }).unwrap()
    };
    let (first, second, same) = (run(0, true), run(1, true), run(1, false));
    let names = |scene: &Scene| -> Vec<String> {
        geometry(scene).images.values().map(|image| image.name.clone()).collect()
    };
    assert_eq!(names(&first.run)[0], "camera1/00001.png");
    assert_eq!(names(&second.run)[0], "camera1/00013.png");
    assert_eq!(first.truth, same.truth);
    assert!(first.run != same.run && second.run != same.run);
    let places = |scene: &Scene| -> Vec<[u64; 3]> {
        geometry(scene).points.iter().map(|point| point.xyz.map(f64::to_bits)).collect()
    };
    let (ours, theirs) = (places(&first.truth), places(&second.truth));
    let shared = ours.iter().filter(|place| theirs.contains(place)).count();
    assert!(shared * 2 > ours.len(), "{shared} of {}", ours.len());
}

#[test]
fn other_views_and_worlds_are_made_of_the_same_options() {
    let mut made = 0;
    for views in [Views::Ring, Views::Forward, Views::Rotation] {
        for world in [World::Room, World::Plane] {
            let options = Options { views, world, point_count: 3000, ..with_camera(&MODELS[1]) };
            let scene = make(&Options { noise_px: 0.0, ..options }).unwrap().truth;
            let seen = residuals(&scene);
            assert!(seen.len() > 200, "{views:?} {world:?}: {}", seen.len());
            assert!(seen.iter().all(|(residual, _)| residual.unwrap().norm() < 1e-10));
            made += 1;
        }
    }
    assert_eq!(made, 6);
}

#[test]
fn what_cannot_be_made_is_refused() {
    let refused = |options: Options| make(&options).unwrap_err();
    let none = Options { cameras: Vec::new(), ..Options::default() };
    assert_eq!(refused(none), SynthError::NoCamera);
    let noise = refused(Options { noise_px: f64::NAN, ..Options::default() });
    assert_eq!(noise.to_string(), "the noise is NaN, expected a number from 0 on");
    assert!(make(&Options { start_off: -0.1, ..Options::default() }).is_err());
}

fn calibstab(args: &[&str], out: &Path) -> Output {
    let mut command = Command::cargo_bin("calibstab").unwrap();
    command.args(args).args(["--out".as_ref(), out.as_os_str()]).output().unwrap()
}

/// All files below a folder with their content, by their path in it.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = PathBuf::from(path.file_name().unwrap());
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(below, bytes)| (name.join(below), bytes)));
        } else {
            found.insert(name, fs::read(&path).unwrap());
        }
    }
    found
}

const SMALL: [&str; 9] =
    ["synth", "--images", "12", "--points", "500", "--size", "640x480", "--per-image", "100"];

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_one_others() {
    let folder = TempDir::new().unwrap();
    let made = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let output = calibstab(&[&SMALL, more].concat(), &out);
        assert!(output.status.success() && output.stdout.is_empty(), "{output:?}");
        files(&out)
    };
    let (first, again) = (made("a", &["--repeats", "2"]), made("b", &["--repeats", "2"]));
    assert_eq!(first.len(), 20);
    assert!(first == again);
    let other = made("c", &["--repeats", "2", "--seed", "2"]);
    assert!(first.keys().eq(other.keys()));
    for (path, content) in &first {
        let is_truth = path.components().any(|part| part.as_os_str() == "truth");
        let name = path.file_name().unwrap().to_str().unwrap();
        if ["images.txt", "points3D.txt"].contains(&name) || name == "cameras.txt" && !is_truth {
            assert!(other[path] != *content, "{}", path.display());
        }
    }
    // A third run changes none of the others, and the same model in the folder itself is the first run.
    let three = made("d", &["--repeats", "3"]);
    assert!(first.iter().all(|(path, content)| three[path] == *content));
    let alone = made("e", &[]);
    assert!(alone["images.txt".as_ref() as &Path] == first["run1/images.txt".as_ref() as &Path]);
}

#[test]
fn analyze_reads_the_runs_and_takes_no_truth_for_one() {
    let folder = TempDir::new().unwrap();
    let runs = folder.path().join("runs");
    let cameras = ["--camera", "OPENCV", "--camera", "SIMPLE_RADIAL:500,320,240,-0.1"];
    let more = ["--repeats", "3", "--binary"];
    assert!(calibstab(&[&SMALL[..], &cameras, &more].concat(), &runs).status.success());
    let report = folder.path().join("report");
    let output =
        calibstab(&["analyze", runs.to_str().unwrap(), "--no-refine", "--format", "json"], &report);
    assert!(output.status.success(), "{output:?}");
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(report.join("analysis.json")).unwrap()).unwrap();
    assert_eq!(json["runs"].as_array().unwrap().len(), 3);
    let populations = json["populations"].as_array().unwrap();
    assert_eq!(populations.len(), 2);
    for population in populations {
        let focal = &population["parameters"][0]["statistics"];
        assert_eq!(focal["n"], 3);
        assert!(focal["std"].as_f64().unwrap() > 0.5, "{focal}");
    }
    let truth = colmap::read(&runs.join("run2/truth")).unwrap();
    let second = truth.cameras.values().nth(1).unwrap();
    assert_eq!(second.intrinsics.params(), [500.0, 320.0, 240.0, -0.1]);
}

#[test]
fn the_command_refuses_what_makes_no_sense_and_runs_that_would_mix_with_older_ones() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("new");
    for (args, want) in [
        (&["--camera", "OPENCV_FISHEY"] as &[&str], "did you mean OPENCV_FISHEYE?"),
        (&["--camera", "PINHOLE:1,2,3"], "PINHOLE takes 4 parameters, found 3"),
        (&["--camera", "PINHOLE:1,2,3,x"], "`x` is not a number"),
        (&["--camera", "PINHOLE:1,2,3,inf"], "not finite"),
        (&["--size", "640"], "such as 1280x960"),
        (&["--size", "0x480"], "such as 1280x960"),
        (&["--images", "0"], "0"),
        (&["--noise", "nan"], "the noise is NaN"),
        (&["--same-views"], "--repeats"),
    ] {
        let output = calibstab(&[&["synth"], args].concat(), &out);
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(errors.contains(want) && output.stdout.is_empty(), "{args:?}: {errors}");
        assert!(!out.exists());
    }
    let repeats = |count: &str| calibstab(&[&SMALL[..], &["--repeats", count]].concat(), &out);
    assert!(repeats("3").status.success() && repeats("3").status.success());
    let output = repeats("2");
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(errors.contains("run3"), "{errors}");
}
