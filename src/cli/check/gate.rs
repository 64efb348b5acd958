//! Cameras held against limits.

use super::judged::{Camera, Parameter, Statistics};
use super::limits::{CameraRule, Limits, Positive, Rules, Share, Wanted};
use crate::stability::{FindingId, ParameterClass};

/// In limits of parameters this stands for every focal length.
const ANY_FOCAL: &str = "f";

/// What holding cameras against limits came to.
#[derive(Debug)]
pub(super) struct Judgement {
    /// Why it is not well; empty when all limits are kept.
    pub breaches: Vec<Breach>,
    /// How many cameras have a limit.
    pub limited: usize,
}

/// A limit that was not kept.
#[derive(Debug, PartialEq)]
pub(super) struct Breach {
    /// Camera, group and what is wrong, on one line.
    pub text: String,
    /// Whether it is exceeded; else the runs cannot tell.
    pub is_certain: bool,
}

/// The result of one limit.
enum Kept {
    Yes,
    No(String),
    CannotTell(String),
}

/// Holds cameras against rules; fails when one of these is about no camera.
pub(super) fn judge(cameras: &[Camera], rules: &Rules, strict: bool) -> Result<Judgement, String> {
    all_are_about_something(cameras, rules)?;
    let mut breaches = Vec::new();
    let mut limited = 0;
    for camera in cameras {
        let own = rules.of_cameras.iter().rev().filter(|rule| rule.fits(camera));
        let layers: Vec<&Limits> = own
            .map(|rule| &rule.limits)
            .chain([&rules.general])
            .filter(|limits| !limits.is_empty())
            .collect();
        limited += usize::from(!layers.is_empty());
        let breach = |kept| {
            let (is_certain, what) = match kept {
                Kept::Yes => return None,
                Kept::No(what) => (true, what),
                Kept::CannotTell(what) => (false, what),
            };
            Some(Breach { text: format!("{}: {what}", place(camera, cameras)), is_certain })
        };
        breaches.extend(all_limits(camera, &layers, strict).into_iter().filter_map(breach));
    }
    Ok(Judgement { breaches, limited })
}

/// The limits of a camera, one after the other; the first layer that has one decides.
fn all_limits(camera: &Camera, layers: &[&Limits], strict: bool) -> Vec<Kept> {
    let mut kept = Vec::new();
    if let Some(wanted) = layers.iter().find_map(|limits| limits.verdict) {
        kept.push(verdict(camera, wanted));
    }
    if let Some(limit) = layers.iter().find_map(|limits| limits.max_spread_px) {
        kept.push(spread(camera, limit, strict));
    }
    for parameter in &camera.parameters {
        if let Some(limit) = layers.iter().find_map(|limits| share_of(limits, parameter)) {
            kept.push(relative_std(parameter, limit, strict));
        }
    }
    kept
}

/// The limit of a parameter: by its own name, else by that of all focal lengths.
fn share_of(limits: &Limits, parameter: &Parameter) -> Option<Share> {
    let named = |name: &str| limits.max_relative_std.get(name).copied();
    named(&parameter.name)
        .or_else(|| named(ANY_FOCAL).filter(|_| parameter.class == ParameterClass::Focal))
}

fn verdict(camera: &Camera, wanted: Wanted) -> Kept {
    let found = &camera.verdict;
    if found.kind <= wanted.kind() {
        return Kept::Yes;
    }
    let ids: Vec<&str> = found.reasons.iter().map(|reason| reason.id.as_str()).collect();
    let said =
        format!("verdict {}, not {} ({})", found.kind.name(), wanted.kind().name(), ids.join(", "));
    let is_lack =
        |name: &&str| FindingId::all().any(|id| id.name() == *name && id.is_lack_of_runs());
    match ids.iter().all(is_lack) {
        true => Kept::CannotTell(said),
        false => Kept::No(said),
    }
}

fn spread(camera: &Camera, Positive(limit): Positive, strict: bool) -> Kept {
    let verdict = &camera.verdict;
    let Some(px) = verdict.spread_px else {
        return Kept::CannotTell(format!(
            "there is no spread to hold against {limit} px (n = {})",
            verdict.n
        ));
    };
    let interval = verdict.spread_interval_95.filter(|_| strict);
    held_against("spread", "px", px, limit, interval)
}

