//! Which run of which group a model is, told from its path.

use std::fmt;
use std::path::{Component, Path, PathBuf};

use regex_lite::{Regex, escape};

/// A model's place among the others.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub group: String,
    pub run: String,
}

/// Places by default: a run has the name of its folder, and those of one parent folder are a group. Groups are named by
/// their path below what all groups have in common.
pub(super) fn by_parent(runs: &[&Path]) -> Vec<Place> {
    let split: Vec<(PathBuf, String)> = runs.iter().map(|run| parent_and_name(run)).collect();
    let parents: Vec<Vec<Component>> = split
        .iter()
        .map(|(parent, _)| parent.parent().unwrap_or(Path::new("")).components().collect())
        .collect();
    let shared =
        parents.iter().skip(1).fold(parents.first().map_or(0, Vec::len), |shared, parent| {
            let equal = parents[0].iter().zip(parent).take_while(|(a, b)| a == b).count();
            shared.min(equal)
        });
    let name = |parent: &PathBuf| {
        let rest: PathBuf = parent.components().skip(shared).collect();
        with_slashes(&rest)
    };
    split.iter().map(|(parent, run)| Place { group: name(parent), run: run.clone() }).collect()
}

/// The folder that holds a run, and the run's name.
fn parent_and_name(run: &Path) -> (PathBuf, String) {
    let mut run = run.to_owned();
    // A path such as `.` or `..` has no name of its own, a bare `run1` no parent.
    let has_names = run.file_name().is_some()
        && run.parent().is_some_and(|parent| parent.file_name().is_some());
    if !has_names {
        let existing = if run.as_os_str().is_empty() { Path::new(".") } else { &run };
        run = existing.canonicalize().unwrap_or(run);
    }
    let name =
        run.file_name().map_or_else(|| ".".to_owned(), |name| name.to_string_lossy().into_owned());
    run.pop();
    (run, name)
}

/// A path as text with forward slashes, the same on every system.
pub(super) fn with_slashes(path: &Path) -> String {
    let parts: Vec<String> = path
        .components()
        .filter(|part| *part != Component::CurDir)
        .map(|part| match part {
            Component::RootDir => String::new(),
            part => part.as_os_str().to_string_lossy().into_owned(),
        })
        .collect();
    parts.join("/")
}

/// A pattern such as `{group}/{run}/cameras.txt`, matched against the end of a path.
#[derive(Debug, Clone)]
pub(super) struct PathPattern {
    text: String,
    path: Regex,
    names: Vec<String>,
}

impl fmt::Display for PathPattern {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl PathPattern {
    /// `{name}` takes some text without a slash, `*` any such text; `{run}` names the run, all others together the group.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let mut path = String::from("(?:^|/)");
        let mut names: Vec<String> = Vec::new();
        // A model may be text or binary, and the pattern means its folder either way.
        let folder = text.strip_suffix("/cameras.txt").or(text.strip_suffix("/cameras.bin"));
        let mut rest = folder.unwrap_or(text).trim_end_matches('/');
        while let Some(at) = rest.find(['{', '*']) {
            path.push_str(&escape(&rest[..at]));
            if rest[at..].starts_with('*') {
                path.push_str("[^/]*");
                rest = &rest[at + 1..];
                continue;
            }
            let (name, after) = rest[at + 1..]
                .split_once('}')
                .ok_or_else(|| format!("`{text}`: a `{{` is not closed"))?;
            if name.is_empty() || names.iter().any(|other| other == name) {
                return Err(format!("`{text}`: `{{{name}}}` must be a name that stands once"));
            }
            names.push(name.to_owned());
            path.push_str("([^/]+)");
            rest = after;
        }
        path.push_str(&escape(rest));
        path.push('$');
        if !names.iter().any(|name| name == "run") || names.len() < 2 {
            return Err(format!(
                "`{text}`: wanted {{run}} and a name for the group, as in {{group}}/{{run}}"
            ));
        }
        let path = Regex::new(&path).map_err(|error| format!("`{text}`: {error}"))?;
        Ok(Self { text: text.to_owned(), path, names })
    }

    /// The place of a model, by the path of its cameras file or of a folder that holds it.
    pub(super) fn place(&self, cameras: &Path) -> Result<Place, String> {
        let found = cameras.ancestors().find_map(|path| {
            self.path.captures(&with_slashes(path)).map(|found| {
                found
                    .iter()
                    .skip(1)
                    .map(|part| part.map_or("", |part| part.as_str()).to_owned())
                    .collect::<Vec<_>>()
            })
        });
        let parts = found.ok_or_else(|| {
            format!("{}: does not fit `--group-by {}`", with_slashes(cameras), self)
        })?;
        let named = |is_run: bool| {
            let parts =
                self.names.iter().zip(&parts).filter(move |(name, _)| (*name == "run") == is_run);
            parts.map(|(_, part)| part.as_str()).collect::<Vec<_>>().join("/")
        };
        Ok(Place { group: named(false), run: named(true) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(runs: &[&str]) -> Vec<String> {
        let runs: Vec<&Path> = runs.iter().map(Path::new).collect();
        by_parent(&runs)
            .into_iter()
            .map(|place| format!("{}: {}", place.group, place.run))
            .collect()
    }

    #[test]
    fn runs_of_one_parent_are_a_group() {
        assert_eq!(places(&["x/runs/a", "x/runs/b"]), ["runs: a", "runs: b"]);
        assert_eq!(places(&["x/a/r1", "x/b/r1"]), ["a: r1", "b: r1"]);
        assert_eq!(places(&["x/r1", "x/y/r1"]), ["x: r1", "x/y: r1"]);
    }

    #[test]
    fn the_end_of_a_path_may_name_group_and_run() {
        let place = |pattern: &str, path: &str| {
            let place = PathPattern::parse(pattern).unwrap().place(Path::new(path))?;
            Ok::<_, String>(format!("{}: {}", place.group, place.run))
        };
        let path = "/data/day1/seq/run3/sparse/0/cameras.bin";
        assert_eq!(place("{group}/{run}/sparse/0/cameras.txt", path).unwrap(), "seq: run3");
        assert_eq!(place("{day}/{matcher}/{run}/sparse", path).unwrap(), "day1/seq: run3");
        assert_eq!(place("day{day}/*/run{run}/sparse", path).unwrap(), "1: 3");
        assert!(place("{group}/{run}/dense", path).unwrap_err().contains("does not fit"));
    }

    #[test]
    fn a_pattern_without_run_or_group_is_refused() {
        for pattern in ["{group}/cameras.txt", "{run}", "{group/{run}", "{run}/{run}", "{}/{run}"] {
            assert!(PathPattern::parse(pattern).is_err(), "{pattern}");
        }
    }
}
