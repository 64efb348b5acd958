//! From paths on the command line to runs.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;
use serde::Deserialize;
use sha2::{Digest, Sha256};

use super::failure::Failure;
use super::grouping::{PathPattern, Place, by_parent, with_slashes};
use crate::colmap::{self, ModelFiles};
use crate::stability::{InputFile, Options, Run, Skipped};

/// Which reconstructions to read, and how they belong together.
#[derive(Args)]
pub(super) struct Inputs {
    /// A cameras file, a model folder, a run folder with sparse or sparse/0, a folder of any of these, or a quoted glob
    #[arg(value_name = "PATH", required_unless_present = "manifest")]
    paths: Vec<PathBuf>,

    /// Name group and run by parts of the path: {run} is the run, all other {names} together the group, * any text
    ///
    /// The pattern is matched against the end of each model's path. By default the folder of a run names it (without
    /// sparse and sparse/0), and runs of one parent folder are a group.
    #[arg(long, value_name = "PATTERN", value_parser = PathPattern::parse)]
    group_by: Option<PathPattern>,

    /// Take the runs from a CSV file with the columns path, group and run; paths are relative to the file
    #[arg(long, value_name = "FILE", conflicts_with_all = ["paths", "group_by"])]
    manifest: Option<PathBuf>,

    /// Go on without the runs that cannot be read; every output lists them
    #[arg(long)]
    skip_bad: bool,
}

/// A row of a manifest.
#[derive(Deserialize)]
struct ManifestRow {
    path: PathBuf,
    group: String,
    run: String,
}

/// A run that is not read yet, or the reason why there is none at its path.
struct Located {
    path: String,
    place: Place,
    model: ModelFiles,
}

impl Inputs {
    /// What of these arguments bears on the result.
    pub(super) fn options(&self) -> Result<Options, Failure> {
        let manifest =
            self.manifest.as_deref().map(input_file).transpose().map_err(Failure::Input)?;
        let group_by = self.group_by.as_ref().map(ToString::to_string);
        Ok(Options { group_by, manifest, skip_bad: self.skip_bad, ..Options::default() })
    }

    /// Reads every run; what cannot be read is an error that lists all of it, or skipped on request.
    pub(super) fn read(&self, quiet: bool) -> Result<(Vec<Run>, Vec<Skipped>), Failure> {
        let mut bad: Vec<Skipped> = Vec::new();
        let located = match &self.manifest {
            Some(manifest) => models_of_manifest(manifest, &mut bad)?,
            None => self.models_at_paths(&mut bad)?,
        };
        unique_places(&located)?;
        let progress = progress_bar("reading runs", located.len(), quiet);
        let read: Vec<Result<Run, Skipped>> = located
            .into_par_iter()
            .map(|located| {
                let run = located.read();
                progress.inc(1);
                run
            })
            .collect();
        progress.finish_and_clear();
        let mut runs = Vec::new();
        for run in read {
            match run {
                Ok(run) => runs.push(run),
                Err(skipped) => bad.push(skipped),
            }
        }
        if !bad.is_empty() && (!self.skip_bad || runs.is_empty()) {
            return Err(unreadable(&bad, runs.len()));
        }
        bad.sort_by(|a, b| natord::compare(&a.path, &b.path));
        Ok((runs, bad))
    }

    fn models_at_paths(&self, bad: &mut Vec<Skipped>) -> Result<Vec<Located>, Failure> {
        let mut models: Vec<ModelFiles> = Vec::new();
        for path in
            self.paths.iter().map(|path| expanded(path)).collect::<Result<Vec<_>, _>>()?.concat()
        {
            match colmap::find(&path) {
                Ok(found) => models.extend(found),
                Err(error) => {
                    bad.push(Skipped { path: with_slashes(&path), reason: error.to_string() });
                }
            }
        }
        let mut seen = BTreeSet::new();
        // A folder named twice, or a folder and a model in it, is one model.
        models.retain(|model| {
            let cameras = model.cameras.canonicalize().unwrap_or_else(|_| model.cameras.clone());
            seen.insert(cameras)
        });
        let places = match &self.group_by {
            Some(pattern) => {
                let place =
                    |model: &ModelFiles| pattern.place(&model.cameras).map_err(Failure::Input);
                models.iter().map(place).collect::<Result<Vec<_>, _>>()?
            }
            None => by_parent(&models.iter().map(ModelFiles::run).collect::<Vec<_>>()),
        };
        let located = models.into_iter().zip(places).map(|(model, place)| Located {
            path: with_slashes(&model.cameras),
            place,
            model,
        });
        Ok(located.collect())
    }
}

