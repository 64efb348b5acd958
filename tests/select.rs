//! `select` as its user types it, and its room against numbers made with numpy and checked with pycolmap.

// Helpers of tests, which the allowance for tests in clippy.toml does not reach.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use calibstab::bundle::Refine;
use calibstab::colmap;
use calibstab::selection::{Candidates, HEURISTICS, Heuristic, Request, Unit, elimination_order};
use nalgebra::DMatrix;
use serde_json::Value;
use tempfile::TempDir;

/// The folder of 40 images and its targets, which is not part of the package.
#[allow(clippy::print_stderr)] // a test that is skipped says so
fn selection40() -> Option<(Candidates, Value)> {
    let shared = match std::env::var_os("CALIBSTAB_SHARED") {
        Some(shared) => PathBuf::from(shared),
        None => PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared")),
    };
    let folder = shared.join("data/selection40");
    if !folder.is_dir() {
        eprintln!("skipped: no {}; CALIBSTAB_SHARED names the folder above", folder.display());
        return None;
    }
    let scene = colmap::read(&folder.join("model")).unwrap();
    let targets = serde_json::from_slice(&fs::read(folder.join("targets.json")).unwrap()).unwrap();
    Some((Candidates::new(&scene, Refine::all(), 0.5).unwrap(), targets))
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn places(value: &Value) -> Vec<usize> {
    list(value).iter().map(|it| usize::try_from(it.as_u64().unwrap()).unwrap()).collect()
}

fn error_px(candidates: &Candidates, images: &[usize]) -> f64 {
    let information = candidates.information(images);
    candidates.mapping_error(&information, candidates.cameras()).unwrap().sqrt()
}

fn is_near(found: f64, wanted: f64) -> bool {
    (found / wanted - 1.0).abs() < 1e-8
}

#[test]
fn what_subsets_of_forty_images_tell_is_what_numpy_finds() {
    let Some((candidates, targets)) = selection40() else { return };
    let names: Vec<&str> = list(&targets["images"]).iter().map(|it| it.as_str().unwrap()).collect();
    let subsets = targets["subsets"].as_object().unwrap();
    for (name, subset) in subsets {
        let of_name = |image: &Value| names.iter().position(|name| image == name).unwrap();
        let images: Vec<usize> = list(&subset["images"]).iter().map(of_name).collect();
        assert!(images.iter().all(|&image| candidates.name(image) == names[image]));
        let information = candidates.information(&images);
        let covariance = information.covariance(&[0, 1, 2, 3]).unwrap();
        let wanted =
            DMatrix::from_fn(4, 4, |row, column| number(&subset["covariance"][row][column]));
        for (row, column) in (0..16).map(|at| (at / 4, at % 4)) {
            let off = covariance[(row, column)] - wanted[(row, column)];
            let scale = (wanted[(row, row)] * wanted[(column, column)]).sqrt();
            assert!(off.abs() < 1e-8 * scale, "{name} {row} {column}: {off:e}");
        }
        let log_det = information.log_det().unwrap();
        assert!((log_det - number(&subset["log_det_information"])).abs() < 1e-8, "{name}");
        assert!(is_near(error_px(&candidates, &images), number(&subset["sqrt_eme_px"])), "{name}");
    }
    assert_eq!(subsets.len(), 10);
    let mut count = 0;
    for size in ["8", "12", "20"] {
        for draw in list(&targets["random_subsets"][size]["draws"]) {
            let found = error_px(&candidates, &places(&draw["images"]));
            assert!(is_near(found, number(&draw["sqrt_eme_px"])), "{draw}: {found}");
            count += 1;
        }
    }
    assert_eq!(count, 600);
    assert!(candidates.information(&[7]).covariance(&[0, 1, 2, 3]).is_none());
}

#[test]
fn greedy_and_elimination_go_the_way_that_numpy_went() {
    let Some((candidates, targets)) = selection40() else { return };
    let pool: Vec<usize> = (0..40).collect();
    let request = |size| Request { pool: &pool, size, seed: 0, unit: Unit::Image, camera: None };
    let choose = |name: &str, size| -> Vec<usize> {
        let heuristic = Heuristic::named(name).unwrap();
        let choices = heuristic.choose(&candidates, &request(size)).unwrap();
        choices.into_iter().flat_map(|choice| choice.images).collect()
    };
    assert_eq!(choose("d-optimal", 20), places(&targets["d_optimal_greedy"]["order"]));
    let order = elimination_order(&candidates, &request(8)).unwrap().concat();
    assert_eq!(order, places(&targets["backward_elimination"]["order"]));
    for (size, name, most) in [
        (8, "d-optimal", 0.79),
        (12, "d-optimal", 0.81),
        (20, "d-optimal", 0.91),
        (8, "mapping-error", 0.71),
        (12, "mapping-error", 0.78),
        (20, "mapping-error", 0.87),
    ] {
        let draws = &targets["random_subsets"][size.to_string()];
        let ratio =
            error_px(&candidates, &choose(name, size)) / number(&draws["median_sqrt_eme_px"]);
        assert!(ratio <= most, "{name} {size}: {ratio}");
    }
    let swapped = number(&targets["swaps"]["8"]["sqrt_eme_px_after"]);
    assert!(error_px(&candidates, &choose("mapping-error", 8)) <= swapped * (1.0 + 1e-9));
}

fn calibstab(args: &[&str]) -> Output {
    let mut command = Command::cargo_bin("calibstab").unwrap();
    command.args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A room with two cameras that take 24 images in turn.
fn room() -> TempDir {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("room");
    let args = ["synth", "--images", "24", "--points", "400", "--camera", "OPENCV", "--camera"];
    let made = calibstab(&[&args[..], &["SIMPLE_RADIAL", "--out", path(&out)]].concat());
    assert!(made.status.success(), "{}", text(&made.stderr));
    folder
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn the_images_are_told_listed_and_written_as_a_model() {
    let folder = room();
    let [room, names, model] =
        ["room", "lists/images.txt", "model"].map(|it| folder.path().join(it));
    let mut said = BTreeSet::new();
    for heuristic in HEURISTICS {
        let args = ["select", path(&room), "--size", "8", "--heuristic", heuristic.name];
        let files = ["--out", path(&names), "--write-model", path(&model), "--seed", "3"];
        let done = calibstab(&[&args[..], &files].concat());
        assert!(done.status.success(), "{}", text(&done.stderr));
        let listed: Vec<String> =
            fs::read_to_string(&names).unwrap().lines().map(str::to_owned).collect();
        assert_eq!(listed.len(), 8, "{}", heuristic.name);
        let told = text(&done.stdout);
        assert!(listed.iter().all(|name| told.contains(name.as_str())), "{told}");
        for camera in [1, 2] {
            assert!(told.contains(&format!("camera {camera}: an expected error of ")), "{told}");
        }
        let scene = colmap::read(&model).unwrap();
        let geometry = scene.geometry.unwrap();
        let written: BTreeSet<_> = geometry.images.values().map(|it| it.name.clone()).collect();
        assert_eq!(written, listed.iter().cloned().collect());
        assert_eq!(scene.cameras.len(), 2);
        for point in geometry.points.iter() {
            let images: BTreeSet<_> = point.track.map(|it| it.image).collect();
            assert!(images.len() >= 2 && images.iter().all(|id| geometry.images.contains_key(id)));
        }
        said.insert(listed);
    }
    assert!(said.len() > 6, "{} unlike choices", said.len());
    let adjusted = calibstab(&["refine", path(&model), "--out", path(&folder.path().join("r"))]);
    assert!(adjusted.status.success(), "{}", text(&adjusted.stderr));
}

#[test]
fn one_camera_and_whole_frames_can_be_asked_for() {
    let folder = room();
    let room = folder.path().join("room");
    let scene = colmap::read(&room).unwrap();
    let geometry = scene.geometry.unwrap();
    let chosen = |args: &[&str]| -> Vec<String> {
        let list = folder.path().join("list");
        let base = ["select", path(&room), "--size", "6", "--out", path(&list)];
        let done = calibstab(&[&base[..], args].concat());
        assert!(done.status.success(), "{}", text(&done.stderr));
        fs::read_to_string(&list).unwrap().lines().map(str::to_owned).collect()
    };
    let of_camera = chosen(&["--camera", "2"]);
    let camera =
        |name: &String| geometry.images.values().find(|it| it.name == *name).unwrap().camera;
    assert!(of_camera.iter().all(|name| camera(name).0 == 2), "{of_camera:?}");
    assert_eq!(of_camera.len(), 6);
    // Of a rig of two cameras, both images of each exposure.
    let list = folder.path().join("frames");
    let rig = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/formats/rig");
    let done = calibstab(&["select", rig, "--size", "3", "--unit", "frame", "--out", path(&list)]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let told = text(&done.stdout);
    let names = fs::read_to_string(&list).unwrap();
    assert_eq!(names.lines().count(), 6, "{told}");
    let pairs: Vec<&str> = names.lines().collect();
    assert!(pairs.chunks(2).all(|pair| told.contains(&pair.join(", "))), "{told}");
    // Without rigs every image is a frame of its own.
    assert_eq!(chosen(&["--unit", "frame"]), chosen(&[]));
    assert_eq!(chosen(&["--heuristic", "random"]), chosen(&["--heuristic", "random"]));
    assert_ne!(
        chosen(&["--heuristic", "random"]),
        chosen(&["--heuristic", "random", "--seed", "1"])
    );
}

#[test]
fn what_cannot_be_chosen_is_an_error_with_its_reason() {
    let folder = room();
    let room = folder.path().join("room");
    for (args, wanted) in [
        (vec!["--size", "25"], "25 are asked for"),
        (vec!["--size", "1"], "at least two are needed"),
        (vec!["--size", "8", "--camera", "7"], "no image of camera 7"),
        (vec!["--size", "8", "--heuristic", "best"], "mapping-error"),
        (vec!["--size", "8", "--refine", "none"], "nothing to calibrate"),
        (vec!["--size", "few"], "invalid value"),
    ] {
        let failed = calibstab(&[&["select", path(&room)], &args[..]].concat());
        assert_eq!(failed.status.code(), Some(2), "{args:?}");
        assert!(text(&failed.stderr).contains(wanted), "{args:?}: {}", text(&failed.stderr));
        assert!(failed.stdout.is_empty());
    }
    let cameras = folder.path().join("room/cameras.txt");
    let lone = folder.path().join("lone");
    fs::create_dir(&lone).unwrap();
    fs::copy(cameras, lone.join("cameras.txt")).unwrap();
    let failed = calibstab(&["select", path(&lone), "--size", "4"]);
    assert_eq!(failed.status.code(), Some(2));
}
