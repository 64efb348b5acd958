//! The analysis for a terminal: what one reads at a glance.

use std::fmt::Write;

use anstyle::Style;

use super::sections;
use crate::stability::Analysis;

/// The analysis as text with ANSI styles, its tables not wider than `width` characters where that can be.
pub fn terminal(analysis: &Analysis, width: Option<usize>) -> String {
    let mut out = String::new();
    let bold = Style::new().bold();
    let title = |out: &mut String, text: &str| {
        let _ = writeln!(out, "{bold}{text}{bold:#}");
    };
    for population in &analysis.populations {
        title(&mut out, &sections::population_title(population));
        out.push_str(&sections::population_table(population).text());
        out.push('\n');
    }
    let groups = analysis.populations.chunk_by(|a, b| a.group == b.group).count();
    if groups > 1 {
        title(&mut out, "Groups side by side");
        for table in sections::side_by_side(analysis, width) {
            out.push_str(&table.text());
            out.push('\n');
        }
    }
    for finding in sections::findings(analysis) {
        let style = finding.tone.style();
        let _ = writeln!(out, "{style}- {}{style:#}", finding.text);
    }
    out
}