fn relative_std(parameter: &Parameter, Share(limit): Share, strict: bool) -> Kept {
    let Parameter { name, statistics, .. } = parameter;
    let Some(Statistics { mean, relative_std, std_interval_95 }) = statistics else {
        return Kept::CannotTell(format!(
            "{name} has no std: held, or estimated in fewer than 2 runs"
        ));
    };
    let Some(share) = relative_std else {
        return Kept::CannotTell(format!(
            "{name} has no relative std: its mean is not far from zero"
        ));
    };
    let interval = std_interval_95.map(|std| 100.0 * std / mean.abs());
    let what = format!("relative std of {name}");
    held_against(&what, "%", 100.0 * share, 100.0 * limit, Some(interval).filter(|_| strict))
}

/// A number against its limit; with an interval, that must lie on one side of it.
fn held_against(
    what: &str,
    unit: &str,
    value: f64,
    limit: f64,
    interval: Option<[f64; 2]>,
) -> Kept {
    let shown = short(limit);
    match interval {
        Some([low, high]) if low <= limit && limit <= high => {
            let [value, low, high] = [value, low, high].map(|number| beside(number, limit));
            Kept::CannotTell(format!(
                "{what} {value} {unit}, but its 95 % interval {low} .. {high} {unit} has the limit of {shown} {unit} within"
            ))
        }
        _ if value > limit => {
            Kept::No(format!("{what} {} {unit} > {shown} {unit}", beside(value, limit)))
        }
        _ if value <= limit => Kept::Yes,
        // No number: nothing analyze writes, and nothing that keeps a limit.
        _ => Kept::CannotTell(format!("{what} is no number")),
    }
}

/// A limit as it was written, or nearly: without the last bits of what percent cost.
fn short(limit: f64) -> String {
    format!("{limit:.9e}").parse().map_or(limit, |short: f64| short).to_string()
}

/// A number with two digits, or as many as show on which side of the limit it lies.
fn beside(value: f64, limit: f64) -> String {
    let digits = |digits: usize| format!("{value:.*e}", digits).parse::<f64>().unwrap_or(value);
    let is_told = |shown: &f64| (*shown > limit) == (value > limit);
    (1..16).map(digits).find(is_told).unwrap_or(value).to_string()
}

/// Camera and group; the model too where several populations have these.
fn place(camera: &Camera, all: &[Camera]) -> String {
    let Camera { group, camera: name, model, .. } = camera;
    let alike = all.iter().filter(|other| other.group == *group && other.camera == *name).count();
    if alike > 1 { format!("{name} {group} {model}") } else { format!("{name} {group}") }
}

impl CameraRule {
    fn fits(&self, camera: &Camera) -> bool {
        self.group.as_ref().is_none_or(|pattern| pattern.fits(&camera.group))
            && self.camera.as_ref().is_none_or(|pattern| pattern.fits(&camera.camera))
    }
}

/// A limit that is about nothing would be kept for ever: a misspelled name must not pass.
fn all_are_about_something(cameras: &[Camera], rules: &Rules) -> Result<(), String> {
    if cameras.is_empty() {
        return Err("it has no camera to hold against limits".to_owned());
    }
    let is_parameter = |cameras: &[&Camera], limits: &Limits| {
        let mut names = limits.max_relative_std.keys();
        let is_known = |name: &&String| {
            let only = Limits {
                max_relative_std: [((*name).clone(), Share(1.0))].into(),
                ..Limits::default()
            };
            cameras.iter().flat_map(|one| &one.parameters).any(|p| share_of(&only, p).is_some())
        };
        match names.find(|name| !is_known(name)) {
            Some(name) => Err(format!("no camera has a parameter `{name}`")),
            None => Ok(()),
        }
    };
    is_parameter(&cameras.iter().collect::<Vec<_>>(), &rules.general)?;
    for (index, rule) in rules.of_cameras.iter().enumerate() {
        let which = || format!("[[camera]] number {}", index + 1);
        let fitting: Vec<&Camera> = cameras.iter().filter(|camera| rule.fits(camera)).collect();
        if fitting.is_empty() {
            const NAMED: usize = 8;
            let known = cameras
                .iter()
                .take(NAMED)
                .map(|one| format!("`{}` of `{}`", one.camera, one.group));
            let mut known: Vec<String> = known.collect();
            known
                .extend((cameras.len() > NAMED).then(|| format!("{} more", cameras.len() - NAMED)));
            return Err(format!("{} fits no camera; there are {}", which(), known.join(", ")));
        }
        is_parameter(&fitting, &rule.limits)
            .map_err(|why| format!("{}: {why} that it fits", which()))?;
    }
    Ok(())
}
