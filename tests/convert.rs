//! `calibstab models`, `inspect` and `convert`, as their user types them.

// Helpers of tests, which the allowance for tests in clippy.toml does not reach.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use calibstab::camera::MODELS;
use calibstab::colmap::read;
use calibstab::scene::CameraId;
use tempfile::TempDir;

fn calibstab(args: &[&str]) -> Output {
    let mut command = Command::cargo_bin("calibstab").unwrap();
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// What a command that goes well prints.
fn printed(args: &[&str]) -> String {
    let output = calibstab(args);
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

/// What a command says that ends with exit code 2.
fn refused(args: &[&str]) -> String {
    let output = calibstab(args);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stdout));
    assert!(output.stdout.is_empty());
    text(&output.stderr)
}

fn path(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

/// A folder with a cameras file.
fn cameras(lines: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("cameras.txt"), lines).unwrap();
    folder
}

#[test]
fn the_list_shows_every_model_with_its_parameters() {
    let list = printed(&["models"]);
    for model in MODELS {
        let line = list.lines().find(|line| line.split(' ').next() == Some(model.name)).unwrap();
        assert!(model.params.iter().all(|param| line.contains(param.name)), "{line}");
    }
    for line in [
        "OPENCV                       4  below 90°             fx* fy* cx+ cy+ k1 k2 p1 p2",
        "FISHEYE                     15  below 180°            fx* fy* cx+ cy+",
        "UCM                          -  by params, below 180°  fx* fy* cx+ cy+ alpha",
    ] {
        let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert!(list.lines().any(|found| words(found) == words(line)), "{line} is not in\n{list}");
    }
}

#[test]
fn the_lens_of_the_thesis_is_seen_to_fold_inside_its_image() {
    let found = printed(&["inspect", "fixtures/thesis/examples/simple_radial"]);
    let first = found.split("\n\n").next().unwrap();
    assert!(first.starts_with("camera 1  SIMPLE_RADIAL  1280 x 960\n"), "{first}");
    assert!(first.contains("792.4 px from the principal point"), "{first}");
    assert!(first.contains("the farthest corner is at 800.0 px"), "{first}");
    assert!(
        first.contains("folds inside the image, 0.0195 % of the pixels have no ray"),
        "{first}"
    );
    assert!(found.ends_with("subtract 0.5\nfrom cx and cy.\n"), "{found}");
}

#[test]
fn the_fisheyes_of_the_thesis_have_pixels_without_a_ray() {
    let found = printed(&["inspect", "fixtures/thesis/examples/opencv"]);
    let last = found.split("\n\n").nth(3).unwrap();
    // r = theta (1 + k1 theta^2 + ...) stops growing at 2.1 rad, about 410 px short of the corners.
    assert!(last.starts_with("camera 4  OPENCV_FISHEYE  1024 x 1024\n"), "{last}");
    assert!(last.contains("folds inside the image, 7.4 % of the pixels have no ray"), "{last}");
}

#[test]
fn what_is_converted_is_written_and_what_it_cost_is_said() {
    let folder = cameras(
        "7 SIMPLE_RADIAL 640 480 500 320 240 -0.1\n8 RADIAL 640 480 500 320 240 -0.1 0.02\n",
    );
    let from = path(&folder, "cameras.txt");
    for form in ["txt", "bin"] {
        let out = path(&folder, &format!("opencv.{form}"));
        let said = printed(&["convert", &from, "--to", "OPENCV", "--out", &out]);
        assert!(said.contains("camera 7  SIMPLE_RADIAL -> OPENCV: exact\n"), "{said}");
        let written = read(Path::new(&out)).unwrap().cameras;
        let params = written[&CameraId(8)].intrinsics.params().to_vec();
        assert_eq!(params, [500.0, 500.0, 320.0, 240.0, -0.1, 0.02, 0.0, 0.0]);
    }
    let out = path(&folder, "eucm.txt");
    let said = printed(&["convert", &from, "--to", "EUCM", "--out", &out, "--camera", "8"]);
    assert!(said.starts_with("camera 8  RADIAL -> EUCM: fitted, rms 0.00"), "{said}");
    // The last cells' centres are 392.5 px out: 500 r (1 - 0.1 r^2 + 0.02 r^4) there, r = tan 39.9 degrees.
    assert!(said.contains("over 100.0 % of the image, up to 39.9° from the axis"), "{said}");
    let written = read(Path::new(&out)).unwrap().cameras;
    let names = written.values().map(|camera| camera.intrinsics.model().name);
    assert_eq!(names.collect::<Vec<_>>(), ["SIMPLE_RADIAL", "EUCM"]);
}

#[test]
fn a_model_that_colmap_does_not_know_is_written_with_a_warning_and_not_in_binary() {
    let folder = cameras("1 PINHOLE 640 480 500 490 320 240\n");
    let from = path(&folder, "cameras.txt");
    let output = calibstab(&["convert", &from, "--to", "UCM", "--out", &path(&folder, "ucm.txt")]);
    assert!(output.status.success());
    assert!(text(&output.stderr).contains("COLMAP will not read this model"));
    let said = refused(&["convert", &from, "--to", "UCM", "--out", &path(&folder, "ucm.bin")]);
    assert!(said.contains("UCM"), "{said}");
    assert!(!folder.path().join("ucm.bin").exists());
}

fn convert<'a>(from: &'a str, rest: &[&'a str]) -> Vec<&'a str> {
    [&["convert", from][..], rest].concat()
}

#[test]
fn what_cannot_be_done_is_an_error_and_leaves_no_file() {
    let folder = cameras(
        "1 SIMPLE_RADIAL 1280 960 1011.91 640 480 -0.241569\n2 PINHOLE 640 480 500 490 320 240\n",
    );
    let (from, out) = (path(&folder, "cameras.txt"), path(&folder, "out.txt"));
    for (args, reason) in [
        (convert(&from, &["--to", "OPENCV_FISHEY", "--out", &out]), "did you mean OPENCV_FISHEYE?"),
        (convert(&from, &["--to", "EUCM", "--out", &path(&folder, "out.csv")]), ".txt or .bin"),
        (
            convert(&from, &["--to", "EUCM", "--out", &out]),
            "camera 1  SIMPLE_RADIAL -> EUCM: SIMPLE_RADIAL folds",
        ),
        (convert(&from, &["--to", "EUCM", "--out", &out, "--camera", "5"]), "there is no camera 5"),
        (convert(&from, &["--to", "EQUIRECTANGULAR", "--out", &out]), "not a lens"),
        (convert(&from, &["--to", "EUCM"]), "--out"),
        (vec!["convert", "nowhere", "--to", "EUCM", "--out", &out], "no such file or folder"),
        (vec!["inspect", "nowhere"], "no such file or folder"),
        (vec!["inspect", "fixtures/runs"], "expected one model, found 12"),
    ] {
        let said = refused(&args);
        assert!(said.contains(reason), "{args:?}: {said}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let said = printed(&convert(&from, &["--to", "EUCM", "--out", &out, "--allow-fold"]));
    assert!(said.contains("camera 1  SIMPLE_RADIAL -> EUCM: fitted"), "{said}");
}
