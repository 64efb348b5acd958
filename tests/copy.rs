//! Models written by the library and by `calibstab copy`: as COLMAP writes them, whole or not at all, to the last bit.

// Helpers of tests, which the allowance for tests in clippy.toml does not reach.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use calibstab::colmap::{Form, ModelFiles, WriteError, encode, find, read, write};
use calibstab::scene::{CameraId, ImageId, Scene};
use tempfile::TempDir;

const FORMS: [Form; 2] = [Form::Text, Form::Binary];

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures")
}

fn fixture(name: &str) -> Scene {
    read(&fixtures().join("formats").join(name)).unwrap()
}

/// A folder with a cameras file.
fn lone_cameras(text: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("cameras.txt"), text).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Text of binary of text is the text, and each of them holds the scene.
fn check_copies(model: &ModelFiles) {
    let scene = model.read().unwrap();
    let folder = TempDir::new().unwrap();
    let mut first: Option<Scene> = None;
    for (step, form) in [Form::Text, Form::Binary, Form::Text, Form::Binary].into_iter().enumerate()
    {
        let out = folder.path().join(step.to_string());
        let source = first.take().unwrap_or_else(|| scene.clone());
        let written = write(&source, &out, form).unwrap();
        assert_eq!(written.files.len(), model.paths().count());
        let back = read(&out).unwrap();
        assert!(back == scene, "{}: {form:?} is another scene", model.run().display());
        if let Some(before) = step.checked_sub(2) {
            for file in &written.files {
                let earlier =
                    folder.path().join(before.to_string()).join(file.file_name().unwrap());
                assert!(
                    fs::read(file).unwrap() == fs::read(earlier).unwrap(),
                    "{}",
                    file.display()
                );
            }
        }
        first = Some(back);
    }
}

#[test]
fn every_fixture_comes_back_from_its_copies_to_the_last_bit() {
    let models = find(&fixtures().join("formats")).unwrap();
    models.iter().for_each(check_copies);
    assert_eq!(models.len(), 10);
}

#[test]
#[allow(clippy::print_stderr)] // a test that is skipped says so
fn every_real_model_comes_back_from_its_copies_to_the_last_bit() {
    let shared = match std::env::var_os("CALIBSTAB_SHARED") {
        Some(shared) => PathBuf::from(shared),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
    };
    let data = shared.join("data");
    if !data.is_dir() {
        eprintln!("skipped: no {}; CALIBSTAB_SHARED names the folder above it", data.display());
        return;
    }
    let models = find(&data).unwrap();
    models.iter().for_each(check_copies);
    assert_eq!(models.len(), 83);
}

/// `fixtures/formats/text` is what pycolmap wrote, but for its numbers of fewer digits.
#[test]
fn the_files_are_laid_out_as_colmap_lays_them_out() {
    let folder = fixtures().join("formats/text");
    let files = encode(&fixture("text"), Form::Text).unwrap();
    assert_eq!(files.len(), 5);
    for (name, content) in files {
        let layout = |text: &str| -> Vec<(String, usize)> {
            let line = |line: &str| match line.strip_prefix('#') {
                Some(comment) => (comment.to_owned(), 0),
                None => (String::new(), line.split_whitespace().count()),
            };
            text.lines().map(line).collect()
        };
        let want = fs::read_to_string(folder.join(&name)).unwrap();
        assert_eq!(layout(std::str::from_utf8(&content).unwrap()), layout(&want), "{name}");
    }
    let binary = encode(&fixture("binary"), Form::Binary).unwrap();
    for (name, content) in binary {
        let want = fs::read(fixtures().join("formats/binary").join(&name)).unwrap();
        assert!(content == want, "{name} differs from pycolmap's");
    }
}

