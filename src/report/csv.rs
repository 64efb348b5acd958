//! The analysis as tidy CSV: one observation a row.

use csv::Writer;
use serde::Serialize;

use super::refinement::failures;
use super::sections::outliers;
use crate::stability::{
    Analysis, FindingId, Parameter, ParameterClass, Population, RunRecord, SampleState, Stopped,
};

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
    source: Source,
}

/// Whose values a row is about.
#[derive(Serialize, Clone, Copy, Default)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Source {
    /// As COLMAP left them.
    #[default]
    Colmap,
    /// As our own adjustment made them.
    Refined,
}

#[derive(Serialize)]
struct SampleRow<'a> {
    run: &'a str,
    camera_id: Option<u32>,
    state: SampleState,
    value: Option<f64>,
    predicted_std: Option<f64>,
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
    predicted_std: Option<f64>,
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

/// How a run was refined; empty where it was not.
#[derive(Serialize, Default)]
struct AdjustmentRow {
    is_refined: bool,
    stopped: Option<Stopped>,
    iterations: Option<usize>,
    initial_cost: Option<f64>,
    cost: Option<f64>,
    sigma_px: Option<f64>,
    adjusted_observations: Option<usize>,
    unprojectable: Option<usize>,
    of_lone_points: Option<usize>,
    failure: String,
}

/// Every run, one a row; a run that could not be read has a path and no more.
pub fn runs_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    let read = analysis.runs.iter().map(|run| {
        let flags: Vec<&str> = run.flags.iter().map(|flag| flag.name()).collect();
        let row = RunRow {
            group: Some(&run.group),
            run: Some(&run.run),
            path: run.files.first().map_or("", |file| &file.path),
            image_count: run.image_count,
            point_count: run.point_count,
            observation_count: run.observation_count,
            is_used: run.is_used,
            duplicate_of: run.duplicate_of.as_deref(),
            flags: flags.join(";"),
        };
        (row, adjustment_row(run))
    });
    let skipped = analysis.skipped.iter().map(|skipped| {
        let flags = FindingId::SkippedRun.name().to_owned();
        (RunRow { path: &skipped.path, flags, ..RunRow::default() }, AdjustmentRow::default())
    });
    table(read.chain(skipped))
}

fn adjustment_row(run: &RunRecord) -> AdjustmentRow {
    let adjustment = run.refinement.as_ref().and_then(|refinement| refinement.adjustment.as_ref());
    AdjustmentRow {
        is_refined: run.refinement.as_ref().is_some_and(|one| one.failure.is_none()),
        stopped: adjustment.map(|one| one.stopped),
        iterations: adjustment.map(|one| one.iterations),
        initial_cost: adjustment.map(|one| one.initial_cost),
        cost: adjustment.map(|one| one.cost),
        sigma_px: adjustment.and_then(|one| one.sigma_px),
        adjusted_observations: adjustment.map(|one| one.observations),
        unprojectable: adjustment.map(|one| one.unprojectable),
        of_lone_points: adjustment.map(|one| one.of_lone_points),
        failure: failures(run),
    }
}

/// Every sample, one a row; where runs were refined, also as COLMAP left it.
pub fn samples_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(parameters(analysis).flat_map(|(subject, parameter)| {
        parameter.samples.iter().map(move |sample| {
            let row = SampleRow {
                run: &sample.run,
                camera_id: sample.camera_id,
                state: sample.state,
                value: sample.value,
                predicted_std: sample.predicted_std,
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

impl Source {
    /// Of what a population says first.
    pub(super) fn of(population: &Population) -> Self {
        if population.as_left.is_some() { Self::Refined } else { Self::Colmap }
    }
}

impl<'a> Subject<'a> {
    pub(super) fn of(population: &'a Population) -> Self {
        let Population { group, camera, model, width, height, .. } = population;
        Self { group, camera, model, width: *width, height: *height }
    }
}

/// Every parameter of every population, then the same as COLMAP left it.
fn parameters(
    analysis: &Analysis,
) -> impl Iterator<Item = ((Subject<'_>, ParameterName<'_>), &Parameter)> {
    analysis.populations.iter().flat_map(|population| {
        let own = population.parameters.iter().map(|one| (Source::of(population), one));
        let left = population.as_left.iter().flat_map(|left| &left.parameters);
        own.chain(left.map(|one| (Source::Colmap, one))).map(|(source, parameter)| {
            let name = ParameterName { parameter: &parameter.name, class: parameter.class, source };
            ((Subject::of(population), name), parameter)
        })
    })
}

fn statistics_row(parameter: &Parameter) -> StatisticsRow {
    let predicted_std = parameter.predicted_std;
    let Some(statistics) = &parameter.statistics else {
        return StatisticsRow { predicted_std, ..StatisticsRow::default() };
    };
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
        predicted_std,
        outliers: outliers(parameter).join(";"),
    }
}
