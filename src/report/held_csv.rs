//! What freeing held parameters would do to every camera, as CSV.

use serde::Serialize;

use super::csv::{Subject, table};
use crate::stability::{Analysis, HeldClass, HeldTest};

#[derive(Serialize)]
struct Row<'a> {
    class: HeldClass,
    freed: String,
    in_model: &'a str,
    n: usize,
    p: f64,
    effect_px: Option<f64>,
    focal_change: Option<f64>,
}

/// The score test of each class of parameters that a camera's runs held, one a row.
pub fn held_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(analysis.populations.iter().flat_map(|population| {
        population.held.iter().map(|test| (Subject::of(population), row(test)))
    }))
}

fn row(test: &HeldTest) -> Row<'_> {
    Row {
        class: test.class,
        freed: test.freed.join(" "),
        in_model: &test.model,
        n: test.n,
        p: test.p,
        effect_px: test.effect_px,
        focal_change: test.focal_change,
    }
}