#[test]
fn numbers_at_the_ends_of_their_types_survive() {
    let doubles = [
        "-0.0",
        "4.9406564584124654e-324",
        "-2.2250738585072011e-308",
        "1.7976931348623157e308",
        "1e22",
        "0.1",
        "1e-5",
    ];
    for double in doubles {
        let last = u32::MAX - 1;
        let folder = lone_cameras(&format!(
            "{last} SIMPLE_RADIAL {max} 1 500 320 240 {double}",
            max = u64::MAX
        ));
        let scene = read(folder.path()).unwrap();
        let want = double.parse::<f64>().unwrap().to_bits();
        for form in FORMS {
            let out = folder.path().join(format!("{form:?}"));
            write(&scene, &out, form).unwrap();
            let back = read(&out).unwrap();
            let camera = back.cameras[&CameraId(last)];
            assert_eq!(camera.width, u64::MAX);
            assert_eq!(camera.intrinsics.params()[3].to_bits(), want, "{double} {form:?}");
        }
    }
}

#[test]
fn when_one_file_cannot_be_written_none_is() {
    let folder = TempDir::new().unwrap();
    let before = "1 PINHOLE 1 1 1 1 0 0\n";
    fs::write(folder.path().join("cameras.txt"), before).unwrap();
    fs::create_dir(folder.path().join("points3D.txt")).unwrap();
    let error = write(&fixture("text"), folder.path(), Form::Text).unwrap_err();
    assert!(
        matches!(&error, WriteError::File { file, .. } if file.ends_with("points3D.txt")),
        "{error}"
    );
    assert_eq!(names(folder.path()), ["cameras.txt", "points3D.txt"]);
    assert_eq!(fs::read_to_string(folder.path().join("cameras.txt")).unwrap(), before);
}

#[test]
fn files_of_another_model_are_not_mixed_in() {
    let folder = TempDir::new().unwrap();
    let (whole, legacy) = (fixture("text"), fixture("text_legacy"));
    write(&whole, folder.path(), Form::Text).unwrap();
    let error = write(&legacy, folder.path(), Form::Text).unwrap_err();
    assert!(
        matches!(&error, WriteError::InTheWay { file } if file.ends_with("rigs.txt")),
        "{error}"
    );
    assert!(read(folder.path()).unwrap() == whole);
    // Files of the same names are replaced, and those of the other form are another model.
    write(&fixture("rig"), folder.path(), Form::Text).unwrap();
    write(&legacy, folder.path(), Form::Binary).unwrap();
    assert!(read(folder.path()).unwrap() == legacy);
    assert!(read(&folder.path().join("cameras.txt")).unwrap() == fixture("rig"));
}

#[test]
fn what_a_form_cannot_hold_is_refused_and_named() {
    let own = read(lone_cameras("3 RADTAN 640 480 500 500 320 240 0 0 0 0 0").path()).unwrap();
    let error = encode(&own, Form::Binary).unwrap_err().to_string();
    assert_eq!(
        error,
        "camera 3: RADTAN is calibstab's own and has no number in COLMAP's binary files, only a name in text"
    );
    let cases = [
        (Form::Text, "", "text cannot hold the name ``, which is empty"),
        (Form::Text, "a\nb", "text cannot hold the name `a\\nb`, which holds a line end"),
        (Form::Text, " a", "text cannot hold the name ` a`, which begins or ends with a blank"),
        (Form::Text, "a\r", "text cannot hold the name `a\\r`, which begins or ends with a blank"),
        (Form::Binary, "a\0b", "binary cannot hold the name `a\\u{0}b`, which holds a zero byte"),
    ];
    for (form, name, want) in cases {
        let mut scene = fixture("text");
        let geometry = scene.geometry.as_mut().unwrap();
        geometry.images.get_mut(&ImageId(2)).unwrap().name = name.to_owned();
        let error = encode(&scene, form).unwrap_err().to_string();
        assert_eq!(error, format!("image 2: {want}"));
    }
    let mut scene = fixture("text");
    let geometry = scene.geometry.as_mut().unwrap();
    geometry.images.get_mut(&ImageId(2)).unwrap().cam_from_world.translation[1] = f64::NAN;
    for form in FORMS {
        let error = encode(&scene, form).unwrap_err().to_string();
        assert_eq!(error, "image 2 holds NaN, which is not a finite number");
    }
}

