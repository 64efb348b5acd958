//! The analysis as Markdown: for a pull request, a wiki, a CI job's summary.

use std::fmt::Write;

use super::between;
use super::prediction::{birge_words, direction_words, predicted_words};
use super::refinement::{adjustments_table, correlation_table, left_words};
use super::residuals::residual_words;
use super::run_rows;
use super::sections;
use super::side_by_side::side_by_side;
use super::spread::{overlap_words, parts_table, spread_table, spread_words};
use super::table::escaped;
use super::verdict;
use crate::stability::Analysis;

/// The analysis as Markdown, with pictures (relative path, alternative text) at the end.
pub fn markdown(analysis: &Analysis, pictures: &[(String, String)]) -> String {
    let mut out = String::from("# Calibration stability\n");
    out.push_str(&verdict::markdown(analysis));
    let findings = sections::findings(analysis);
    if !findings.is_empty() {
        out.push_str("\n## Other findings\n\n");
    }
    for finding in findings {
        let _ = writeln!(out, "- {}", escaped(&finding.text));
    }
    let tables = side_by_side(analysis, None);
    out.push_str("\n## Groups side by side\n");
    for table in tables {
        let _ = write!(out, "\n{}", table.markdown());
    }
    between_groups(&mut out, analysis);
    run_rows(&mut out, analysis);
    out.push_str("\n## Every camera\n");
    for population in &analysis.populations {
        let title = escaped(&sections::population_title(population));
        let _ =
            write!(out, "\n### {title}\n\n{}", sections::population_table(population).markdown());
        if let Some(spread) = &population.spread {
            let words = escaped(&spread_words(spread));
            let _ = write!(out, "\n{}\n{words}.\n", spread_table(spread).markdown());
        }
        let more = [
            left_words,
            overlap_words,
            predicted_words,
            birge_words,
            direction_words,
            residual_words,
        ];
        for words in more.iter().filter_map(|words| words(population)) {
            let _ = write!(out, "\n{}.\n", escaped(&words));
        }
        if let Some(correlations) = correlation_table(population) {
            let _ = write!(
                out,
                "\nCorrelations by the adjustments, and across the runs in brackets:\n\n{}",
                correlations.markdown()
            );
        }
        if let Some(parts) = parts_table(population) {
            let _ = write!(out, "\n{}", parts.markdown());
        }
    }
    if let Some(adjustments) = adjustments_table(analysis) {
        let _ = write!(out, "\n## How the runs were refined\n\n{}", adjustments.markdown());
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

/// Who repeats better, and how much comes from the groups.
fn between_groups(out: &mut String, analysis: &Analysis) {
    if !analysis.comparisons.is_empty() {
        out.push_str("\n## Which group repeats better\n");
    }
    for comparison in &analysis.comparisons {
        let title = escaped(&between::comparison_title(comparison));
        let _ = write!(out, "\n### {title}\n\n{}\n", between::ranking_table(comparison).markdown());
        for sentence in between::sentences(comparison, usize::MAX) {
            let _ = writeln!(out, "- {}", escaped(&sentence));
        }
        if !comparison.spreads.is_empty() {
            let _ = write!(out, "\n{}", between::test_table(comparison).markdown());
        }
    }
    if !analysis.components.is_empty() {
        out.push_str("\n## Components of variance\n");
    }
    for components in &analysis.components {
        let title = escaped(&between::components_title(components));
        let table = between::components_table(components).markdown();
        let _ = write!(out, "\n### {title}\n\n{table}");
        if let Some(sentence) = between::components_sentence(components) {
            let _ = writeln!(out, "\n{}", escaped(&sentence));
        }
    }
}

/// The runs of each group, one a row.
fn run_rows(out: &mut String, analysis: &Analysis) {
    let groups = run_rows::run_rows(analysis);
    if !groups.is_empty() {
        out.push_str("\n## Every run\n");
    }
    for (group, tables) in groups {
        let _ = write!(out, "\n### {}\n", escaped(group));
        for table in tables {
            let _ = write!(out, "\n{}", table.markdown());
        }
    }
}
