//! The analysis as Markdown: for a pull request, a wiki, a CI job's summary.

use std::fmt::Write;

use super::sections;
use super::side_by_side::side_by_side;
use super::spread::{overlap_words, parts_table, spread_table, spread_words};
use super::table::escaped;
use crate::stability::Analysis;

/// The analysis as Markdown, with pictures (relative path, alternative text) at the end.
pub fn markdown(analysis: &Analysis, pictures: &[(String, String)]) -> String {
    let mut out = String::from("# Calibration stability\n");
    let findings = sections::findings(analysis);
    if !findings.is_empty() {
        out.push_str("\n## Findings\n\n");
    }
    for finding in findings {
        let _ = writeln!(out, "- {}", escaped(&finding.text));
    }
    let tables = side_by_side(analysis, None);
    out.push_str("\n## Groups side by side\n");
    for table in tables {
        let _ = write!(out, "\n{}", table.markdown());
    }
    out.push_str("\n## Every camera\n");
    for population in &analysis.populations {
        let title = escaped(&sections::population_title(population));
        let _ =
            write!(out, "\n### {title}\n\n{}", sections::population_table(population).markdown());
        if let Some(spread) = &population.spread {
            let words = escaped(&spread_words(spread));
            let _ = write!(out, "\n{}\n{words}.\n", spread_table(spread).markdown());
        }
        if let Some(words) = overlap_words(population) {
            let _ = write!(out, "\n{}.\n", escaped(&words));
        }
        if let Some(parts) = parts_table(population) {
            let _ = write!(out, "\n{}", parts.markdown());
        }
    }
    if !pictures.is_empty() {
        out.push_str("\n## Plots\n");
    }
    for (path, text) in pictures {
        let _ = write!(out, "\n![{}]({path})\n", escaped(text));
    }
    let _ = write!(out, "\nMade by calibstab {}.\n", analysis.provenance.calibstab_version);
    out
}
