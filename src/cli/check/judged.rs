//! What a gate looks at in `analysis.json`, and nothing else of it: other fields may come and go.

use std::fs;
use std::path::Path;

use serde::Deserialize;

use super::super::failure::Failure;
use crate::stability::{ParameterClass, SCHEMA_VERSION, VerdictKind};

/// One camera of one group, as analysed.
#[derive(Debug, Deserialize)]
pub(super) struct Camera {
    pub group: String,
    pub camera: String,
    pub model: String,
    pub verdict: Verdict,
    pub parameters: Vec<Parameter>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Verdict {
    pub kind: VerdictKind,
    pub n: usize,
    pub spread_px: Option<f64>,
    pub spread_interval_95: Option<[f64; 2]>,
    pub reasons: Vec<Reason>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Reason {
    /// As text: a later calibstab may know more of them.
    pub id: String,
}

#[derive(Debug, Deserialize)]
pub(super) struct Parameter {
    pub name: String,
    pub class: ParameterClass,
    pub statistics: Option<Statistics>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Statistics {
    pub mean: f64,
    pub relative_std: Option<f64>,
    pub std_interval_95: [f64; 2],
}

#[derive(Deserialize)]
struct Version {
    schema_version: u32,
}

#[derive(Deserialize)]
struct Analysis {
    populations: Vec<Camera>,
}

/// The cameras of an `analysis.json`.
pub(super) fn judged_cameras(path: &Path) -> Result<Vec<Camera>, Failure> {
    let failed = |why: String| Failure::Input(format!("{}{why}", path.display()));
    let content =
        fs::read(path).map_err(|error| failed(format!(": could not be read: {error}")))?;
    cameras_of(&content).map_err(failed)
}

fn cameras_of(content: &[u8]) -> Result<Vec<Camera>, String> {
    // The version first: of another one nothing else is known.
    let Version { schema_version } = serde_json::from_slice(content).map_err(|e| not_read(&e))?;
    if schema_version != SCHEMA_VERSION {
        return Err(format!(
            ": its schema_version is {schema_version}, this calibstab reads {SCHEMA_VERSION}: analyse the runs again"
        ));
    }
    let analysis: Analysis = serde_json::from_slice(content).map_err(|error| not_read(&error))?;
    Ok(analysis.populations)
}

fn not_read(error: &serde_json::Error) -> String {
    let (line, column) = (error.line(), error.column());
    let told = error.to_string();
    let why = told.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&told);
    format!(":{line}:{column}: not what calibstab analyze writes: {why}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::analysis_json;
    use crate::stability::{Options, analyze};

    #[test]
    fn what_analyze_writes_is_read_back() {
        let analysis = analyze(vec![], vec![], Options::default()).unwrap();
        let written = analysis_json(&analysis).unwrap();
        assert!(cameras_of(written.as_bytes()).unwrap().is_empty());
    }

    #[test]
    fn what_it_does_not_write_is_refused_with_its_place() {
        let error = |content: &str| cameras_of(content.as_bytes()).unwrap_err();
        assert!(error("").starts_with(":1:0: not what calibstab analyze writes: EOF"));
        assert!(error("{}").contains("missing field `schema_version`"));
        assert!(error("[1,").contains(":1:3: "), "{}", error("[1,"));
        assert!(error(r#"{"schema_version": 0}"#).contains("reads 1: analyse the runs again"));
        let error = error("{\"schema_version\": 1,\n\"populations\": [{\"group\": 3}]}");
        assert!(error.starts_with(":2:"), "{error}");
    }
}
