//! What the adjustments predict of every camera, as CSV.

use serde::Serialize;

use super::csv::{Subject, table};
use crate::stability::{Analysis, Prediction, Ratio};

#[derive(Serialize)]
struct Row {
    n: usize,
    predicted_rms_px: f64,
    observed_ratio: Option<f64>,
    independent_ratio: Option<f64>,
    degrees: Option<usize>,
    statistic: Option<f64>,
    p: Option<f64>,
    birge: Option<f64>,
    independent_statistic: Option<f64>,
    independent_p: Option<f64>,
    independent_birge: Option<f64>,
}

/// The predicted spread of every camera of every group and whether its runs differ by more, one camera a row.
pub fn prediction_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(analysis.populations.iter().filter_map(|population| {
        Some((Subject::of(population), row(population.prediction.as_ref()?)?))
    }))
}

fn row(prediction: &Prediction) -> Option<Row> {
    let spread = prediction.spread.as_ref()?;
    let consistency = prediction.consistency.as_ref();
    let found = consistency.map(|consistency| consistency.found);
    let independent = consistency.and_then(|consistency| consistency.independent);
    let parts = |ratio: Option<Ratio>| {
        (ratio.map(|r| r.statistic), ratio.map(|r| r.p), ratio.map(|r| r.birge))
    };
    let (statistic, p, birge) = parts(found);
    let (independent_statistic, independent_p, independent_birge) = parts(independent);
    Some(Row {
        n: spread.n,
        predicted_rms_px: spread.rms_px,
        observed_ratio: spread.observed_ratio,
        independent_ratio: spread.independent_ratio,
        degrees: consistency.map(|consistency| consistency.degrees),
        statistic,
        p,
        birge,
        independent_statistic,
        independent_p,
        independent_birge,
    })
}
