//! The built program, as its user types it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

fn calibstab(args: &[&str]) -> Output {
    let mut command = Command::cargo_bin("calibstab").unwrap();
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(args).output().unwrap()
}

/// Analyses what COLMAP left into a folder of its own; the JSON that came out. Refined analyses are in `refine.rs`.
fn analysis(args: &[&str]) -> Value {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let plain = ["analyze", "--no-refine", "--out", out, "--format", "json"];
    let output = calibstab(&[&plain, args].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&fs::read(folder.path().join("analysis.json")).unwrap()).unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A statistic of every parameter of the only population.
fn statistic(analysis: &Value, name: &str) -> BTreeMap<String, f64> {
    let populations = analysis["populations"].as_array().unwrap();
    assert_eq!(populations.len(), 1);
    let parameters = populations[0]["parameters"].as_array().unwrap().iter();
    let estimated = parameters.filter(|parameter| parameter["statistics"].is_object());
    estimated
        .map(|parameter| {
            let value = parameter["statistics"][name].as_f64().unwrap();
            (parameter["name"].as_str().unwrap().to_owned(), value)
        })
        .collect()
}

fn finding_ids(analysis: &Value) -> Vec<&str> {
    let findings = analysis["findings"].as_array().unwrap().iter();
    findings.map(|finding| finding["id"].as_str().unwrap()).collect()
}

/// All files below a folder with their content.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.insert(path.clone(), fs::read(&path).unwrap());
        }
    }
    found
}

#[test]
fn the_rows_of_the_thesis_give_its_printed_standard_deviations() {
    let opencv = analysis(&["fixtures/thesis/opencv_camera1"]);
    let fisheye = analysis(&["fixtures/thesis/simple_radial_fisheye_camera3"]);
    let printed = [
        (&opencv, "fx", 51.0312, 1e-4),
        (&opencv, "fy", 6.4776, 1e-4),
        (&opencv, "k1", 0.0107, 1e-4),
        (&opencv, "k2", 0.0153, 1e-4),
        (&opencv, "p1", 0.0020, 1e-4),
        (&opencv, "p2", 0.0044, 1e-4),
        (&fisheye, "f", 9.9028, 1e-4),
        (&fisheye, "k", 0.0068, 1e-4),
    ];
    for (analysis, name, want, last_digit) in printed {
        let found = statistic(analysis, "std")[name];
        assert!((found - want).abs() <= last_digit / 2.0, "{name}: {found}, printed {want}");
    }
    // The thesis prints 0.001216, -0.002536 and 425.412: slips, ten times too large and 0.15 px off.
    let corrected = [
        (&opencv, "p1", (0.001229 + 0.001335 - 0.002218) / 3.0),
        (&opencv, "p2", (0.00258186 + 0.00193668 - 0.00528645) / 3.0),
        (&fisheye, "f", (421.001 + 411.932 + 419.312 + 430.513 + 440.073 + 428.747) / 6.0),
    ];
    for (analysis, name, want) in corrected {
        let found = statistic(analysis, "mean")[name];
        assert!((found / want - 1.0).abs() < 1e-12, "{name}: {found}, want {want}");
    }
}

#[test]
fn the_same_input_gives_the_same_bytes_with_any_number_of_threads() {
    let folder = TempDir::new().unwrap();
    let run = |name: &str, threads: &str| {
        let out = folder.path().join(name);
        let args =
            ["analyze", "fixtures/runs", "--threads", threads, "--out", out.to_str().unwrap()];
        let output = calibstab(&args);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let files: BTreeMap<PathBuf, Vec<u8>> = files(&out)
            .into_iter()
            .map(|(path, content)| (path.strip_prefix(&out).unwrap().to_owned(), content))
            .collect();
        (output.stdout, files)
    };
    let (first, second, third) = (run("a", "1"), run("b", "1"), run("c", "2"));
    assert!(first.1.len() > 10, "{:?}", first.1.keys());
    assert!(first == second && first == third);
}

