//! The tables of a report, the same for every form it takes.

use std::collections::BTreeMap;

use super::number::{self, Places};
use super::table::{Cell, Span, Table, Tone};
use crate::stability::{
    Analysis, Finding, FindingId, Parameter, ParameterClass, Population, Sample, SampleState,
};

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
    let mut groups: Vec<&str> = analysis.populations.iter().map(|one| one.group.as_str()).collect();
    groups.sort_by(|a, b| natord::compare(a, b));
    groups.dedup();
    let mut tables = Vec::new();
    let mut rest = groups.as_slice();
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

/// What a row of the side-by-side table is about. Focal lengths and principal points mean the same in every model, and share
/// a row; distortion does not, and has a row for each model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct RowKey<'a> {
    camera: &'a str,
    size: [u64; 2],
    parameter: &'a str,
    model: Option<&'a str>,
}

fn side_by_side_table(analysis: &Analysis, groups: &[&str]) -> Table {
    let mut header = ["camera", "model", "parameter"].map(str::to_owned).to_vec();
    let text_columns = header.len();
    let mut above = vec![Span { columns: text_columns, title: String::new() }];
    for group in groups {
        header.extend(["mean", "std", "std %"].map(str::to_owned));
        above.push(Span { columns: 3, title: (*group).to_owned() });
    }
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut row_of: BTreeMap<RowKey, usize> = BTreeMap::new();
    for population in &analysis.populations {
        let Some(group) = groups.iter().position(|group| *group == population.group) else {
            continue;
        };
        let cells = text_columns + 3 * group..text_columns + 3 * group + 3;
        let Population { camera, model, width, height, .. } = population;
        for parameter in population.parameters.iter().filter(|parameter| !is_held(parameter)) {
            let is_of_model =
                !matches!(parameter.class, ParameterClass::Focal | ParameterClass::PrincipalPoint);
            let mut key = RowKey {
                camera,
                size: [*width, *height],
                parameter: &parameter.name,
                model: is_of_model.then_some(model),
            };
            // A group may have a camera under two models: separate rows, never one over the other.
            if row_of.get(&key).is_some_and(|&row| !rows[row][cells.start].text.is_empty()) {
                key.model = Some(model);
            }
            let row = *row_of.entry(key).or_insert_with(|| {
                let mut row: Vec<Cell> =
                    [camera, model, &parameter.name].map(|text| text.as_str().into()).into();
                row.resize(header.len(), Cell::default());
                rows.push(row);
                rows.len() - 1
            });
            if rows[row][1].text != *model {
                rows[row][1] = "several".into();
            }
            // Its mean, std and std %: the third to fifth of a parameter's row.
            rows[row][cells.clone()].clone_from_slice(&parameter_row(parameter)[2..5]);
        }
    }
    Table { text_columns, above, header, rows }
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

#[cfg(test)]
mod tests {
    use super::super::plot::test_data::{analysis, estimated, held, parameter, population};
    use super::*;

    fn opencv(group: &str, model: &str, fx: f64) -> Population {
        let parameters = vec![
            parameter("fx", &estimated(&[fx, fx + 1.0, fx + 2.0])),
            parameter("cx", &held(320.0, 3)),
            parameter("k1", &estimated(&[-0.1, -0.11, -0.12])),
        ];
        population(group, "camera 1", model, parameters)
    }

    fn rows(table: &Table) -> Vec<String> {
        let text = |row: &Vec<Cell>| row.iter().map(|cell| cell.text.clone()).collect::<Vec<_>>();
        table.rows.iter().map(|row| text(row).join("|")).collect()
    }

    #[test]
    fn focal_lengths_of_two_models_share_a_row_and_distortions_do_not() {
        let analysis = analysis(vec![opencv("a", "OPENCV", 500.0), opencv("b", "RADTAN", 600.0)]);
        let tables = side_by_side(&analysis, None);
        let want = [
            "camera 1|several|fx|501.0|1.0|0.20 %|601.0|1.0|0.17 %",
            "camera 1|OPENCV|k1|-0.110|0.010|9.1 %|||",
            "camera 1|RADTAN|k1||||-0.110|0.010|9.1 %",
        ];
        assert_eq!(tables.iter().flat_map(rows).collect::<Vec<_>>(), want);
    }

    #[test]
    fn two_models_in_one_group_never_overwrite_each_other() {
        let analysis = analysis(vec![opencv("a", "OPENCV", 500.0), opencv("a", "RADTAN", 600.0)]);
        let found: Vec<String> = side_by_side(&analysis, None).iter().flat_map(rows).collect();
        assert_eq!(found.len(), 4);
        assert!(found.contains(&"camera 1|OPENCV|fx|501.0|1.0|0.20 %".to_owned()), "{found:?}");
        assert!(found.contains(&"camera 1|RADTAN|fx|601.0|1.0|0.17 %".to_owned()), "{found:?}");
    }

    #[test]
    fn a_narrow_terminal_gets_several_tables_with_every_group() {
        let groups = ["a", "b", "c", "d"];
        let analysis =
            analysis(groups.iter().map(|group| opencv(group, "OPENCV", 500.0)).collect());
        let tables = side_by_side(&analysis, Some(80));
        assert!(tables.len() > 1 && tables.iter().all(|table| table.width() <= 80));
        let titles: Vec<&str> = tables
            .iter()
            .flat_map(|table| &table.above[1..])
            .map(|span| span.title.as_str())
            .collect();
        assert_eq!(titles, groups);
    }

    #[test]
    fn equal_findings_of_several_groups_are_said_once() {
        let mut analysis = analysis(vec![]);
        let finding = |group: &str| Finding {
            id: FindingId::FewRuns,
            group: Some(group.to_owned()),
            camera: None,
            runs: vec![],
            text: "few".to_owned(),
        };
        analysis.findings = vec![finding("a"), finding("b")];
        let said: Vec<String> = findings(&analysis).into_iter().map(|cell| cell.text).collect();
        assert_eq!(said, ["a, b: few"]);
    }
}
