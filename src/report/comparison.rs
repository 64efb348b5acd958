//! A comparison of calibrations, for a terminal.

use std::fmt::Write;

use anstyle::Style;

use super::number;
use super::spread::{difference_cells, spread_table, spread_words};
use super::table::{Cell, Table};
use crate::stability::spread::{Difference, Spread};
use crate::stability::{ComparedCamera, Comparison};

/// The comparison as text with ANSI styles.
pub fn comparison_text(comparison: &Comparison) -> String {
    let mut out = String::new();
    for camera in &comparison.cameras {
        let bold = Style::new().bold();
        let _ = writeln!(out, "{bold}{}{bold:#}", title(camera));
        let reference = camera.to_reference.iter();
        let differences: Vec<&Difference> = camera
            .differences
            .iter()
            .chain(reference.flat_map(|found| found.runs.iter().chain(&found.mean)))
            .collect();
        if !differences.is_empty() {
            out.push_str(&difference_table(&differences).text());
            out.push('\n');
        }
        if let Some(spread) = &camera.spread {
            out.push_str(&spread_table(spread).text());
            let _ = writeln!(out, "{}.", spread_words(spread));
            if let Some(table) = distance_table(spread) {
                let _ = write!(out, "\nDistances in px, turned:\n{}", table.text());
            }
            out.push('\n');
        }
    }
    if let Some(by) = &comparison.matched_by {
        let _ = writeln!(out, "- cameras were matched by {by}");
    }
    for left_out in &comparison.left_out {
        let _ = writeln!(out, "- {left_out} has no partner and is left out");
    }
    out
}

/// What is compared.
fn title(camera: &ComparedCamera) -> String {
    /// More are counted, not named.
    const NAMED: usize = 6;
    let named = camera.calibrations.iter().take(NAMED);
    let mut names: Vec<String> = named.map(|(run, _, model)| format!("{run} ({model})")).collect();
    let more = camera.calibrations.len().saturating_sub(NAMED);
    if more > 0 {
        names.push(format!("{more} more"));
    }
    format!("{}, {} x {}: {}", camera.camera, camera.width, camera.height, names.join(", "))
}

fn difference_table(differences: &[&Difference]) -> Table {
    let header =
        ["from", "to", "alignment", "rms px", "95 % px", "max px", "at", "turn deg", "image"];
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for one in differences {
        let share = Cell::from(format!("{:.0} %", 100.0 * one.cell_share));
        for (name, measure) in [("as they are", &one.raw), ("turned", &one.rotated)] {
            let mut row: Vec<Cell> = [&one.from, &one.to].map(|text| text.as_str().into()).into();
            row.push(name.into());
            row.extend(difference_cells(measure));
            let is_turned = name == "turned";
            let angle = is_turned.then(|| number::computed(one.rotation_angle_deg));
            row.push(Cell::from(angle.unwrap_or_default()));
            row.push(share.clone());
            rows.push(row);
        }
    }
    Table { text_columns: 3, above: vec![], header: header.map(str::to_owned).to_vec(), rows }
}

/// Between any two, where that is more than one number and still fits a terminal.
fn distance_table(spread: &Spread) -> Option<Table> {
    const MOST: usize = 12;
    let distances = spread.distances_px.as_ref().filter(|d| (3..=MOST).contains(&d.len()))?;
    let names: Vec<String> = spread.runs.iter().map(|run| run.run.clone()).collect();
    let rows = names.iter().zip(distances).enumerate().map(|(index, (name, distances))| {
        let mut row = vec![Cell::from(name.as_str())];
        row.extend(distances.iter().enumerate().map(|(other, px)| {
            Cell::from(if other == index { String::new() } else { number::computed(*px) })
        }));
        row
    });
    let rows = rows.collect();
    let header = std::iter::once(String::new()).chain(names.iter().cloned()).collect();
    Some(Table { text_columns: 1, above: vec![], header, rows })
}
