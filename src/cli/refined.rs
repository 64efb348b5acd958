//! What `calibstab refine` says of an adjustment.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::bundle::{CameraOutcome, Clustered, Covariance, Dropped, Outcome};
use crate::least_squares::{Reason, Trial};
use crate::stability::ClusteredCovariance;

/// Over the lines of `step`.
pub(super) const STEP_HEAD: &str =
    "step            cost       fall  predicted   gradient       step  damping";

/// One line for a step.
pub(super) fn step(trial: &Trial) -> String {
    let fall = trial.fall.map_or("back".to_owned(), |fall| format!("{fall:.3e}"));
    let [predicted, gradient, length] = match trial.step {
        Some(step) => {
            [step.predicted, step.gradient, step.length].map(|value| format!("{value:.3e}"))
        }
        None => ["singular", "", ""].map(str::to_owned),
    };
    format!(
        "{:4}  {:.8e} {fall:>10} {predicted:>10} {gradient:>10} {length:>10}  {:.1e}",
        trial.iteration, trial.cost, trial.damping
    )
}

/// What is to be known beside the result.
pub(super) fn remarks(outcome: &Outcome) -> Vec<String> {
    let mut remarks = Vec::new();
    match outcome.reason {
        Reason::Converged | Reason::Rounding => {}
        Reason::IterationLimit => {
            remarks.push(format!("stopped after {} steps without convergence", outcome.iterations));
        }
        Reason::Stuck => {
            remarks.push("stopped without convergence: no step leads downhill".to_owned());
        }
    }
    let Dropped { unprojectable, lone_points, of_lone_points } = outcome.dropped;
    if unprojectable > 0 {
        remarks.push(format!(
            "{unprojectable} observations cannot be projected at the start and were left out"
        ));
    }
    if lone_points > 0 {
        remarks.push(format!(
            "{lone_points} points are seen by fewer than two images and were left out with their {of_lone_points} observations"
        ));
    }
    if outcome.components > 1 {
        let count = outcome.components;
        remarks.push(format!("the model is in {count} parts that share no point: their places, directions and sizes are unrelated"));
    }
    if outcome.rigs_dissolved {
        remarks.push(
            "images of a rig moved freely: each camera is written as a rig of its own".to_owned(),
        );
    }
    for camera in &outcome.cameras {
        if camera.images == 0 {
            remarks.push(format!("camera {} took no image that takes part", camera.id));
        }
        for &place in &camera.at_bound {
            let name = camera.after.intrinsics.model().params[place].name;
            remarks.push(format!("camera {}: {name} ended on its bound", camera.id));
        }
        if let Some(why) = &camera.implausible {
            remarks.push(format!("camera {} is no real lens: {why}", camera.id));
        }
    }
    remarks
}

/// The result for programs.
pub(super) fn json(outcome: &Outcome) -> String {
    let covariance = outcome.covariance.as_ref().map(|covariance| {
        let params = covariance.params.iter();
        let params = params.map(|param| json!({"camera": param.camera.0, "name": param.name}));
        let words = covariance.open.iter().map(|direction| covariance.words(direction));
        json!({
            "params": params.collect::<Vec<Value>>(),
            "matrix": covariance.matrix,
            "clustered": covariance.clustered.iter().filter_map(clustered).collect::<Vec<Value>>(),
            "open": words.collect::<Vec<String>>(),
        })
    });
    let cameras = outcome.cameras.iter().map(|camera| {
        let model = camera.after.intrinsics.model();
        let names = |places: &[usize]| -> Vec<&str> {
            places.iter().map(|&place| model.params[place].name).collect()
        };
        json!({
            "id": camera.id.0,
            "model": model.name,
            "images": camera.images,
            "before": camera.before.intrinsics.params(),
            "after": camera.after.intrinsics.params(),
            "free": names(&camera.free),
            "at_bound": names(&camera.at_bound),
            "implausible": camera.implausible,
        })
    });
    let Dropped { unprojectable, lone_points, of_lone_points } = outcome.dropped;
    let value = json!({
        "reason": reason(outcome.reason),
        "iterations": outcome.iterations,
        "initial_cost": outcome.initial_cost,
        "cost": outcome.cost,
        "images": outcome.images,
        "points": outcome.points,
        "observations": outcome.observations,
        "dropped": {
            "unprojectable": unprojectable,
            "lone_points": lone_points,
            "of_lone_points": of_lone_points,
        },
        "components": outcome.components,
        "unknowns": outcome.unknowns,
        "rank": outcome.rank,
        "sigma_px": outcome.sigma_px,
        "rigs_dissolved": outcome.rigs_dissolved,
        "cameras": cameras.collect::<Vec<Value>>(),
        "covariance": covariance,
    });
    format!("{value:#}\n")
}

fn clustered(clustered: &Clustered) -> Option<Value> {
    let ClusteredCovariance { images, covariance, ratio, null_interval } =
        ClusteredCovariance::new(clustered)?;
    Some(json!({
        "camera": clustered.camera.0,
        "images": images,
        "matrix": covariance,
        "ratio": ratio,
        "null_interval": null_interval,
    }))
}

