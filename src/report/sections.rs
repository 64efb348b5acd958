//! The tables of a report, the same for every form it takes.

use std::collections::BTreeMap;

use super::number::{self, Places};
use super::table::{Cell, Span, Table, Tone};
use crate::stability::{Analysis, Finding, FindingId, Parameter, Population, Sample, SampleState};

/// What a population is, in one line.
pub(super) fn population_title(population: &Population) -> String {
    let Population { group, camera, model, width, height, .. } = population;
    format!("{group}: {camera}, {model} {width} x {height}")
}

/// A population's parameters, one a row.
pub(super) fn population_table(population: &Population) -> Table {
    let header = [
        "parameter",
        "n",
        "mean",
        "std",
        "std %",
        "95 % of std",
        "min",
        "q1",
        "median",
        "q3",
        "max",
        "MAD std",
        "outliers",
    ];
    let rows = population.parameters.iter().map(parameter_row).collect();
    let table =
        Table { text_columns: 1, above: vec![], header: header.map(str::to_owned).to_vec(), rows };
    table.without_empty_columns()
}

fn parameter_row(parameter: &Parameter) -> Vec<Cell> {
    let name = Cell::from(parameter.name.as_str());
    let Some(statistics) = &parameter.statistics else {
        let mut row =
            vec![name, Cell::default(), lone_value(parameter), Cell::faint(state(parameter))];
        row.resize(13, Cell::default());
        return row;
    };
    let places = Places::of_std(statistics.std, statistics.mean);
    let [low, high] = statistics.std_interval_95.map(number::std);
    let plain = |value: f64| Cell::from(places.write(value));
    vec![
        name,
        Cell::from(statistics.n.to_string()),
        plain(statistics.mean),
        Cell::from(number::std(statistics.std)),
        Cell::from(statistics.relative_std.map_or(String::new(), number::percent)),
        Cell::from(format!("{low} .. {high}")),
        plain(statistics.min),
        plain(statistics.q1),
        plain(statistics.median),
        plain(statistics.q3),
        plain(statistics.max),
        Cell::from(number::std(statistics.mad_std)),
        Cell::loud(few_of(outliers(parameter))),
    ]
}

/// The names of the samples beyond the whiskers.
pub(super) fn outliers(parameter: &Parameter) -> Vec<String> {
    let outliers = parameter.samples.iter().filter(|sample| sample.is_outlier);
    outliers.map(|sample| sample_name(parameter, sample)).collect()
}

/// A table's cell for many names: the first ones, and how many more there are.
fn few_of(mut names: Vec<String>) -> String {
    /// Of a thousand normal samples seven are outliers, too many for a cell.
    const SHOWN: usize = 4;
    let more = names.len().saturating_sub(SHOWN);
    if more > 0 {
        names.truncate(SHOWN);
        names.push(format!("+{more}"));
    }
    names.join(" ")
}

/// The run of a sample, and the camera too where a run has several samples.
fn sample_name(parameter: &Parameter, sample: &Sample) -> String {
    let of_run = parameter.samples.iter().filter(|other| other.run == sample.run).count();
    match sample.camera_id {
        Some(id) if of_run > 1 => format!("{}:{id}", sample.run),
        _ => sample.run.clone(),
    }
}

/// The value of a parameter without statistics, when all of its samples agree.
fn lone_value(parameter: &Parameter) -> Cell {
    let mut values = parameter.samples.iter().filter_map(|sample| sample.value);
    let Some(first) = values.next() else { return Cell::default() };
    let all_agree = values.all(|value| value.to_bits() == first.to_bits());
    Cell::faint(if all_agree { number::value(first) } else { "several".to_owned() })
}

/// Why a parameter has no statistics.
fn state(parameter: &Parameter) -> &'static str {
    let has = |state| parameter.samples.iter().any(|sample| sample.state == state);
    if has(SampleState::PresumedHeld) {
        "held"
    } else if has(SampleState::Unknown) {
        "one run"
    } else {
        "failed"
    }
}

