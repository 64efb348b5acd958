//! `resample` as its user types it, and its noise against what an adjustment predicts of it.

// Helpers of tests, which the allowance for tests in clippy.toml does not reach.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use calibstab::bundle::{Options, adjust};
use calibstab::colmap;
use calibstab::scene::Scene;
use serde_json::Value;
use tempfile::TempDir;

const FIXTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/runs/many_images/run1");

fn calibstab(args: &[&str]) -> Output {
    let mut command = Command::cargo_bin("calibstab").unwrap();
    command.args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The samples, and the folder where they are.
fn samples(args: &[&str]) -> (TempDir, Vec<Scene>) {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("samples");
    let done = calibstab(&[&["resample", FIXTURE, "--out", path(&out)], args].concat());
    assert!(done.status.success(), "{}", text(&done.stderr));
    let scenes = runs(&out).iter().map(|run| colmap::read(run).unwrap()).collect();
    (folder, scenes)
}

fn runs(out: &Path) -> Vec<PathBuf> {
    let mut runs: Vec<PathBuf> =
        fs::read_dir(out).unwrap().map(|entry| entry.unwrap().path()).collect();
    runs.sort();
    runs
}

fn names(scene: &Scene) -> BTreeSet<String> {
    scene.geometry.as_ref().unwrap().images.values().map(|it| it.name.clone()).collect()
}

#[test]
fn noise_drawn_anew_moves_parameters_by_what_is_predicted() {
    const REPEATS: usize = 60;
    let (_folder, scenes) = samples(&["--by", "noise", "--repeats", "60"]);
    assert_eq!(scenes.len(), REPEATS);
    let truth = adjust(colmap::read(Path::new(FIXTURE)).unwrap(), &Options::default(), &mut |_| {});
    let truth = truth.unwrap().outcome;
    let predicted = truth.covariance.unwrap();
    let mut found: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for scene in scenes {
        let outcome = adjust(scene, &Options::default(), &mut |_| {}).unwrap().outcome;
        let sigma = outcome.sigma_px.unwrap() / truth.sigma_px.unwrap();
        assert!((sigma - 1.0).abs() < 0.1, "{sigma}");
        for (at, param) in predicted.params.iter().enumerate() {
            let camera = outcome.cameras.iter().find(|it| it.id == param.camera).unwrap();
            found.entry(at).or_default().push(camera.after.intrinsics.params()[param.place]);
        }
    }
    let rows = predicted.matrix.unwrap();
    for (at, values) in &found {
        let mean = values.iter().sum::<f64>() / REPEATS as f64;
        let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        let ratio = squares / (REPEATS - 1) as f64 / rows[*at][*at];
        // Chi-square of 59 degrees, 99.99 % on both sides, over its degrees.
        assert!((0.43..1.97).contains(&ratio), "{:?}: {ratio}", predicted.params[*at]);
    }
    assert!(found.len() >= 4, "{}", found.len());
}

#[test]
fn parts_of_the_images_are_what_analyze_reads_like_runs() {
    let (folder, scenes) = samples(&["--by", "image:0.5", "--repeats", "6"]);
    let all = names(&colmap::read(Path::new(FIXTURE)).unwrap());
    let parts: BTreeSet<BTreeSet<String>> = scenes.iter().map(names).collect();
    assert_eq!(parts.len(), 6);
    assert!(parts.iter().all(|part| part.len() == all.len() / 2 && part.is_subset(&all)));
    let report = folder.path().join("report");
    let out = folder.path().join("samples");
    let done = calibstab(&["analyze", path(&out), "--out", path(&report), "--format", "json"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let json: Value =
        serde_json::from_slice(&fs::read(report.join("analysis.json")).unwrap()).unwrap();
    let populations = json["populations"].as_array().unwrap();
    assert_eq!(populations.len(), 2);
    for one in populations {
        assert_eq!(one["verdict"]["n"], 6);
        let shared = one["overlap"]["shared_fraction"].as_f64().unwrap();
        assert!((0.35..0.7).contains(&shared), "{shared}");
    }
}

#[test]
fn one_seed_gives_the_same_bytes_with_any_threads_and_another_gives_others() {
    let bytes = |folder: &TempDir| -> Vec<Vec<u8>> {
        let runs = runs(&folder.path().join("samples"));
        runs.iter().map(|run| fs::read(run.join("images.txt")).unwrap()).collect()
    };
    for by in ["noise", "image:0.3"] {
        let args = ["--by", by, "--repeats", "3"];
        let made = |more: &[&str]| bytes(&samples(&[&args[..], more].concat()).0);
        let first = made(&["--threads", "1"]);
        assert_eq!(first, made(&["--threads", "2"]), "{by}");
        let other = made(&["--seed", "1"]);
        assert!(first.iter().all(|one| !other.contains(one)), "{by}");
        assert!(first[0] != first[1] && first[1] != first[2], "{by}");
    }
}

#[test]
fn what_cannot_be_sampled_is_an_error_and_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("samples");
    for (by, wanted) in [
        ("image:1.5", "expected noise"),
        ("images", "expected noise"),
        ("image:0.01", "at least two"),
    ] {
        let failed = calibstab(&["resample", FIXTURE, "--by", by, "--out", path(&out)]);
        assert_eq!(failed.status.code(), Some(2), "{by}");
        assert!(text(&failed.stderr).contains(wanted), "{}", text(&failed.stderr));
        assert!(!out.exists());
    }
}
