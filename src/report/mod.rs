//! An analysis as people and programs read it: tables, JSON, CSV, Markdown, plots.
//!
//! Draws and never computes: every number shown stands in the analysis.

mod csv;
mod json;
mod markdown;
mod number;
pub mod plot;
mod sections;
mod side_by_side;
mod table;
mod terminal;

pub use csv::{runs_csv, samples_csv, statistics_csv};
pub use json::{analysis_json, schema_json};
pub use markdown::markdown;
pub use terminal::terminal;