/// The groups side by side, as in tables 4.1 to 4.3 of the thesis: per camera and parameter, each group's mean, standard
/// deviation, and standard deviation in percent. Split so that none is wider than `width`, if it can be.
pub(super) fn side_by_side(analysis: &Analysis, width: Option<usize>) -> Vec<Table> {
    let mut columns: Vec<Column> = Vec::new();
    for population in &analysis.populations {
        let column = Column { group: &population.group, model: &population.model };
        if !columns.contains(&column) {
            columns.push(column);
        }
    }
    columns.sort_by(|a, b| a.model.cmp(b.model).then(natord::compare(a.group, b.group)));
    let mut tables = Vec::new();
    let mut rest = columns.as_slice();
    while !rest.is_empty() {
        let fits = |count: &usize| {
            let table = side_by_side_table(analysis, &rest[..*count]);
            width.is_none_or(|width| table.width() <= width)
        };
        let count = (2..=rest.len()).take_while(fits).last().unwrap_or(1);
        tables.push(side_by_side_table(analysis, &rest[..count]));
        rest = &rest[count..];
    }
    tables
}

/// A column of the side-by-side table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Column<'a> {
    group: &'a str,
    model: &'a str,
}

fn side_by_side_table(analysis: &Analysis, columns: &[Column]) -> Table {
    let mut header = vec!["camera".to_owned(), "parameter".to_owned()];
    let mut above = vec![Span { columns: header.len(), lines: vec![] }];
    for Column { group, model } in columns {
        header.extend(["mean", "std", "std %"].map(str::to_owned));
        above.push(Span { columns: 3, lines: vec![(*group).to_owned(), (*model).to_owned()] });
    }
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut row_of: BTreeMap<(&str, u64, u64, &str), usize> = BTreeMap::new();
    for population in &analysis.populations {
        let here =
            |column: &Column| column.group == population.group && column.model == population.model;
        let Some(column) = columns.iter().position(here) else { continue };
        let (camera, width, height) =
            (population.camera.as_str(), population.width, population.height);
        for parameter in population.parameters.iter().filter(|parameter| !is_held(parameter)) {
            let row =
                *row_of.entry((camera, width, height, &parameter.name)).or_insert_with(|| {
                    let mut row = vec![camera.into(), parameter.name.as_str().into()];
                    row.resize(header.len(), Cell::default());
                    rows.push(row);
                    rows.len() - 1
                });
            let cells = parameter_row(parameter);
            // Its mean, std and std %: the third to fifth of a parameter's row.
            rows[row][2 + 3 * column..5 + 3 * column].clone_from_slice(&cells[2..5]);
        }
    }
    Table { text_columns: 2, above, header, rows }
}

/// Whether all that is known of the parameter was held: it says nothing about stability.
fn is_held(parameter: &Parameter) -> bool {
    parameter
        .samples
        .iter()
        .all(|s| matches!(s.state, SampleState::PresumedHeld | SampleState::Failed))
}

/// What must be said, most important first; equal sentences about several groups are said once.
pub(super) fn findings(analysis: &Analysis) -> Vec<Cell> {
    let mut said: Vec<(&Finding, Vec<&str>)> = Vec::new();
    for finding in &analysis.findings {
        let group = finding.group.as_deref();
        match said.iter_mut().find(|(one, _)| one.id == finding.id && one.text == finding.text) {
            Some((_, groups)) => groups.extend(group),
            None => said.push((finding, group.into_iter().collect())),
        }
    }
    let sentence = |(finding, groups): (&Finding, Vec<&str>)| {
        let place =
            if groups.is_empty() { String::new() } else { format!("{}: ", groups.join(", ")) };
        Cell { text: format!("{place}{}", finding.text), tone: tone(finding.id) }
    };
    said.into_iter().map(sentence).collect()
}

fn tone(id: FindingId) -> Tone {
    match id {
        FindingId::SkippedRun
        | FindingId::DuplicateRuns
        | FindingId::BogusCamera
        | FindingId::FewImages
        | FindingId::MissingCamera
        | FindingId::MixedStates => Tone::Loud,
        FindingId::UnusedCamera
        | FindingId::MixedCameras
        | FindingId::CameraMatch
        | FindingId::CameraPerImage
        | FindingId::FewRuns
        | FindingId::Reading => Tone::Plain,
    }
}