#[test]
fn every_bad_run_is_named_with_its_place_and_nothing_is_written() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("report");
    let output = calibstab(&[
        "analyze",
        "fixtures/bad",
        "fixtures/identical",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    assert!(!out.exists());
    let errors = text(&output.stderr);
    for want in [
        "fixtures/bad/misspelled_model/cameras.txt:4:3: ",
        "did you mean OPENCV_FISHEYE?",
        "fixtures/bad/nan/cameras.txt:4:40: ",
        "fixtures/bad/wrong_parameter_count/cameras.txt:4:",
        "OPENCV takes 8 parameters, found 7",
        "fixtures/bad/empty_file/cameras.txt: ",
        "fixtures/bad/truncated_images/images.bin: byte ",
        "fixtures/bad/unknown_camera/images.txt:",
        "6 of 9 runs could not be read",
    ] {
        assert!(errors.contains(want), "no `{want}` in:\n{errors}");
    }
}

#[test]
fn skipped_runs_are_listed_in_every_output() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let args = ["analyze", "fixtures/bad", "fixtures/runs/few_images", "--skip-bad", "--out", out];
    let output = calibstab(&args);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: Value =
        serde_json::from_slice(&fs::read(folder.path().join("analysis.json")).unwrap()).unwrap();
    assert_eq!(json["skipped"].as_array().unwrap().len(), 6);
    let markdown = fs::read_to_string(folder.path().join("report.md")).unwrap();
    for text in [text(&output.stdout), markdown.replace('\\', ""), json.to_string()] {
        assert!(text.contains("fixtures/bad/nan/cameras.txt"), "{text}");
        assert!(text.contains("k2 is nan"), "{text}");
    }
    let runs = fs::read_to_string(folder.path().join("runs.csv")).unwrap();
    assert!(runs.contains("fixtures/bad/nan/cameras.txt"), "{runs}");
    let plots = files(&folder.path().join("plots"));
    let svgs: Vec<String> = plots
        .into_iter()
        .filter(|(path, _)| path.extension().unwrap() == "svg")
        .map(|(_, content)| text(&content))
        .collect();
    assert_eq!(svgs.len(), 18);
    assert!(svgs.iter().all(|svg| svg.contains("could not be read")));
}

#[test]
fn one_run_is_no_error_and_is_told_what_to_do() {
    let output = calibstab(&["analyze", "fixtures/thesis/opencv_camera1/run1/cameras.txt"]);
    assert_eq!(output.status.code(), Some(0));
    let shown = text(&output.stdout);
    assert!(shown.contains("1104.37") && shown.contains("repeat the reconstruction"), "{shown}");
    let json = analysis(&["fixtures/thesis/opencv_camera1/run1/cameras.txt"]);
    let parameters = json["populations"][0]["parameters"].as_array().unwrap();
    assert!(parameters.iter().all(|parameter| parameter["statistics"].is_null()));
}

#[test]
fn identical_runs_show_no_stability() {
    let json = analysis(&["fixtures/identical"]);
    assert!(finding_ids(&json).contains(&"duplicate-runs"));
    let runs = json["runs"].as_array().unwrap();
    assert_eq!(runs.iter().filter(|run| run["is_used"] == true).count(), 1);
}

#[test]
fn renumbered_cameras_are_told_apart_by_their_images() {
    let json = analysis(&["fixtures/renumbered"]);
    for population in json["populations"].as_array().unwrap() {
        let focal = &population["parameters"][0]["statistics"];
        assert!(focal["std"].as_f64().unwrap() < 2.0, "{population}");
    }
    let by_id = analysis(&["fixtures/renumbered", "--match", "id"]);
    let focal = &by_id["populations"][0]["parameters"][0]["statistics"];
    assert!(focal["std"].as_f64().unwrap() > 20.0);
}

#[test]
fn a_run_that_broke_off_is_flagged_and_can_be_left_out() {
    let flags = |json: &Value| json["runs"][2]["flags"].as_array().unwrap().clone();
    let kept = analysis(&["fixtures/failed"]);
    assert_eq!(flags(&kept), ["bogus-camera", "few-images"]);
    assert!(statistic(&kept, "std")["fx"] > 100.0);
    let without = analysis(&["fixtures/failed", "--exclude-flagged"]);
    assert_eq!(without["runs"][2]["is_used"], false);
    assert!(statistic(&without, "std")["fx"] < 2.0);
}

