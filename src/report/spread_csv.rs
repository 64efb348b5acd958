//! Spreads as tidy CSV.

use serde::Serialize;

use super::csv::{Source, Subject, table};
use crate::stability::spread::{Spread, SpreadMeasure};
use crate::stability::{Analysis, LeftSpread};

#[derive(Serialize, Default)]
struct SpreadRow<'a> {
    source: Source,
    alignment: &'a str,
    n: usize,
    region: String,
    cell_share: f64,
    rms_px: f64,
    p95_px: Option<f64>,
    max_px: Option<f64>,
    max_x: Option<f64>,
    max_y: Option<f64>,
    rms_deg: Option<f64>,
    p95_deg: Option<f64>,
    max_deg: Option<f64>,
    median_based_px: Option<f64>,
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

/// The spread of every camera of every group, one alignment a row; where runs were refined, also as COLMAP left them.
pub fn spread_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(analysis.populations.iter().flat_map(|population| {
        let own = population.spread.iter().flat_map(|spread| rows(Source::of(population), spread));
        let left = population.as_left.iter().flat_map(|left| &left.spread).flat_map(left_rows);
        let subject = Subject::of(population);
        own.chain(left).map(move |row| (subject, row)).collect::<Vec<_>>()
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

fn rows(source: Source, spread: &Spread) -> Vec<SpreadRow<'static>> {
    let moved = spread.moved.as_ref().map(|moved| ("moved", &moved.measure));
    let all = [("raw", &spread.raw), ("rotated", &spread.rotated)].into_iter().chain(moved);
    all.map(|(alignment, measure)| spread_row(source, alignment, spread, measure)).collect()
}

fn spread_row(
    source: Source,
    alignment: &'static str,
    spread: &Spread,
    measure: &SpreadMeasure,
) -> SpreadRow<'static> {
    SpreadRow {
        source,
        alignment,
        n: spread.n,
        region: spread.region.to_string(),
        cell_share: spread.cell_share,
        rms_px: measure.rms_px,
        p95_px: Some(measure.p95_px),
        max_px: Some(measure.max_px),
        max_x: Some(measure.max_at[0]),
        max_y: Some(measure.max_at[1]),
        rms_deg: Some(measure.rms_deg),
        p95_deg: Some(measure.p95_deg),
        max_deg: Some(measure.max_deg),
        median_based_px: Some(measure.median_based_px),
    }
}

/// What is known of the spread that COLMAP left, one alignment a row.
fn left_rows(left: &LeftSpread) -> Vec<SpreadRow<'static>> {
    let LeftSpread { n, region, cell_share, raw_rms_px, rotated_rms_px, moved_rms_px } = *left;
    let moved = moved_rms_px.map(|px| ("moved", px));
    let all = [("raw", raw_rms_px), ("rotated", rotated_rms_px)].into_iter().chain(moved);
    let row = |(alignment, rms_px)| SpreadRow {
        source: Source::Colmap,
        alignment,
        n,
        region: region.to_string(),
        cell_share,
        rms_px,
        ..SpreadRow::default()
    };
    all.map(row).collect()
}