/// The paths that a quoted glob stands for; a path that exists stands for itself.
fn expanded(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    let text = path.to_string_lossy();
    if path.exists() || !text.contains(['*', '?', '[']) {
        return Ok(vec![path.to_owned()]);
    }
    let failed = |why: &dyn std::fmt::Display| Failure::Input(format!("{text}: {why}"));
    let found = glob::glob(&text).map_err(|error| failed(&error))?;
    let paths = found.collect::<Result<Vec<_>, _>>().map_err(|error| failed(&error))?;
    if paths.is_empty() {
        return Err(failed(&"nothing fits this pattern"));
    }
    Ok(paths)
}

fn models_of_manifest(manifest: &Path, bad: &mut Vec<Skipped>) -> Result<Vec<Located>, Failure> {
    let failed =
        |why: &dyn std::fmt::Display| Failure::Input(format!("{}: {why}", manifest.display()));
    let folder = manifest.parent().unwrap_or(Path::new(""));
    let mut rows = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(manifest)
        .map_err(|error| failed(&error))?;
    let mut located = Vec::new();
    for row in rows.deserialize() {
        let ManifestRow { path, group, run } = row.map_err(|error| failed(&error))?;
        let path = folder.join(path);
        match colmap::find_one(&path) {
            Ok(model) => {
                located.push(Located {
                    path: with_slashes(&path),
                    place: Place { group, run },
                    model,
                });
            }
            Err(error) => {
                bad.push(Skipped { path: with_slashes(&path), reason: error.to_string() })
            }
        }
    }
    if located.is_empty() && bad.is_empty() {
        return Err(failed(
            &"no run is listed: wanted the columns path, group and run, and a line for each run",
        ));
    }
    Ok(located)
}

/// Two models that claim one place would be told apart by nothing.
fn unique_places(located: &[Located]) -> Result<(), Failure> {
    let mut by_place: Vec<&Located> = located.iter().collect();
    by_place.sort_by(|a, b| a.place.cmp(&b.place));
    match by_place.windows(2).find(|pair| pair[0].place == pair[1].place) {
        None => Ok(()),
        Some(pair) => Err(Failure::Input(format!(
            "{} and {} are both run `{}` of group `{}`: `--group-by` or `--manifest` can tell them apart",
            pair[0].path, pair[1].path, pair[0].place.run, pair[0].place.group
        ))),
    }
}

/// Reads every model at these paths, named by group and run.
pub(super) fn read_all(paths: Vec<PathBuf>, quiet: bool) -> Result<Vec<Run>, Failure> {
    let inputs = Inputs { paths, group_by: None, manifest: None, skip_bad: false };
    let (runs, _) = inputs.read(quiet)?;
    Ok(runs.into_iter().map(named_in_full).collect())
}

/// What `analyze` takes for groups is here part of a calibration's name.
pub(super) fn named_in_full(run: Run) -> Run {
    let name = if run.group.is_empty() { run.name } else { format!("{}/{}", run.group, run.name) };
    Run { group: String::new(), name, ..run }
}

/// Reads the one model at a path, as a run of this name.
pub(super) fn read_one(path: &Path, name: &str) -> Result<Run, Failure> {
    let failed = |reason: String| Failure::Input(reason);
    let model = colmap::find_one(path).map_err(|error| failed(error.to_string()))?;
    let place = Place { group: String::new(), run: name.to_owned() };
    let located = Located { path: with_slashes(path), place, model };
    located.read().map_err(|skipped| failed(skipped.reason))
}

impl Located {
    fn read(self) -> Result<Run, Skipped> {
        let Self { path, place: Place { group, run: name }, model } = self;
        let skipped = |reason: String| Skipped { path: path.clone(), reason };
        let scene = model.read().map_err(|error| skipped(error.to_string()))?;
        let files = model.paths().map(input_file).collect::<Result<_, _>>().map_err(skipped)?;
        Ok(Run {
            group,
            name,
            files,
            remarks: model.remarks,
            scene,
            refinement: None,
            inside: None,
        })
    }
}

pub(super) fn input_file(file: &Path) -> Result<InputFile, String> {
    let path = with_slashes(file);
    let content = fs::read(file).map_err(|error| format!("{path}: cannot be read: {error}"))?;
    Ok(InputFile { path, sha256: hexadecimal(&Sha256::digest(content)) })
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Lists every run that could not be read.
fn unreadable(bad: &[Skipped], readable: usize) -> Failure {
    let mut text: String = bad.iter().map(|skipped| format!("{}\n", skipped.reason)).collect();
    let (count, total) = (bad.len(), bad.len() + readable);
    text.push_str(&format!("{count} of {total} runs could not be read"));
    if readable > 0 {
        text.push_str("; `--skip-bad` goes on without them");
    }
    Failure::Input(text)
}

/// A progress bar, on a terminal only.
pub(super) fn progress_bar(doing: &str, count: usize, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(count as u64), target);
    let template = format!("{doing} {{bar:40}} {{pos}}/{{len}} {{eta}}");
    match ProgressStyle::with_template(&template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
