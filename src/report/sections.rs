//! The tables of a report, the same for every form it takes.

use super::number::{self, Places};
use super::table::{Cell, Table, Tone};
use super::verdict::is_reason;
use crate::stability::{Analysis, Finding, FindingId, Parameter, Population, Sample, SampleState};

/// What a population is, in one line.
pub(super) fn population_title(population: &Population) -> String {
    let Population { group, camera, model, width, height, .. } = population;
    let refined = if population.as_left.is_some() { ", refined" } else { "" };
    format!("{group}: {camera}, {model} {width} x {height}{refined}")
}

/// The columns of a population's table.
const POPULATION_COLUMNS: [&str; 17] = [
    "parameter",
    "n",
    "mean",
    "std",
    "std px",
    "std %",
    "95 % of std",
    "std by BA",
    "COLMAP's mean",
    "COLMAP's std",
    "min",
    "q1",
    "median",
    "q3",
    "max",
    "MAD std",
    "outliers",
];

/// What a table that is too wide is read without, first to last; no std without its interval and its n.
const DISPENSABLE: [&[&str]; 5] =
    [&["q1", "q3"], &["MAD std"], &["min", "max"], &["median"], &["COLMAP's mean"]];

/// A population's parameters, one a row.
pub(super) fn population_table(population: &Population) -> Table {
    let left = |index: usize| population.as_left.as_ref().map(|left| &left.parameters[index]);
    let parameters = population.parameters.iter().enumerate();
    let rows = parameters.map(|(index, one)| parameter_row(one, left(index))).collect();
    let header = POPULATION_COLUMNS.map(str::to_owned).to_vec();
    Table { text_columns: 1, above: vec![], header, rows }.without_empty_columns()
}

/// The tables of all populations, with the same columns: those that fit into `width` if so many suffice; and what was left out.
pub(super) fn population_tables(
    analysis: &Analysis,
    width: Option<usize>,
) -> (Vec<Table>, Vec<&'static str>) {
    let mut tables: Vec<Table> = analysis.populations.iter().map(population_table).collect();
    let mut left_out = Vec::new();
    for columns in DISPENSABLE {
        if width.is_none_or(|width| tables.iter().all(|table| table.width() <= width)) {
            break;
        }
        left_out.extend(columns);
        tables = tables.into_iter().map(|table| table.without_columns(columns)).collect();
    }
    (tables, left_out)
}

/// A parameter under `POPULATION_COLUMNS`, with what COLMAP left of it where it was refined.
pub(super) fn parameter_row(parameter: &Parameter, left: Option<&Parameter>) -> Vec<Cell> {
    let predicted = Cell::from(parameter.predicted_std.map_or(String::new(), number::std));
    let [left_mean, left_std] = left_cells(parameter, left);
    let name = Cell::from(parameter.name.as_str());
    let Some(statistics) = &parameter.statistics else {
        let mut row =
            vec![name, Cell::default(), lone_value(parameter), Cell::faint(state(parameter))];
        row.resize(7, Cell::default());
        row.extend([predicted, left_mean, left_std]);
        row.resize(POPULATION_COLUMNS.len(), Cell::default());
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
        Cell::from(statistics.std_px.map_or(String::new(), number::std)),
        Cell::from(statistics.relative_std.map_or(String::new(), number::percent)),
        Cell::from(format!("{low} .. {high}")),
        predicted,
        left_mean,
        left_std,
        plain(statistics.min),
        plain(statistics.q1),
        plain(statistics.median),
        plain(statistics.q3),
        plain(statistics.max),
        Cell::from(number::std(statistics.mad_std)),
        Cell::loud(few_of(outliers(parameter))),
    ]
}

/// Mean and std of the values that COLMAP left; nothing where both it and the refinement held them.
fn left_cells(parameter: &Parameter, left: Option<&Parameter>) -> [Cell; 2] {
    let Some(left) = left else { return [Cell::default(), Cell::default()] };
    match &left.statistics {
        Some(statistics) => {
            let places = Places::of_std(statistics.std, statistics.mean);
            [places.write(statistics.mean).into(), number::std(statistics.std).into()]
        }
        None if state(left) == state(parameter) => [Cell::default(), Cell::default()],
        None => [lone_value(left), Cell::faint(state(left))],
    }
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
    if has(SampleState::Held) || has(SampleState::PresumedHeld) {
        "held"
    } else if has(SampleState::Unknown) || has(SampleState::Estimated) {
        "one run"
    } else {
        "failed"
    }
}

/// What must be said beside the verdicts, most important first; equal sentences about several groups are said once.
pub(super) fn findings(analysis: &Analysis) -> Vec<Cell> {
    let mut said: Vec<(&Finding, Vec<&str>)> = Vec::new();
    for finding in analysis.findings.iter().filter(|finding| !is_reason(analysis, finding)) {
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
        FindingId::OpenDirection
        | FindingId::NoEstimate
        | FindingId::NotRepeated
        | FindingId::SkippedRun
        | FindingId::DuplicateRuns
        | FindingId::BogusCamera
        | FindingId::FewImages
        | FindingId::MissingCamera
        | FindingId::LostRuns
        | FindingId::RefinementFailed
        | FindingId::NotRefined
        | FindingId::OutlierRun
        | FindingId::Clusters
        | FindingId::Birge
        | FindingId::ClusteredErrors
        | FindingId::HeldParameter
        | FindingId::ResidualPattern
        | FindingId::HeavyTails
        | FindingId::SharedObservations
        | FindingId::NoSpread
        | FindingId::SmallRegion
        | FindingId::Fold
        | FindingId::MixedStates => Tone::Loud,
        FindingId::UnusedCamera
        | FindingId::MixedCameras
        | FindingId::CameraMatch
        | FindingId::CameraPerImage
        | FindingId::Refinement
        | FindingId::NoRay
        | FindingId::FewRuns
        | FindingId::Reading => Tone::Plain,
    }
}

#[cfg(test)]
mod tests {
    use super::super::plot::test_data::{analysis, estimated, parameter, population};
    use super::*;

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

    fn varying(group: &str, first: f64) -> Population {
        let parameters = vec![parameter("fx", &estimated(&[first, first + 1.0, first + 2.0]))];
        population(group, "camera 1", "OPENCV", parameters)
    }

    #[test]
    fn a_narrow_terminal_gets_the_same_columns_in_every_table() {
        let analysis = analysis(vec![varying("a", 500.0), varying("b", 1e6)]);
        let header = |width| {
            let (tables, left_out) = population_tables(&analysis, width);
            assert_eq!(tables[0].header, tables[1].header);
            let widest = tables.iter().map(Table::width).max().unwrap();
            assert!(width.is_none_or(|width| widest <= width), "{widest} > {width:?}");
            assert_eq!(tables[0].header.len() + left_out.len(), 13, "none is an outlier");
            (tables[0].header.join(" "), left_out)
        };
        assert_eq!(header(None).1, [""; 0]);
        let (columns, left_out) = header(Some(100));
        assert_eq!(columns, "parameter n mean std std px std % 95 % of std min median max");
        assert_eq!(left_out, ["q1", "q3", "MAD std"]);
    }

    #[test]
    fn a_std_in_px_stands_beside_the_std() {
        let rows = population_table(&varying("a", 500.0)).rows;
        let row: Vec<&str> = rows[0].iter().take(6).map(|cell| cell.text.as_str()).collect();
        assert_eq!(row, ["fx", "3", "501.0", "1.0", "2.0", "0.20 %"]);
    }
}
