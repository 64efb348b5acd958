//! `refine`, and `analyze` of runs that it refines, as their user types them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use calibstab::colmap;
use calibstab::scene::CameraId;
use serde_json::Value;
use tempfile::TempDir;

const FEW: &str = "fixtures/runs/few_images";

fn calibstab(args: &[&str]) -> Output {
    let mut command = Command::cargo_bin("calibstab").unwrap();
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Analyses into a folder of its own; the JSON that came out.
fn analysis(args: &[&str]) -> Value {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let output = calibstab(&[&["analyze", "--out", out, "--format", "json"], args].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&fs::read(folder.path().join("analysis.json")).unwrap()).unwrap()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

/// Every sample: population, parameter, sample.
fn samples(analysis: &Value) -> Vec<(&Value, &Value, &Value)> {
    let populations = list(&analysis["populations"]).iter();
    let parameters =
        populations.flat_map(|one| list(&one["parameters"]).iter().map(move |p| (one, p)));
    parameters.flat_map(|(one, p)| list(&p["samples"]).iter().map(move |s| (one, p, s))).collect()
}

fn states(analysis: &Value, parameter: &str) -> Vec<String> {
    let of = |p: &Value| p["name"] == parameter;
    let found = samples(analysis).into_iter().filter(|(_, p, _)| of(p));
    found.map(|(_, _, sample)| sample["state"].as_str().unwrap().to_owned()).collect()
}

fn said(analysis: &Value, id: &str) -> Vec<String> {
    let findings = list(&analysis["findings"]).iter().filter(|finding| finding["id"] == id);
    findings.map(|finding| finding["text"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn what_colmap_left_stands_beside_what_was_refined() {
    let (refined, left) = (analysis(&[FEW]), analysis(&[FEW, "--no-refine"]));
    assert_eq!(refined["provenance"]["options"]["refinement"]["mode"], "self-calibration");
    assert_eq!(left["provenance"]["options"]["refinement"], Value::Null);
    let pairs = list(&refined["populations"]).iter().zip(list(&left["populations"]));
    let mut moved = 0;
    for (refined, left) in pairs {
        assert_eq!(refined["as_left"]["parameters"], left["parameters"]);
        let px = |spread: &Value| spread["rms_px"].as_f64().unwrap();
        let as_left = &refined["as_left"]["spread"];
        assert_eq!(as_left["raw_rms_px"].as_f64(), Some(px(&left["spread"]["raw"])));
        assert_eq!(as_left["rotated_rms_px"].as_f64(), Some(px(&left["spread"]["rotated"])));
        assert!((px(&refined["spread"]["raw"]) - px(&left["spread"]["raw"])).abs() > 0.0);
        assert!(left["as_left"].is_null() && left["predicted_correlations"].is_null());
        let parameters = list(&refined["parameters"]).iter().zip(list(&left["parameters"]));
        moved += parameters.filter(|(a, b)| a["statistics"] != b["statistics"]).count();
    }
    assert_eq!(moved, 12, "all but the principal points of two cameras");
    assert!(states(&refined, "fx").iter().all(|state| state == "estimated"));
    assert!(states(&refined, "cx").iter().all(|state| state == "held"));
    assert!(states(&left, "cx").iter().all(|state| state == "presumed-held"));
}

#[test]
fn refined_samples_are_what_refine_writes() {
    let json = analysis(&[FEW]);
    let folder = TempDir::new().unwrap();
    let mut compared = 0;
    for run in ["run1", "run4"] {
        let (model, out) = (format!("{FEW}/{run}"), folder.path().join(run));
        let output = calibstab(&["refine", &model, "--out", out.to_str().unwrap(), "--quiet"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let written = colmap::read(&out).unwrap();
        for (_, parameter, sample) in samples(&json) {
            if sample["run"] != run {
                continue;
            }
            let id: u32 = sample["camera_id"].as_u64().unwrap().try_into().unwrap();
            let intrinsics = written.cameras[&CameraId(id)].intrinsics;
            let mut params = intrinsics.model().params.iter();
            let place = params.position(|param| param.name == parameter["name"]).unwrap();
            let value = sample["value"].as_f64().unwrap();
            assert_eq!(value.to_bits(), intrinsics.params()[place].to_bits(), "{sample}");
            compared += 1;
        }
    }
    assert_eq!(compared, 2 * 16);
}

/// As `fixtures/README.md` has it.
const TRUTH: [(&str, [f64; 8]); 2] = [
    ("OPENCV", [500.0, 497.0, 320.0, 240.0, -0.28, 0.09, 0.0006, -0.0004]),
    ("OPENCV_FISHEYE", [255.0, 256.5, 320.0, 320.0, 0.02, -0.012, 0.004, -0.001]),
];

#[test]
fn estimates_are_off_the_truth_by_as_much_as_the_adjustments_predict() {
    let json = analysis(&["fixtures/runs"]);
    let mut off: Vec<f64> = Vec::new();
    for population in list(&json["populations"]) {
        let model = population["model"].as_str().unwrap();
        let truth = TRUTH.iter().find(|(name, _)| *name == model).unwrap().1;
        for (parameter, truth) in list(&population["parameters"]).iter().zip(truth) {
            for sample in list(&parameter["samples"]) {
                let Some(std) = sample["predicted_std"].as_f64() else { continue };
                off.push((sample["value"].as_f64().unwrap() - truth) / std);
            }
        }
    }
    assert_eq!(off.len(), 12 * 12);
    let rms = (off.iter().map(|z| z * z).sum::<f64>() / off.len() as f64).sqrt();
    // Some parameters go with each other, so that these are fewer than 144 independent numbers: their RMS has a std of 0.1.
    assert!((0.7..1.3).contains(&rms), "{rms}");
    assert!(off.iter().all(|z| z.abs() < 5.0), "{off:?}");
}

#[test]
fn the_record_of_a_run_holds_the_covariance_of_each_camera() {
    let json = analysis(&[FEW]);
    let runs = list(&json["runs"]);
    for run in runs {
        let refinement = &run["refinement"];
        assert!(refinement["failure"].is_null());
        let adjustment = &refinement["adjustment"];
        assert_eq!(adjustment["stopped"], "converged");
        let cost = |name: &str| adjustment[name].as_f64().unwrap();
        // The fixtures are at the optimum but for rounding.
        assert!(cost("cost") <= cost("initial_cost") * (1.0 + 1e-12), "{adjustment}");
        // The fixtures' noise is 0.5 px.
        assert!((cost("sigma_px") - 0.5).abs() < 0.03, "{adjustment}");
        for camera in list(&adjustment["cameras"]) {
            assert_eq!(camera["free"].as_array().unwrap().len(), 6);
            let matrix: Vec<&[Value]> = list(&camera["covariance"]).iter().map(list).collect();
            assert!(matrix.len() == 6 && matrix.iter().all(|row| row.len() == 6));
        }
    }
    assert_eq!(runs.len(), 6);
}

#[test]
fn a_run_that_does_not_converge_is_no_sample_and_is_named() {
    let json = analysis(&["fixtures/failed"]);
    let failed: Vec<_> =
        samples(&json).into_iter().filter(|(_, _, sample)| sample["run"] == "run3").collect();
    assert_eq!(failed.len(), 8);
    for (_, _, sample) in failed {
        assert_eq!(sample["state"], "failed");
        assert!(sample["value"].is_null() && sample["camera_id"] == 1);
    }
    let told = said(&json, "refinement-failed");
    assert!(told.len() == 1 && told[0].starts_with("run3: refining failed: "), "{told:?}");
    assert!(said(&json, "missing-camera").is_empty(), "the camera is there");
    let population = &json["populations"][0];
    assert_eq!(population["parameters"][0]["statistics"]["n"], 3);
    assert_eq!(population["as_left"]["parameters"][0]["statistics"]["n"], 4);
    assert_eq!(population["spread"]["n"], 3);
    assert_eq!(population["as_left"]["spread"]["n"], 4);
}

/// A folder `group` with the first runs of the fixtures, the last without images.
fn with_a_lone_run(folder: &Path) {
    for run in ["run1", "run2", "run3"] {
        let (from, to) = (Path::new(env!("CARGO_MANIFEST_DIR")).join(FEW), folder.join("group"));
        fs::create_dir_all(to.join(run)).unwrap();
        for entry in fs::read_dir(from.join(run)).unwrap() {
            let name = entry.unwrap().file_name();
            if run != "run3" || name == "cameras.txt" {
                fs::copy(from.join(run).join(&name), to.join(run).join(&name)).unwrap();
            }
        }
    }
}

#[test]
fn a_group_with_a_run_without_images_stays_as_colmap_left_it() {
    let folder = TempDir::new().unwrap();
    with_a_lone_run(folder.path());
    let path = folder.path().to_str().unwrap();
    let json = analysis(&[path]);
    let told = said(&json, "not-refined");
    assert!(
        told.len() == 1 && told[0].contains("in run3: all are as COLMAP left them"),
        "{told:?}"
    );
    assert_eq!(json["populations"], analysis(&[path, "--no-refine"])["populations"]);
    // Beside a group that can be refined, it is still left alone.
    let both = analysis(&[path, "fixtures/runs/many_images"]);
    let refined: Vec<bool> =
        list(&both["populations"]).iter().map(|one| one["as_left"].is_object()).collect();
    assert_eq!(refined, [false, true, false, true]);
}

#[test]
fn lone_cameras_are_no_remark_unless_refining_was_asked_for() {
    let lone = ["analyze", "fixtures/thesis/opencv_camera1"];
    assert!(calibstab(&lone).stderr.is_empty());
    let asked = calibstab(&[&lone[..], &["--loss", "cauchy:1"]].concat());
    assert!(asked.status.success());
    assert!(text(&asked.stderr).contains("nothing was refined"));
}

#[test]
fn what_moves_and_what_a_residual_costs_can_be_chosen() {
    let all = analysis(&[FEW, "--refine", "all"]);
    for name in ["fx", "cx", "k1"] {
        assert!(states(&all, name).iter().all(|state| state == "estimated"), "{name}");
    }
    let named = analysis(&[FEW, "--refine", "1:fx,k1", "--refine", "2:k4"]);
    let front = ["estimated", "held"].map(|state| vec![state.to_owned(); 6].to_vec());
    assert_eq!(states(&named, "fx"), [&front[0][..], &front[1]].concat());
    assert_eq!(states(&named, "k4"), front[0]);
    let robust = analysis(&[FEW, "--loss", "cauchy:1"]);
    assert!(states(&robust, "fx").iter().all(|state| state == "estimated"));
    // The estimated ones have a std as under the squared loss; the noise is normal, where robust losses lose a little.
    let stds = |json: &Value| -> Vec<Option<f64>> {
        samples(json).iter().map(|(_, _, sample)| sample["predicted_std"].as_f64()).collect()
    };
    let mut compared = 0;
    for (robust, squared) in stds(&robust).into_iter().zip(stds(&analysis(&[FEW]))) {
        assert_eq!(robust.is_some(), squared.is_some());
        if let Some((robust, squared)) = robust.zip(squared) {
            assert!((0.8..1.5).contains(&(robust / squared)), "{robust} {squared}");
            compared += 1;
        }
    }
    assert!(compared > 50, "{compared}");
    for population in list(&robust["populations"]) {
        assert!(population["prediction"]["consistency"]["found"]["birge"].as_f64().is_some());
        assert!(population["prediction"]["spread"]["rms_px"].as_f64().is_some());
    }
    let fx = |json: &Value| json["populations"][0]["parameters"][0]["statistics"]["mean"].as_f64();
    assert!(fx(&robust) != fx(&analysis(&[FEW])));
}

#[test]
fn tables_say_which_values_are_whose() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let output = calibstab(&["analyze", FEW, "--out", out, "--format", "csv,md"]);
    let shown = text(&output.stdout);
    for want in
        ["OPENCV 640 x 480, refined", "std by BA", "COLMAP's std", "As COLMAP left the runs"]
    {
        assert!(shown.contains(want), "{want}");
    }
    let rows = |file: &str, source: &str| {
        let table = fs::read_to_string(folder.path().join(file)).unwrap();
        table.lines().filter(|line| line.split(',').any(|cell| cell == source)).count()
    };
    assert_eq!([rows("samples.csv", "refined"), rows("samples.csv", "colmap")], [96, 96]);
    assert_eq!([rows("statistics.csv", "refined"), rows("statistics.csv", "colmap")], [16, 16]);
    assert_eq!([rows("spread.csv", "refined"), rows("spread.csv", "colmap")], [6, 6]);
    let report = fs::read_to_string(folder.path().join("report.md")).unwrap();
    assert!(report.contains("How the runs were refined") && report.contains("| correlation |"));
}

#[test]
fn refine_writes_the_form_that_it_read_and_says_how_it_went() {
    let folder = TempDir::new().unwrap();
    for (form, file) in [("text", "images.txt"), ("binary", "images.bin")] {
        let out = folder.path().join(form);
        let (model, out_text) = (format!("fixtures/formats/{form}"), out.to_str().unwrap());
        let args = ["refine", &model, "--out", out_text, "--refine", "all", "--json", "--verbose"];
        let output = calibstab(&args);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(out.join(file).exists(), "{form}");
        let result: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(result["reason"], "converged");
        let numbered = |line: &&str| {
            line.split_whitespace().next().is_some_and(|word| word.parse::<u64>().is_ok())
        };
        let told = text(&output.stderr);
        // One more line says how many files were written.
        let steps = told.lines().filter(numbered).count() - 1;
        assert_eq!(steps as u64, result["iterations"].as_u64().unwrap(), "{told}");
        let cost = |name: &str| result[name].as_f64().unwrap();
        assert!(cost("cost") < 0.999 * cost("initial_cost"), "cx and cy were held before");
        let camera = &result["cameras"][0];
        assert!((0..8).all(|place| camera["before"][place] != camera["after"][place]));
    }
    let [text, binary] =
        ["text", "binary"].map(|form| colmap::read(&folder.path().join(form)).unwrap());
    assert_eq!(text, binary);
}

#[test]
fn what_cannot_be_refined_is_refused_with_exit_code_2() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    let refine = |model: &'static str| vec!["refine", model, "--out", out.to_str().unwrap()];
    for (args, want) in [
        (refine("fixtures/formats/lone_cameras"), "no images and points"),
        ([refine("fixtures/formats/text"), vec!["--refine", "k7"]].concat(), "no parameter `k7`"),
        ([refine("fixtures/formats/text"), vec!["--loss", "tukey"]].concat(), "there is no loss"),
        (vec!["analyze", FEW, "--refine", "k7"], "no camera of any run has a parameter `k7`"),
        (vec!["analyze", FEW, "--refine", "9:fx"], "no run has a camera 9"),
        (vec!["analyze", FEW, "--refine", "1:k4"], "no run has a camera 1 with a parameter `k4`"),
        (vec!["analyze", FEW, "--no-refine", "--loss", "huber"], "--no-refine"),
        (vec!["analyze", FEW, "--no-refine", "--refine", "all"], "--no-refine"),
    ] {
        let output = calibstab(&args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        let errors = text(&output.stderr);
        assert!(errors.contains(want), "{args:?}: no `{want}` in:\n{errors}");
        assert!(output.stdout.is_empty() && !out.exists(), "{args:?}");
    }
}