#[test]
fn what_colmap_will_not_read_back_is_remarked_on() {
    let remarks =
        |scene: &Scene, form| write(scene, TempDir::new().unwrap().path(), form).unwrap().remarks;
    let own = read(lone_cameras("3 RADTAN 640 480 500 500 320 240 0 0 0 0 0").path()).unwrap();
    assert_eq!(
        remarks(&own, Form::Text),
        ["camera 3: RADTAN is calibstab's own, COLMAP will not read this model"]
    );
    let names = remarks(&fixture("odd_names"), Form::Text);
    assert_eq!(names.len(), 1);
    assert!(names[0].starts_with("COLMAP reads names only up to the first blank: `"), "{names:?}");
    assert_eq!(remarks(&fixture("odd_names"), Form::Binary), [""; 0]);
    assert_eq!(remarks(&fixture("rig"), Form::Text), [""; 0]);
    let folder = lone_cameras("1 SIMPLE_PINHOLE 1 1 1 0 0");
    fs::write(folder.path().join("images.txt"), "").unwrap();
    fs::write(folder.path().join("points3D.txt"), "9223372036854775808 0 0 0 0 0 0 0").unwrap();
    let large = read(folder.path()).unwrap();
    let want =
        "COLMAP reads no point id above 9223372036854775807 from text: point 9223372036854775808";
    assert_eq!(remarks(&large, Form::Text), [want]);
    assert_eq!(remarks(&large, Form::Binary), [""; 0]);
}

fn calibstab(args: &[&Path]) -> Output {
    let mut command = Command::cargo_bin("calibstab").unwrap();
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("copy").args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn copy_writes_the_form_asked_for_and_says_so_on_stderr() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("new/copy");
    let output = calibstab(&["fixtures/formats/text".as_ref(), &out, "--binary".as_ref()]);
    assert!(output.status.success() && output.stdout.is_empty());
    assert_eq!(text(&output.stderr), format!("5 files written to {}\n", out.display()));
    assert_eq!(
        names(&out),
        ["cameras.bin", "frames.bin", "images.bin", "points3D.bin", "rigs.bin"]
    );
    assert!(read(&out).unwrap() == fixture("text"));
    let lone = folder.path().join("lone");
    let output = calibstab(&[
        "fixtures/formats/lone_cameras".as_ref(),
        &lone,
        "--text".as_ref(),
        "-q".as_ref(),
    ]);
    assert!(output.status.success() && output.stderr.is_empty());
    assert_eq!(names(&lone), ["cameras.txt"]);
}

#[test]
fn copy_tells_what_colmap_would_cut_even_when_quiet() {
    let folder = TempDir::new().unwrap();
    let args: [&Path; 4] =
        ["fixtures/formats/odd_names".as_ref(), folder.path(), "--text".as_ref(), "-q".as_ref()];
    let output = calibstab(&args);
    assert!(output.status.success());
    assert!(text(&output.stderr).starts_with("remark: COLMAP reads names only up to"));
}

#[test]
fn copy_refuses_with_exit_code_2() {
    let folder = TempDir::new().unwrap();
    let bad = "fixtures/bad/nan".as_ref();
    let sound = "fixtures/formats/text".as_ref();
    let (form, both) = ("--text".as_ref(), "--binary".as_ref());
    for args in [
        &[bad, folder.path(), form] as &[&Path],
        &[sound, folder.path()],
        &[sound, folder.path(), form, both],
    ] {
        let output = calibstab(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(!output.stderr.is_empty() && output.stdout.is_empty());
    }
    assert_eq!(names(folder.path()), [""; 0]);
}
