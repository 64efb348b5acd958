//! Spreads as tidy CSV.

use serde::Serialize;

use super::csv::{Subject, table};
use crate::stability::Analysis;
use crate::stability::spread::{Spread, SpreadMeasure};

#[derive(Serialize)]
struct SpreadRow<'a> {
    alignment: &'a str,
    n: usize,
    region: String,
    cell_share: f64,
    rms_px: f64,
    p95_px: f64,
    max_px: f64,
    max_x: f64,
    max_y: f64,
    rms_deg: f64,
    p95_deg: f64,
    max_deg: f64,
    median_based_px: f64,
}

#[derive(Serialize)]
struct RunRow<'a> {
    run: &'a str,
    camera_id: u32,
    rms_px: f64,
    raw_rms_px: f64,
    max_px: f64,
    max_x: f64,
    max_y: f64,
    rotation_deg: f64,
}

/// The spread of every camera of every group, one alignment a row.
pub fn spread_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(spreads(analysis).flat_map(|(subject, spread)| {
        let moved = spread.moved.as_ref().map(|moved| ("moved", &moved.measure));
        let all = [("raw", &spread.raw), ("rotated", &spread.rotated)].into_iter().chain(moved);
        all.map(move |(alignment, measure)| (subject, spread_row(alignment, spread, measure)))
    }))
}

/// How far each calibration is off the consensus of its population, one a row.
pub fn run_deviations_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(spreads(analysis).flat_map(|(subject, spread)| {
        spread.runs.iter().map(move |run| {
            let row = RunRow {
                run: &run.run,
                camera_id: run.camera_id,
                rms_px: run.rms_px,
                raw_rms_px: run.raw_rms_px,
                max_px: run.max_px,
                max_x: run.max_at[0],
                max_y: run.max_at[1],
                rotation_deg: run.rotation_deg,
            };
            (subject, row)
        })
    }))
}

fn spreads(analysis: &Analysis) -> impl Iterator<Item = (Subject<'_>, &Spread)> {
    let populations = analysis.populations.iter();
    populations.filter_map(|one| Some((Subject::of(one), one.spread.as_ref()?)))
}

fn spread_row<'a>(alignment: &'a str, spread: &Spread, measure: &SpreadMeasure) -> SpreadRow<'a> {
    SpreadRow {
        alignment,
        n: spread.n,
        region: spread.region.to_string(),
        cell_share: spread.cell_share,
        rms_px: measure.rms_px,
        p95_px: measure.p95_px,
        max_px: measure.max_px,
        max_x: measure.max_at[0],
        max_y: measure.max_at[1],
        rms_deg: measure.rms_deg,
        p95_deg: measure.p95_deg,
        max_deg: measure.max_deg,
        median_based_px: measure.median_based_px,
    }
}
