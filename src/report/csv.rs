//! The analysis as tidy CSV: one observation a row.

use csv::Writer;
use serde::Serialize;

use super::sections::outliers;
use crate::stability::{Analysis, FindingId, Parameter, ParameterClass, Population, SampleState};

/// The columns that say which camera of which group a row is about.
#[derive(Clone, Copy, Serialize)]
pub(super) struct Subject<'a> {
    group: &'a str,
    camera: &'a str,
    model: &'a str,
    width: u64,
    height: u64,
}

/// The columns that say which of its parameters.
#[derive(Clone, Copy, Serialize)]
struct ParameterName<'a> {
    parameter: &'a str,
    class: ParameterClass,
}

#[derive(Serialize)]
struct SampleRow<'a> {
    run: &'a str,
    camera_id: Option<u32>,
    state: SampleState,
    value: Option<f64>,
    is_outlier: bool,
}

#[derive(Serialize, Default)]
struct StatisticsRow {
    n: usize,
    mean: Option<f64>,
    std: Option<f64>,
    std_px: Option<f64>,
    relative_std: Option<f64>,
    std_low_95: Option<f64>,
    std_high_95: Option<f64>,
    min: Option<f64>,
    q1: Option<f64>,
    median: Option<f64>,
    q3: Option<f64>,
    max: Option<f64>,
    mad_std: Option<f64>,
    whisker_low: Option<f64>,
    whisker_high: Option<f64>,
    outliers: String,
}

#[derive(Serialize, Default)]
struct RunRow<'a> {
    group: Option<&'a str>,
    run: Option<&'a str>,
    path: &'a str,
    image_count: Option<usize>,
    point_count: Option<usize>,
    observation_count: Option<usize>,
    is_used: bool,
    duplicate_of: Option<&'a str>,
    flags: String,
}

/// Every run, one a row; a run that could not be read has a path and no more.
pub fn runs_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    let read = analysis.runs.iter().map(|run| {
        let flags: Vec<&str> = run.flags.iter().map(|flag| flag.name()).collect();
        RunRow {
            group: Some(&run.group),
            run: Some(&run.run),
            path: run.files.first().map_or("", |file| &file.path),
            image_count: run.image_count,
            point_count: run.point_count,
            observation_count: run.observation_count,
            is_used: run.is_used,
            duplicate_of: run.duplicate_of.as_deref(),
            flags: flags.join(";"),
        }
    });
    let skipped = analysis.skipped.iter().map(|skipped| RunRow {
        path: &skipped.path,
        flags: FindingId::SkippedRun.name().to_owned(),
        ..RunRow::default()
    });
    table(read.chain(skipped))
}

/// Every sample, one a row.
pub fn samples_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(parameters(analysis).flat_map(|(subject, parameter)| {
        parameter.samples.iter().map(move |sample| {
            let row = SampleRow {
                run: &sample.run,
                camera_id: sample.camera_id,
                state: sample.state,
                value: sample.value,
                is_outlier: sample.is_outlier,
            };
            (subject, row)
        })
    }))
}

/// Every parameter of every camera and group, one a row; no statistics where there is no estimate to have them.
pub fn statistics_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(parameters(analysis).map(|(subject, parameter)| (subject, statistics_row(parameter))))
}

/// Rows under the names of their fields.
pub(super) fn table(rows: impl Iterator<Item = impl Serialize>) -> csv::Result<Vec<u8>> {
    let mut writer = Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

impl<'a> Subject<'a> {
    pub(super) fn of(population: &'a Population) -> Self {
        let Population { group, camera, model, width, height, .. } = population;
        Self { group, camera, model, width: *width, height: *height }
    }
}

fn parameters(
    analysis: &Analysis,
) -> impl Iterator<Item = ((Subject<'_>, ParameterName<'_>), &Parameter)> {
    analysis.populations.iter().flat_map(|population| {
        population.parameters.iter().map(|parameter| {
            let name = ParameterName { parameter: &parameter.name, class: parameter.class };
            ((Subject::of(population), name), parameter)
        })
    })
}

fn statistics_row(parameter: &Parameter) -> StatisticsRow {
    let Some(statistics) = &parameter.statistics else { return StatisticsRow::default() };
    StatisticsRow {
        n: statistics.n,
        mean: Some(statistics.mean),
        std: Some(statistics.std),
        std_px: statistics.std_px,
        relative_std: statistics.relative_std,
        std_low_95: Some(statistics.std_interval_95[0]),
        std_high_95: Some(statistics.std_interval_95[1]),
        min: Some(statistics.min),
        q1: Some(statistics.q1),
        median: Some(statistics.median),
        q3: Some(statistics.q3),
        max: Some(statistics.max),
        mad_std: Some(statistics.mad_std),
        whisker_low: Some(statistics.whiskers[0]),
        whisker_high: Some(statistics.whiskers[1]),
        outliers: outliers(parameter).join(";"),
    }
}
