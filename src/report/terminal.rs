//! The analysis for a terminal: what one reads at a glance.

use std::fmt::Write;

use anstyle::Style;

use super::between;
use super::prediction::{birge_words, direction_words, predicted_words};
use super::refinement::{correlation_words, left_words};
use super::residuals::residual_words;
use super::sections;
use super::side_by_side::side_by_side;
use super::spread::{overlap_words, parts_table, spread_table, spread_words};
use super::verdict;
use crate::stability::Analysis;

/// The analysis as text with ANSI styles, its tables not wider than `width` characters where that can be.
pub fn terminal(analysis: &Analysis, width: Option<usize>) -> String {
    let mut out = String::new();
    let bold = Style::new().bold();
    let title = |out: &mut String, text: &str| {
        let _ = writeln!(out, "{bold}{text}{bold:#}");
    };
    out.push_str(&verdict::terminal(analysis));
    let (tables, left_out) = sections::population_tables(analysis, width);
    for (population, table) in analysis.populations.iter().zip(tables) {
        title(&mut out, &sections::population_title(population));
        out.push_str(&table.text());
        if let Some(spread) = &population.spread {
            let _ = write!(out, "\n{}", spread_table(spread).text());
            let _ = writeln!(out, "{}.", spread_words(spread));
        }
        let more = [
            left_words,
            correlation_words,
            overlap_words,
            predicted_words,
            birge_words,
            direction_words,
            residual_words,
        ];
        for words in more.iter().filter_map(|words| words(population)) {
            let _ = writeln!(out, "{words}.");
        }
        if let Some(parts) = parts_table(population) {
            let _ = write!(out, "\n{}", parts.text());
        }
        out.push('\n');
    }
    if !left_out.is_empty() {
        let faint = Style::new().dimmed();
        let columns = left_out.join(", ");
        let _ = writeln!(out, "{faint}A wider terminal or --out shows {columns} too.{faint:#}\n");
    }
    let groups = analysis.populations.chunk_by(|a, b| a.group == b.group).count();
    if groups > 1 {
        title(&mut out, "Groups side by side");
        for table in side_by_side(analysis, width) {
            out.push_str(&table.text());
            out.push('\n');
        }
    }
    between_groups(&mut out, analysis);
    for finding in sections::findings(analysis) {
        let style = finding.tone.style();
        let _ = writeln!(out, "{style}- {}{style:#}", finding.text);
    }
    out
}

/// Who repeats better, and how much comes from the groups.
fn between_groups(out: &mut String, analysis: &Analysis) {
    /// More sentences about one camera are not read in a terminal.
    const SENTENCES: usize = 6;
    let bold = Style::new().bold();
    for comparison in &analysis.comparisons {
        let title = between::comparison_title(comparison);
        let _ = writeln!(out, "{bold}{title}{bold:#}");
        out.push_str(&between::ranking_table(comparison).text());
        for sentence in between::sentences(comparison, SENTENCES) {
            let _ = writeln!(out, "  {sentence}");
        }
        out.push('\n');
    }
    for components in &analysis.components {
        let Some(sentence) = between::components_sentence(components) else { continue };
        let title = between::components_title(components);
        let _ = writeln!(out, "{bold}{title}{bold:#}\n  {sentence}\n");
    }
}
