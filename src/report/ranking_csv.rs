//! An experiment as tidy CSV: every cell, and every choice.

use csv::Writer;
use serde::Serialize;

use crate::selection::experiment::{Cell, ErrorParts, Selection};

#[derive(Serialize)]
struct CellRow<'a> {
    model: &'a str,
    heuristic: &'a str,
    size: usize,
    /// All cameras together, or one of several.
    camera_id: Option<u32>,
    n: usize,
    failures: usize,
    rms_px: Option<f64>,
    rms_low_95_px: Option<f64>,
    rms_high_95_px: Option<f64>,
    bias_px: Option<f64>,
    spread_px: Option<f64>,
    raw_rms_px: Option<f64>,
    raw_bias_px: Option<f64>,
    raw_spread_px: Option<f64>,
    bias_from_full_px: Option<f64>,
    held_out_px: Option<f64>,
    overlap: Option<f64>,
}

/// `cells.csv`: each heuristic at each size of each model; where there are several cameras, of each camera too.
pub fn cells_csv(selection: &Selection) -> csv::Result<Vec<u8>> {
    let mut writer = Writer::from_writer(Vec::new());
    for cell in &selection.cells {
        let whole = CellRow {
            model: &selection.models[cell.model].name,
            heuristic: &cell.heuristic,
            size: cell.size,
            camera_id: None,
            n: cell.n,
            failures: cell.failures,
            rms_low_95_px: cell.interval_95.map(|ends| ends[0]),
            rms_high_95_px: cell.interval_95.map(|ends| ends[1]),
            held_out_px: cell.held_out_px,
            overlap: cell.overlap,
            ..row(selection, cell, cell.error, cell.raw)
        };
        writer.serialize(whole)?;
        // A truth tells something of a lone camera too.
        let is_told = cell.cameras.len() > 1 || selection.options.truth.is_some();
        for camera in cell.cameras.iter().filter(|_| is_told) {
            let own = row(selection, cell, Some(camera.error), Some(camera.raw));
            let bias_from_full_px = camera.bias_from_full_px;
            writer.serialize(CellRow {
                camera_id: Some(camera.camera_id),
                bias_from_full_px,
                ..own
            })?;
        }
    }
    finished(writer)
}

fn row<'a>(
    selection: &'a Selection,
    cell: &'a Cell,
    error: Option<ErrorParts>,
    raw: Option<ErrorParts>,
) -> CellRow<'a> {
    CellRow {
        model: &selection.models[cell.model].name,
        heuristic: &cell.heuristic,
        size: cell.size,
        camera_id: None,
        n: cell.n,
        failures: cell.failures,
        rms_px: error.map(|it| it.rms_px),
        rms_low_95_px: None,
        rms_high_95_px: None,
        bias_px: error.map(|it| it.bias_px),
        spread_px: error.and_then(|it| it.spread_px),
        raw_rms_px: raw.map(|it| it.rms_px),
        raw_bias_px: raw.map(|it| it.bias_px),
        raw_spread_px: raw.and_then(|it| it.spread_px),
        bias_from_full_px: None,
        held_out_px: None,
        overlap: None,
    }
}

/// `choices.csv`: every parameter that every choice gave, and how far off all of it is.
pub fn choices_csv(selection: &Selection) -> csv::Result<Vec<u8>> {
    let mut writer = Writer::from_writer(Vec::new());
    writer.write_record([
        "model",
        "heuristic",
        "size",
        "repeat",
        "camera_id",
        "parameter",
        "value",
        "error_px",
        "raw_error_px",
        "held_out_px",
        "failure",
    ])?;
    for scored in &selection.samples {
        let sample = &scored.sample;
        let model = &selection.models[sample.draw.model];
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        let record = |camera: String, parameter: &str, value: String| {
            [
                model.name.clone(),
                sample.heuristic.clone(),
                sample.draw.size.to_string(),
                sample.draw.repeat.to_string(),
                camera,
                parameter.to_owned(),
                value,
                number(scored.error_px),
                number(scored.raw_error_px),
                number(sample.held_out_px),
                sample.failure.clone().unwrap_or_default(),
            ]
        };
        if sample.cameras.is_empty() {
            writer.write_record(record(String::new(), "", String::new()))?;
        }
        for camera in &sample.cameras {
            let known = model.cameras.iter().find(|it| it.camera_id == camera.camera_id);
            let names = known.map_or(&[][..], |known| &known.parameters);
            for (name, value) in names.iter().zip(&camera.params) {
                let id = camera.camera_id.to_string();
                writer.write_record(record(id, name, value.to_string()))?;
            }
        }
    }
    finished(writer)
}

fn finished(writer: Writer<Vec<u8>>) -> csv::Result<Vec<u8>> {
    writer.into_inner().map_err(|error| error.into_error().into())
}
