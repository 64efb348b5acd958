//! What the adjustments left of the observations, in a sentence and as CSV.

use serde::Serialize;

use super::csv::{Subject, table};
use super::number;
use crate::stability::{Analysis, CellMean, Mean, Population, ResidualMap, RingMean, p_in_words};

/// The residuals of a camera, in one sentence.
pub(super) fn residual_words(population: &Population) -> Option<String> {
    let found = population.residuals.as_ref()?;
    let [effect, sigma] = [found.effect_px, found.sigma_px].map(number::std);
    let ResidualMap { columns, rows, .. } = found.map;
    let p = p_in_words(found.p);
    let mut words = format!(
        "Residuals: sigma {sigma} px, in it a pattern of {effect} px RMS over {columns} x {rows} cells and rings ({p})"
    );
    if let Some(tails) = &found.tails {
        words.push_str(&format!(
            "; by the median point sigma is {} px, and {:.1} % of the points lie beyond what 0.1 % would",
            number::std(tails.robust_sigma_px),
            100.0 * tails.beyond_share
        ));
    }
    Some(words)
}

#[derive(Serialize)]
#[serde(rename_all = "kebab-case")]
enum Over {
    Cell,
    Ring,
}

#[derive(Serialize)]
struct Row {
    over: Over,
    x: Option<f64>,
    y: Option<f64>,
    radius_px: Option<f64>,
    observations: usize,
    dx_px: Option<f64>,
    dy_px: Option<f64>,
    dx_std_error_px: Option<f64>,
    dy_std_error_px: Option<f64>,
    outward_px: Option<f64>,
    tangential_px: Option<f64>,
    outward_std_error_px: Option<f64>,
    tangential_std_error_px: Option<f64>,
    p: f64,
}

/// The mean residuals of every camera of every group, one cell or ring a row.
pub fn residuals_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(analysis.populations.iter().flat_map(|population| {
        let map = population.residuals.iter().map(|residuals| &residuals.map);
        let rows =
            map.flat_map(|map| map.cells.iter().map(of_cell).chain(map.rings.iter().map(of_ring)));
        rows.map(|row| (Subject::of(population), row))
    }))
}

fn of_cell(CellMean { middle: [x, y], mean, .. }: &CellMean) -> Row {
    let Mean { px: [dx, dy], std_error_px: [dx_error, dy_error], .. } = *mean;
    Row {
        x: Some(*x),
        y: Some(*y),
        dx_px: Some(dx),
        dy_px: Some(dy),
        dx_std_error_px: Some(dx_error),
        dy_std_error_px: Some(dy_error),
        ..row(Over::Cell, mean)
    }
}

fn of_ring(RingMean { radius_px, mean }: &RingMean) -> Row {
    let Mean { px: [outward, along], std_error_px: [outward_error, along_error], .. } = *mean;
    Row {
        radius_px: Some(*radius_px),
        outward_px: Some(outward),
        tangential_px: Some(along),
        outward_std_error_px: Some(outward_error),
        tangential_std_error_px: Some(along_error),
        ..row(Over::Ring, mean)
    }
}

fn row(over: Over, mean: &Mean) -> Row {
    Row {
        over,
        x: None,
        y: None,
        radius_px: None,
        observations: mean.count,
        dx_px: None,
        dy_px: None,
        dx_std_error_px: None,
        dy_std_error_px: None,
        outward_px: None,
        tangential_px: None,
        outward_std_error_px: None,
        tangential_std_error_px: None,
        p: mean.p,
    }
}
