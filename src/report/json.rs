//! The analysis as JSON: the one form that holds everything, at full precision.

use crate::stability::Analysis;

/// `analysis.json`.
pub fn analysis_json(analysis: &Analysis) -> serde_json::Result<String> {
    Ok(serde_json::to_string_pretty(analysis)? + "\n")
}

/// The JSON schema of `analysis.json`.
pub fn schema_json() -> serde_json::Result<String> {
    Ok(serde_json::to_string_pretty(&schemars::schema_for!(Analysis))? + "\n")
}