fn reason(reason: Reason) -> &'static str {
    match reason {
        Reason::Converged => "converged",
        Reason::Rounding => "converged to rounding",
        Reason::IterationLimit => "stopped at the limit",
        Reason::Stuck => "stuck",
    }
}

/// The result.
pub(super) fn summary(outcome: &Outcome) -> String {
    let mut text = String::new();
    let Outcome { images, points, observations, iterations, initial_cost, cost, .. } = outcome;
    let ending = reason(outcome.reason);
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{images} images, {points} points, {observations} observations");
    let steps = if *iterations == 1 { "step" } else { "steps" };
    let _ = writeln!(
        text,
        "{ending} after {iterations} {steps}: cost {initial_cost:.6e} -> {cost:.9e}"
    );
    let (unknowns, rank) = (outcome.unknowns, outcome.rank);
    let _ = write!(text, "{unknowns} unknowns, of which {rank} are determined");
    if let Some(sigma) = outcome.sigma_px {
        let _ = write!(text, "; sigma {sigma:.4} px");
    }
    text.push('\n');
    let mut at = 0;
    for camera in outcome.cameras.iter().filter(|camera| camera.images > 0) {
        text.push_str(&table(camera, outcome.covariance.as_ref(), at));
        at += camera.free.len();
    }
    for direction in outcome.covariance.iter().flat_map(|covariance| &covariance.open) {
        if let Some(covariance) = &outcome.covariance {
            let _ = writeln!(text, "\nnot determined: {}", covariance.words(direction));
        }
    }
    text
}

/// One camera: parameters before and after, their standard deviations and correlations.
fn table(camera: &CameraOutcome, covariance: Option<&Covariance>, first: usize) -> String {
    let mut text = String::new();
    let model = camera.after.intrinsics.model();
    let _ = writeln!(text, "\ncamera {}, {}, {} images", camera.id, model.name, camera.images);
    let stds = covariance.and_then(Covariance::stds);
    let names = || camera.free.iter().map(|&place| model.params[place].name);
    let clustered = covariance
        .and_then(|all| all.clustered.iter().find(|one| one.camera == camera.id))
        .and_then(ClusteredCovariance::new);
    let _ = write!(text, "  {:8} {:>14} {:>14}", "", "before", "after");
    if stds.is_some() {
        let _ = write!(text, " {:>9}", "std");
        if clustered.is_some() {
            let _ = write!(text, " {:>9}", "clustered");
        }
        text.push_str("  correlation with");
        for name in names() {
            let _ = write!(text, " {name:>5}");
        }
    }
    text.push('\n');
    let values = camera.before.intrinsics.params().iter().zip(camera.after.intrinsics.params());
    for (place, (before, after)) in values.enumerate() {
        let name = model.params[place].name;
        let std = camera.free.iter().position(|&free| free == place).zip(stds.as_ref());
        let decimals = decimals(*after, std.map(|(row, stds)| stds[first + row]));
        let _ = write!(text, "  {name:8} {before:>14.decimals$} {after:>14.decimals$}");
        match camera.free.iter().position(|&free| free == place) {
            None if camera.at_bound.contains(&place) => text.push_str("  at its bound"),
            None => text.push_str("  held"),
            Some(row) => {
                if let Some((covariance, stds)) = covariance.zip(stds.as_ref()) {
                    let _ = write!(text, " {:>9.decimals$}", stds[first + row]);
                    if let Some(one) = &clustered {
                        let _ = write!(text, " {:>9.decimals$}", one.covariance[row][row].sqrt());
                    }
                    if row > 0 {
                        let _ = write!(text, "{:18}", "");
                    }
                    for column in 0..row {
                        let both = covariance.correlation(first + row, first + column);
                        let _ = write!(text, " {:>5.2}", both.unwrap_or(f64::NAN));
                    }
                }
            }
        }
        text.push('\n');
    }
    text.push_str(&clustered.map_or(String::new(), |one| clustered_words(&one)));
    text
}

fn clustered_words(one: &ClusteredCovariance) -> String {
    let [low, high] = one.null_interval;
    let meaning = match one.stands_out() {
        true => "no chance: errors of one image depend on each other",
        false => "no more than chance",
    };
    format!(
        "  clustered by image: variances {:.2} times the plain ones, by chance {low:.2} to {high:.2}: {meaning}\n",
        one.ratio
    )
}

/// Decimals that show a value to a hundredth of its standard deviation, or to eight digits.
fn decimals(value: f64, std: Option<f64>) -> usize {
    let last = std.map_or(value.abs() * 1e-7, |std| std * 1e-2);
    let power = if last > 0.0 { (-last.log10()).ceil() } else { 0.0 };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // within the bounds
    let decimals = power.clamp(0.0, 12.0) as usize;
    decimals
}
