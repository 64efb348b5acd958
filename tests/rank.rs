//! `rank` as its user types it.

// Helpers of tests, which the allowance for tests in clippy.toml does not reach.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command as Process, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

const ONE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/runs/few_images/run1");
const OTHER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/runs/few_images/run2");
const SMALL: [&str; 8] = [
    "--sizes",
    "4,6,50",
    "--repeats",
    "3",
    "--heuristics",
    "random,window,d-optimal",
    "--seed",
    "7",
];

fn calibstab(args: &[&str]) -> Output {
    Command::cargo_bin("calibstab").unwrap().args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn rank(out: &Path, more: &[&str]) -> Output {
    calibstab(&[&["rank", ONE, OTHER, "--out", out.to_str().unwrap()], &SMALL[..], more].concat())
}

/// Every file below a folder, with its content.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap()) {
        let name = entry.file_name().into_string().unwrap();
        match entry.file_type().unwrap().is_dir() {
            true => {
                let below = files(&entry.path()).into_iter();
                found.extend(below.map(|(path, content)| (format!("{name}/{path}"), content)));
            }
            false => drop(found.insert(name, fs::read(entry.path()).unwrap())),
        }
    }
    found
}

fn assert_same(one: &Path, other: &Path) {
    let [one, other] = [files(one), files(other)];
    assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>());
    assert!(one.len() >= 6);
    for (name, content) in &one {
        assert!(other[name] == *content, "{name} differs");
    }
}

#[test]
fn the_result_is_the_same_for_any_number_of_threads_and_after_an_interruption() {
    let folder = TempDir::new().unwrap();
    let out = |name: &str| folder.path().join(name);
    let done = rank(&out("one"), &["--threads", "1"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let again = rank(&out("three"), &["--threads", "3"]);
    assert_same(&out("one"), &out("three"));
    assert_eq!(done.stdout, again.stdout);

    let interrupted = out("interrupted");
    let journal = interrupted.join("unfinished.jsonl");
    let lines = || fs::read_to_string(&journal).map_or(0, |text| text.lines().count());
    let args = [
        &["rank", ONE, OTHER, "--threads", "1", "--out", interrupted.to_str().unwrap()],
        &SMALL[..],
    ];
    let mut process = Process::new(env!("CARGO_BIN_EXE_calibstab"))
        .args(args.concat())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while lines() < 3 {
        assert!(process.try_wait().unwrap().is_none(), "it ended before it was interrupted");
        sleep(Duration::from_millis(1));
    }
    process.kill().unwrap();
    process.wait().unwrap();
    // A line that was being written.
    let mut held = fs::read(&journal).unwrap();
    held.extend(b"[{\"model\":0,\"si");
    fs::write(&journal, held).unwrap();

    let refused = rank(&interrupted, &[]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        text(&refused.stderr).contains("--resume goes on with it"),
        "{}",
        text(&refused.stderr)
    );
    let other = rank(&interrupted, &["--resume", "--pool", "random:0.6"]);
    assert_eq!(other.status.code(), Some(2));
    assert!(text(&other.stderr).contains("another experiment"), "{}", text(&other.stderr));

    let resumed = rank(&interrupted, &["--resume"]);
    assert!(resumed.status.success(), "{}", text(&resumed.stderr));
    assert_same(&out("one"), &interrupted);
    assert_eq!(done.stdout, resumed.stdout);
}

#[test]
fn the_record_tells_what_was_asked_and_found() {
    let folder = TempDir::new().unwrap();
    let done = rank(folder.path(), &["--target-px", "1000"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    // 16 images, of which a pool has eight: sizes above it are skipped, and that is said.
    assert_eq!(text(&done.stderr).matches("a pool has 8: nothing was tried at size 50").count(), 2);
    let found: Value =
        serde_json::from_slice(&fs::read(folder.path().join("selection.json")).unwrap()).unwrap();
    let list = |name: &str| found[name].as_array().unwrap().clone();
    assert_eq!(list("cells").len(), 2 * 2 * 3);
    assert_eq!(list("samples").len(), 2 * 2 * 3 * 3);
    for sample in list("samples") {
        let (size, images) =
            (sample["size"].as_u64().unwrap(), sample["images"].as_array().unwrap());
        assert_eq!(images.len() as u64, size);
    }
    // Over all; of each size; of each model.
    assert_eq!(list("rankings").len(), 1 + 2 + 2);
    assert!(list("targets").iter().all(|target| target["size"] == 4));
    assert_eq!(found["agreement"]["best"].as_array().unwrap().len(), 2);
    let schema: Value =
        serde_json::from_slice(&calibstab(&["schema", "selection"]).stdout).unwrap();
    for key in found.as_object().unwrap().keys() {
        assert!(schema["properties"][key].is_object(), "{key}");
    }
    for stem in [
        "heuristics-learning",
        "model-1-size-4-centres",
        "model-2-size-4-centres",
        "model-2-size-6-camera-1-boxes",
        "model-2-size-6-camera-1-coverage",
    ] {
        for ending in ["svg", "png"] {
            assert!(folder.path().join(format!("plots/{stem}.{ending}")).is_file(), "{stem}");
        }
    }
    let cells = text(&fs::read(folder.path().join("cells.csv")).unwrap());
    assert!(cells.lines().count() > 12, "{cells}");
    let report = text(&fs::read(folder.path().join("report.md")).unwrap());
    assert!(report.contains("## Of size 4") && report.contains("## Of few\\_images/run1"));
}

#[test]
fn bad_arguments_are_refused_with_the_reason() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    for (args, why) in [
        (&["--sizes", "1"][..], "1 is not in 2.."),
        (&["--repeats", "1"], "1 is not in 2.."),
        (&["--pool", "half"], "`half` is no pool"),
        (&["--heuristics", "best"], "best"),
        (&["--sizes", "400"], "no size is left"),
        (&["--camera", "9"], "camera 9"),
        (&["--truth", "/nowhere"], "/nowhere"),
    ] {
        let refused = calibstab(&[&["rank", ONE, "--out", out], args].concat());
        assert_eq!(refused.status.code(), Some(2), "{args:?}");
        assert!(text(&refused.stderr).contains(why), "{args:?}: {}", text(&refused.stderr));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{args:?}");
    }
}
