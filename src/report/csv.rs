//! The analysis as tidy CSV: one observation a row.

use csv::Writer;
use serde::Serialize;

use super::refinement::failures;
use super::sections::outliers;
use crate::stability::{
    Analysis, FindingId, Parameter, ParameterClass, Population, RunRecord, SampleState, Stopped,
};

/// The columns that say which parameter of which camera a row is about.
#[derive(Serialize)]
struct Subject<'a> {
    group: &'a str,
    camera: &'a str,
    model: &'a str,
    width: u64,
    height: u64,
    parameter: &'a str,
    class: ParameterClass,
    source: Source,
}

/// Whose values a row is about.
#[derive(Serialize, Clone, Copy)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Source {
    /// As COLMAP left them.
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

#[derive(Serialize)]
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
    let mut rows = Writer::from_writer(Vec::new());
    for run in &analysis.runs {
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
        rows.serialize((row, adjustment_row(run)))?;
    }
    for skipped in &analysis.skipped {
        let row = RunRow {
            group: None,
            run: None,
            path: &skipped.path,
            image_count: None,
            point_count: None,
            observation_count: None,
            is_used: false,
            duplicate_of: None,
            flags: FindingId::SkippedRun.name().to_owned(),
        };
        rows.serialize((row, AdjustmentRow::default()))?;
    }
    finished(rows)
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
    let mut rows = Writer::from_writer(Vec::new());
    for (subject, parameter) in subjects(analysis) {
        for sample in &parameter.samples {
            rows.serialize((
                &subject,
                SampleRow {
                    run: &sample.run,
                    camera_id: sample.camera_id,
                    state: sample.state,
                    value: sample.value,
                    predicted_std: sample.predicted_std,
                    is_outlier: sample.is_outlier,
                },
            ))?;
        }
    }
    finished(rows)
}

/// Every parameter of every camera and group, one a row; no statistics where there is no estimate to have them.
pub fn statistics_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    let mut rows = Writer::from_writer(Vec::new());
    for (subject, parameter) in subjects(analysis) {
        rows.serialize((&subject, statistics_row(parameter)))?;
    }
    finished(rows)
}

/// Every parameter of every population, then the same as COLMAP left it.
fn subjects(analysis: &Analysis) -> impl Iterator<Item = (Subject<'_>, &Parameter)> {
    analysis.populations.iter().flat_map(|population| {
        let source = if population.as_left.is_some() { Source::Refined } else { Source::Colmap };
        let own = population.parameters.iter().map(move |parameter| (source, parameter));
        let left = population.as_left.iter().flat_map(|left| &left.parameters);
        own.chain(left.map(|parameter| (Source::Colmap, parameter)))
            .map(|(source, parameter)| (subject(population, source, parameter), parameter))
    })
}

fn subject<'a>(
    population: &'a Population,
    source: Source,
    parameter: &'a Parameter,
) -> Subject<'a> {
    let Population { group, camera, model, width, height, .. } = population;
    let (width, height, class) = (*width, *height, parameter.class);
    Subject { group, camera, model, width, height, parameter: &parameter.name, class, source }
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

pub(super) fn finished(rows: Writer<Vec<u8>>) -> csv::Result<Vec<u8>> {
    rows.into_inner().map_err(|error| error.into_error().into())
}
