//! `check` and `explain`, as their user types them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

fn calibstab(args: &[&str]) -> Output {
    let mut command = Command::cargo_bin("calibstab").unwrap();
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Analyses what COLMAP left into a folder.
fn analyzed(paths: &[&str]) -> TempDir {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let plain = ["analyze", "--no-refine", "--quiet", "--format", "json", "--out", out];
    let output = calibstab(&[&plain, paths].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    folder
}

fn json(folder: &TempDir) -> Value {
    serde_json::from_slice(&fs::read(folder.path().join("analysis.json")).unwrap()).unwrap()
}

/// Checks an analysis: exit code, stdout, stderr.
fn check(folder: &Path, args: &[&str]) -> (i32, String, String) {
    let output = calibstab(&[&["check", folder.to_str().unwrap()], args].concat());
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn limits_that_are_kept_are_fine_and_those_that_are_not_are_said_one_a_line() {
    let folder = analyzed(&["fixtures/runs"]);
    let wide = ["--max-spread-px", "5", "--max-relative-std", "f=5%", "--verdict", "doubtful"];
    let (code, out, err) = check(folder.path(), &wide);
    assert_eq!((code, out.as_str(), err.as_str()), (0, "", "within all limits: 4 cameras\n"));

    let (code, out, _) = check(folder.path(), &["--max-spread-px", "0.001"]);
    assert_eq!(code, 1);
    let all = json(&folder);
    let populations = all["populations"].as_array().unwrap();
    assert_eq!(out.lines().count(), populations.len());
    for (line, one) in out.lines().zip(populations) {
        let place = format!(
            "{} {}: spread ",
            one["camera"].as_str().unwrap(),
            one["group"].as_str().unwrap()
        );
        let px: f64 = line
            .strip_prefix(&place)
            .unwrap()
            .strip_suffix(" px > 0.001 px")
            .unwrap()
            .parse()
            .unwrap();
        let want = one["verdict"]["spread_px"].as_f64().unwrap();
        assert!((px / want - 1.0).abs() < 0.06, "{line}: {want}");
    }

    // f stands for fx and fy; k1 has a limit that is kept.
    let (code, out, _) = check(folder.path(), &["--max-relative-std", "f=0.0001%,k1=0.9"]);
    assert_eq!((code, out.lines().count()), (1, 8), "{out}");
    assert!(out.contains("camera 1 few_images: relative std of fx 0."), "{out}");
    assert!(out.lines().all(|line| line.ends_with(" % > 0.0001 %")), "{out}");
}

#[test]
fn a_verdict_that_is_not_good_enough_is_said_with_its_reasons() {
    let folder = analyzed(&["fixtures/thesis/simple_radial_fisheye_camera3"]);
    let want = "camera 3 simple_radial_fisheye_camera3: verdict doubtful, not repeatable (fold)\n";
    let found = check(folder.path(), &["--verdict", "repeatable"]);
    assert_eq!((found.0, found.1.replace("camera 1 ", "camera 3 ").as_str()), (1, want));
    assert_eq!(check(folder.path(), &["--verdict", "doubtful"]).0, 0);
}

#[test]
fn too_few_runs_to_tell_is_exit_code_3_unless_another_limit_is_exceeded() {
    let one = analyzed(&["fixtures/thesis/opencv_camera1/run1/cameras.txt"]);
    for (args, want) in [
        (["--max-spread-px", "1"], "there is no spread"),
        (["--max-relative-std", "fx=1%"], "fx has no std"),
        (["--verdict", "doubtful"], "verdict not-determined, not doubtful (not-repeated)"),
    ] {
        let (code, out, _) = check(one.path(), &args);
        assert_eq!(code, 3, "{args:?}");
        assert!(out.contains(want) && out.lines().count() == 1, "{args:?}: {out}");
    }
    let both = analyzed(&["fixtures/thesis/opencv_camera1", "fixtures/thesis/examples"]);
    let (code, out, _) = check(both.path(), &["--max-spread-px", "1"]);
    assert_eq!(code, 1);
    assert!(out.contains("spread 17 px > 1 px") && out.contains("there is no spread"), "{out}");
}

#[test]
fn only_strictness_minds_a_limit_within_the_interval() {
    let folder = analyzed(&["fixtures/thesis/opencv_camera1"]);
    // The spread is 17 px, 95 % 9.1 .. 109 px; fx is 4.8 %, 2.5 .. 30 %.
    for (args, plain, strict) in [
        (["--max-spread-px", "120"], 0, 0),
        (["--max-spread-px", "20"], 0, 3),
        (["--max-spread-px", "12"], 1, 3),
        (["--max-spread-px", "9"], 1, 1),
        (["--max-relative-std", "fx=5%"], 0, 3),
        (["--max-relative-std", "fx=31%"], 0, 0),
        (["--max-relative-std", "fx=2%"], 1, 1),
    ] {
        assert_eq!(check(folder.path(), &args).0, plain, "{args:?}");
        let (code, out, _) = check(folder.path(), &[&args[..], &["--strict"]].concat());
        assert_eq!(code, strict, "{args:?}: {out}");
        assert_eq!(out.contains("has the limit of"), strict == 3, "{out}");
    }
}

#[test]
fn a_file_has_limits_for_all_cameras_and_others_for_some() {
    let folder = analyzed(&["fixtures/runs"]);
    let file = folder.path().join("limits.toml");
    let limits = |content: &str| {
        fs::write(&file, content).unwrap();
        check(folder.path(), &["--limits", file.to_str().unwrap()])
    };
    let general = "max-spread-px = 0.001\nmax-relative-std = { f = \"9 %\" }\n";
    assert_eq!(limits(general).1.lines().count(), 4);
    let few = "[[camera]]\ngroup = \"few_*\"\nmax-spread-px = 9\n";
    let (code, out, _) = limits(&format!("{general}{few}"));
    assert_eq!((code, out.lines().count()), (1, 2), "{out}");
    assert!(out.lines().all(|line| line.contains(" many_images: spread ")), "{out}");
    let one = "[[camera]]\ngroup = \"few_images\"\ncamera = \"camera 2\"\nmax-spread-px = 0.002\n";
    let (_, out, _) = limits(&format!("{few}{one}"));
    assert!(out.starts_with("camera 2 few_images: spread ") && out.lines().count() == 1, "{out}");
    let (code, _, err) = limits(few);
    assert_eq!(
        (code, err.as_str()),
        (0, "within all limits: 2 cameras of 4, the others have none\n")
    );
    for (content, want) in [
        ("max-spread = 1", "limits.toml:1:1: unknown field `max-spread`"),
        (
            "[[camera]]\ngroup = \"no\"\nmax-spread-px = 1",
            "[[camera]] number 1 fits no camera; there are `camera 1` of `few_images`",
        ),
        (
            "[[camera]]\ncamera = \"camera 2\"\nmax-relative-std = { p1 = 1 }",
            "no camera has a parameter `p1` that it fits",
        ),
        ("", "no limit is given"),
    ] {
        let (code, out, err) = limits(content);
        assert_eq!((code, out.as_str()), (2, ""), "{content}");
        assert!(err.contains(want), "{content}: {err}");
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_exit_code_2() {
    let folder = analyzed(&["fixtures/thesis/opencv_camera1"]);
    let analysis = folder.path().join("analysis.json");
    let old = folder.path().join("old.json");
    let content = fs::read_to_string(&analysis).unwrap();
    fs::write(&old, content.replacen("\"schema_version\": 1", "\"schema_version\": 999", 1))
        .unwrap();
    let cut = folder.path().join("cut.json");
    fs::write(&cut, &content[..content.len() / 2]).unwrap();
    let [analysis, old, cut] = [&analysis, &old, &cut].map(|path| path.to_str().unwrap());
    for (args, want) in [
        (vec![analysis], "no limit is given"),
        (vec![analysis, "--max-relative-std", "g=1%"], "no camera has a parameter `g`"),
        (vec![analysis, "--max-relative-std", "f"], "NAME=SHARE"),
        (vec![analysis, "--max-spread-px", "-1"], "-1"),
        (vec![analysis, "--verdict", "accurate"], "repeatable"),
        (vec![analysis, "--verdict", "doubtful", "--limits", "x.toml"], "--limits"),
        (vec![analysis, "--limits", "no/such.toml"], "no/such.toml: could not be read"),
        (vec!["no/such.json", "--verdict", "doubtful"], "no/such.json: could not be read"),
        (vec!["fixtures/README.md", "--verdict", "doubtful"], "fixtures/README.md:1:1: not what"),
        (vec![old, "--verdict", "doubtful"], "its schema_version is 999"),
        (vec![cut, "--verdict", "doubtful"], "cut.json:"),
    ] {
        let output = calibstab(&[&["check"], &args[..]].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(output.stdout.is_empty(), "{args:?}");
        let error = text(&output.stderr);
        assert!(error.contains(want), "{args:?}: no `{want}` in:\n{error}");
    }
}

#[test]
fn a_verdict_stands_before_all_else_and_its_reasons_are_not_said_twice() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let args = ["analyze", "fixtures/thesis/opencv_camera1", "--out", out, "--format", "json,md"];
    let shown = text(&calibstab(&args).stdout);
    assert!(shown.starts_with("Verdict\n  opencv_camera1: camera 1, OPENCV 1280 x 960: doubtful, spread 17 px (95 %: 9.1 .. 109 px, n = 3)\n    - few-runs: "), "{shown}");
    assert_eq!(shown.matches("runs tell little").count(), 1);
    let markdown = fs::read_to_string(folder.path().join("report.md")).unwrap();
    assert!(
        markdown.starts_with("# Calibration stability\n\n## Verdict\n\n- opencv"),
        "{markdown}"
    );
    assert_eq!(markdown.matches("runs tell little").count(), 1);
    let verdict = &json(&folder)["populations"][0]["verdict"];
    assert_eq!((&verdict["kind"], &verdict["n"]), (&"doubtful".into(), &3.into()));
    assert_eq!(verdict["reasons"][0]["id"], "few-runs");
}

#[test]
fn every_finding_that_an_analysis_may_have_is_explained() {
    let schema: Value = serde_json::from_slice(&calibstab(&["schema"]).stdout).unwrap();
    let kinds = schema["$defs"]["FindingId"]["oneOf"].as_array().unwrap();
    assert!(kinds.len() > 20, "{schema}");
    let list = text(&calibstab(&["explain"]).stdout);
    let mut said: BTreeMap<String, &str> = BTreeMap::new();
    for kind in kinds {
        let id = kind["const"].as_str().unwrap();
        assert!(list.lines().any(|line| line.trim_start().starts_with(&format!("{id} "))), "{id}");
        let output = calibstab(&["explain", id]);
        assert_eq!(output.status.code(), Some(0), "{id}");
        let shown = text(&output.stdout);
        assert!(shown.contains("What to do: ") && shown.contains("How it is found: "), "{shown}");
        assert!(shown.lines().all(|line| line.chars().count() <= 100), "{shown}");
        assert!(said.insert(shown, id).is_none(), "{id} is explained as another is");
    }
    let output = calibstab(&["explain", "outlier-runs"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("did you mean outlier-run?"));
}
