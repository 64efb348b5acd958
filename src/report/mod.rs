//! An analysis as people and programs read it: tables, JSON, CSV, Markdown, plots.
//!
//! Draws and never computes: every number shown stands in the analysis.

mod between;
mod between_csv;
mod comparison;
mod csv;
mod held_csv;
mod json;
mod markdown;
mod number;
pub mod plot;
mod prediction;
mod prediction_csv;
mod ranking;
mod ranking_csv;
mod refinement;
mod residuals;
mod run_rows;
mod sections;
mod selection;
mod side_by_side;
mod spread;
mod spread_csv;
mod table;
mod terminal;
mod verdict;

pub use between_csv::{comparisons_csv, components_csv};
pub use comparison::comparison_text;
pub use csv::{runs_csv, samples_csv, statistics_csv};
pub use held_csv::held_csv;
pub use json::{
    analysis_json, comparison_json, schema_json, selection_json, selection_schema_json,
};
pub use markdown::markdown;
pub use prediction_csv::prediction_csv;
pub use ranking::{ranking_markdown, ranking_text};
pub use ranking_csv::{cells_csv, choices_csv};
pub use residuals::residuals_csv;
pub use selection::selection_text;
pub use spread_csv::{run_deviations_csv, spread_csv};
pub use terminal::terminal;