#[test]
fn cameras_of_single_images_can_be_pooled() {
    let json = analysis(&["fixtures/one_camera_per_image", "--pool"]);
    let populations = json["populations"].as_array().unwrap();
    assert_eq!(populations.len(), 1);
    assert_eq!(populations[0]["parameters"][0]["statistics"]["n"], 12);
    let apart = analysis(&["fixtures/one_camera_per_image"]);
    assert!(apart["populations"].as_array().unwrap().len() >= 6);
}

#[test]
fn paths_may_be_globs_and_groups_may_be_named_by_pattern_or_manifest() {
    let groups = |json: &Value| -> BTreeMap<String, usize> {
        let mut groups = BTreeMap::new();
        for run in json["runs"].as_array().unwrap() {
            *groups.entry(run["group"].as_str().unwrap().to_owned()).or_default() += 1;
        }
        groups
    };
    let want: BTreeMap<String, usize> =
        [("few_images".to_owned(), 6), ("many_images".to_owned(), 6)].into();
    assert_eq!(groups(&analysis(&["fixtures/runs"])), want);
    assert_eq!(groups(&analysis(&["fixtures/runs/*/run?/cameras.txt"])), want);
    let pattern = ["fixtures/runs", "--group-by", "{group}_images/{run}/cameras.txt"];
    let short: BTreeMap<String, usize> = [("few".to_owned(), 6), ("many".to_owned(), 6)].into();
    assert_eq!(groups(&analysis(&pattern)), short);

    let folder = TempDir::new().unwrap();
    let manifest = folder.path().join("runs.csv");
    let row = |run: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/runs/few_images").join(run);
        format!("{},mine,{run}\n", path.display())
    };
    fs::write(&manifest, format!("path,group,run\n{}{}", row("run1"), row("run4"))).unwrap();
    let mine = analysis(&["--manifest", manifest.to_str().unwrap()]);
    assert_eq!(groups(&mine), [("mine".to_owned(), 2)].into());
}

#[test]
fn what_makes_no_sense_is_refused_with_exit_code_2() {
    let folder = TempDir::new().unwrap();
    let empty = folder.path().to_str().unwrap();
    for (args, want) in [
        (vec!["analyze"], "PATH"),
        (vec!["analyze", "no/such/path"], "no/such/path"),
        (vec!["analyze", "no/such/*"], "nothing fits"),
        (vec!["analyze", empty], "no COLMAP model"),
        (vec!["analyze", "fixtures/runs", "--group-by", "{run}"], "{run}"),
        (vec!["analyze", "fixtures/runs", "--group-by", "x{group}/{run}"], "does not fit"),
        (vec!["analyze", "fixtures/runs", "--format", "json"], "--out"),
        (vec!["analyze", "fixtures/runs", "--match", "single"], "wants one camera a run"),
        (vec!["analyze", "--manifest", "fixtures/README.md"], "README.md"),
        (vec!["analyze", "fixtures/runs", "--threads", "0"], "0"),
        (vec!["man", "no-such-command"], "no-such-command"),
    ] {
        let output = calibstab(&args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        let errors = text(&output.stderr);
        assert!(errors.contains(want), "{args:?}: no `{want}` in:\n{errors}");
        assert!(output.stdout.is_empty(), "{args:?}");
    }
}

#[test]
fn a_pipe_gets_neither_colour_nor_progress() {
    let output = calibstab(&["analyze", "fixtures/failed"]);
    assert!(!output.stdout.contains(&0x1b));
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
}

#[test]
fn schema_completions_and_manual_come_from_the_program() {
    let schema: Value = serde_json::from_slice(&calibstab(&["schema"]).stdout).unwrap();
    assert_eq!(schema["title"], "Analysis");
    assert!(text(&calibstab(&["completions", "bash"]).stdout).contains("exclude-flagged"));
    assert!(text(&calibstab(&["man", "analyze"]).stdout).contains("skip"));
    assert!(text(&calibstab(&["--help"]).stdout).contains("runs/*/cameras.txt"));
}
