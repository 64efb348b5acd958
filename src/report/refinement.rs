//! What is shown of refinement: what COLMAP left, what the adjustments say of their parameters, how each run went.

use super::number;
use super::table::{Cell, Table};
use crate::stability::{
    Adjustment, Analysis, Correlations, LeftSpread, Population, RunRecord, Stopped,
};

/// Correlations of at least this size are named in a sentence.
const STRONG: f64 = 0.9;

/// The spread as COLMAP left the runs; nothing where nothing was refined.
pub(super) fn left_words(population: &Population) -> Option<String> {
    let left = population.as_left.as_ref()?;
    let Some(spread) = &left.spread else {
        let reason = left.without_spread.as_ref()?;
        return Some(format!("As COLMAP left them, the runs have no spread: {reason}"));
    };
    let LeftSpread { n, cell_share, raw_rms_px, rotated_rms_px, moved_rms_px, .. } = *spread;
    let moved = moved_rms_px
        .map_or(String::new(), |px| format!(", turned and moved {} px", number::computed(px)));
    let [raw, rotated] = [raw_rms_px, rotated_rms_px].map(number::computed);
    Some(format!(
        "As COLMAP left the runs, their spread is {raw} px, turned {rotated} px{moved} ({n} runs over {:.0} % of the image)",
        100.0 * cell_share
    ))
}

/// The strongest correlations by the adjustments; nothing where none is strong.
pub(super) fn correlation_words(population: &Population) -> Option<String> {
    /// More are in the report.
    const NAMED: usize = 4;
    let Correlations { parameters, matrix } = population.predicted_correlations.as_ref()?;
    let pairs = (0..parameters.len()).flat_map(|row| (0..row).map(move |column| (column, row)));
    let mut strong: Vec<(&str, &str, f64)> = pairs
        .filter_map(|(a, b)| Some((parameters[a].as_str(), parameters[b].as_str(), matrix[b][a]?)))
        .filter(|(_, _, both)| both.abs() >= STRONG)
        .collect();
    strong.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
    let more = strong.len().saturating_sub(NAMED);
    strong.truncate(NAMED);
    let mut told: Vec<String> =
        strong.iter().map(|(a, b, both)| format!("{a} with {b} {}", correlation(*both))).collect();
    if more > 0 {
        told.push(format!("and {more} more"));
    }
    (!told.is_empty()).then(|| format!("Correlated by the adjustments: {}", told.join(", ")))
}

/// Correlations by the adjustments, and in brackets those seen across the runs.
pub(super) fn correlation_table(population: &Population) -> Option<Table> {
    let Correlations { parameters, matrix } = population.predicted_correlations.as_ref()?;
    let Correlations { parameters: seen, matrix: across } = &population.correlations;
    let observed = |a: &String, b: &String| {
        let place = |name| seen.iter().position(|other| other == name);
        across[place(a)?][place(b)?]
    };
    let row = |(index, name): (usize, &String)| {
        let mut row = vec![Cell::from(name.as_str())];
        for (other, predicted) in parameters.iter().zip(&matrix[index]).take(index) {
            let mut text = predicted.map_or(String::new(), correlation);
            if let Some(observed) = observed(name, other) {
                text.push_str(&format!(" ({})", correlation(observed)));
            }
            row.push(text.into());
        }
        row.resize(parameters.len(), Cell::default());
        row
    };
    let rows: Vec<Vec<Cell>> = parameters.iter().enumerate().skip(1).map(row).collect();
    let mut header = vec!["correlation".to_owned()];
    header.extend(parameters.iter().take(parameters.len() - 1).cloned());
    (!rows.is_empty()).then_some(Table { text_columns: 1, above: vec![], header, rows })
}

fn correlation(value: f64) -> String {
    // A plain 1.00 would hide how near to one it is.
    let decimals = if value.abs() > 0.995 { 4 } else { 2 };
    format!("{value:+.decimals$}")
}

/// How each run was refined, one a row; none where none was.
pub(super) fn adjustments_table(analysis: &Analysis) -> Option<Table> {
    let header = [
        "group",
        "run",
        "ended",
        "steps",
        "cost",
        "fell by",
        "sigma px",
        "images",
        "points",
        "observations",
        "left out",
        "failed",
    ];
    let row = |run: &RunRecord| {
        let refinement = run.refinement.as_ref()?;
        let mut row: Vec<Cell> = [&run.group, &run.run].map(|text| text.as_str().into()).into();
        match &refinement.adjustment {
            Some(adjustment) => row.extend(adjustment_cells(adjustment)),
            None => row.resize(header.len() - 1, Cell::default()),
        }
        row.push(Cell::loud(failures(run)));
        Some(row)
    };
    let rows: Vec<Vec<Cell>> = analysis.runs.iter().filter_map(row).collect();
    let table =
        Table { text_columns: 3, above: vec![], header: header.map(str::to_owned).to_vec(), rows };
    (!table.rows.is_empty()).then(|| table.without_empty_columns())
}

fn adjustment_cells(adjustment: &Adjustment) -> [Cell; 9] {
    let left_out = adjustment.unprojectable + adjustment.of_lone_points;
    [
        stopped(adjustment.stopped).into(),
        adjustment.iterations.to_string().into(),
        number::computed(adjustment.cost).into(),
        number::std(adjustment.initial_cost - adjustment.cost).into(),
        adjustment.sigma_px.map_or(String::new(), |sigma| format!("{sigma:.4}")).into(),
        adjustment.images.to_string().into(),
        adjustment.points.to_string().into(),
        adjustment.observations.to_string().into(),
        if left_out > 0 { left_out.to_string().into() } else { Cell::default() },
    ]
}

fn stopped(stopped: Stopped) -> &'static str {
    match stopped {
        Stopped::Converged => "converged",
        Stopped::Rounding => "converged to rounding",
        Stopped::IterationLimit => "at the limit of steps",
        Stopped::Stuck => "stuck",
    }
}

/// Why the run or some of its cameras are no samples.
pub(super) fn failures(run: &RunRecord) -> String {
    let Some(refinement) = &run.refinement else { return String::new() };
    if let Some(why) = &refinement.failure {
        return why.clone();
    }
    let cameras = refinement.adjustment.iter().flat_map(|adjustment| &adjustment.cameras);
    let failed = cameras.filter_map(|camera| {
        let why = camera.failure.as_ref()?;
        Some(format!("camera {}: {why}", camera.camera_id))
    });
    failed.collect::<Vec<_>>().join("; ")
}
