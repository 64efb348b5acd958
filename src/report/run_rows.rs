//! The runs of each group one below the other, then mean and standard deviation: the thesis's tables 4.1 to 4.3.

use super::number::{self, Places};
use super::table::{Cell, Span, Table};
use crate::stability::{Analysis, Parameter, Population, Statistics};

/// A longer table is a list, and samples.csv is one already.
const MOST_RUNS: usize = 40;
/// A wider table is not read; the cameras of the group then have several.
const MOST_COLUMNS: usize = 12;

/// The tables of each group, under its name. Groups without statistics, or with too many runs to read, have none.
pub(super) fn run_rows(analysis: &Analysis) -> Vec<(&str, Vec<Table>)> {
    let mut groups: Vec<&str> = analysis.populations.iter().map(|one| one.group.as_str()).collect();
    groups.sort_by(|a, b| natord::compare(a, b));
    groups.dedup();
    let tables = |group: &str| {
        let of_group = analysis.populations.iter().filter(|one| one.group == group);
        let shown: Vec<&Population> = of_group.filter(|one| is_shown(one)).collect();
        let mut parts: Vec<Vec<&Population>> = Vec::new();
        for one in shown {
            let width =
                |part: &Vec<&Population>| part.iter().map(|p| summarised(p).count()).sum::<usize>();
            match parts.last_mut() {
                Some(part) if width(part) + summarised(one).count() <= MOST_COLUMNS => {
                    part.push(one)
                }
                _ => parts.push(vec![one]),
            }
        }
        parts.iter().map(|part| table(analysis, part)).collect::<Vec<Table>>()
    };
    groups.into_iter().map(|group| (group, tables(group))).filter(|(_, t)| !t.is_empty()).collect()
}

/// Whether the population has something to show, one sample a run, and not too many.
fn is_shown(population: &Population) -> bool {
    let mut parameters = summarised(population);
    parameters.next().is_some_and(|(parameter, _)| {
        let mut runs: Vec<&str> = parameter.samples.iter().map(|s| s.run.as_str()).collect();
        let count = runs.len();
        runs.dedup();
        runs.len() == count && count <= MOST_RUNS
    })
}

fn summarised(population: &Population) -> impl Iterator<Item = (&Parameter, &Statistics)> {
    population.parameters.iter().filter_map(|one| Some((one, one.statistics.as_ref()?)))
}

fn table(analysis: &Analysis, populations: &[&Population]) -> Table {
    let mut names: Vec<&str> = populations
        .iter()
        .flat_map(|one| &one.parameters[0].samples)
        .map(|sample| sample.run.as_str())
        .collect();
    names.sort_by(|a, b| natord::compare(a, b));
    names.dedup();
    let mut header = vec!["run".to_owned()];
    let mut above = vec![Span { columns: 1, title: String::new() }];
    let mut rows: Vec<Vec<Cell>> = names.iter().map(|name| vec![(*name).into()]).collect();
    let mut below: Vec<Vec<Cell>> =
        ["mean", "std", "std %", "std px", "spread px"].map(|what| vec![what.into()]).to_vec();
    for population in populations {
        let columns = summarised(population).count();
        above.push(Span { columns, title: population.camera.clone() });
        let spread = spread(analysis, population).map_or(String::new(), number::std);
        below[4].push(spread.into());
        below[4].extend(std::iter::repeat_n(Cell::default(), columns - 1));
        for (parameter, statistics) in summarised(population) {
            let places = Places::of_std(statistics.std, statistics.mean);
            header.push(parameter.name.clone());
            for (row, name) in rows.iter_mut().zip(&names) {
                let sample = parameter.samples.iter().find(|sample| sample.run == **name);
                let value = sample.and_then(|sample| sample.value);
                row.push(value.map_or(String::new(), |value| places.write(value)).into());
            }
            below[0].push(places.write(statistics.mean).into());
            below[1].push(number::std(statistics.std).into());
            below[2].push(statistics.relative_std.map_or(String::new(), number::percent).into());
            below[3].push(statistics.std_px.map_or(String::new(), number::std).into());
        }
    }
    below.retain(|row| row[1..].iter().any(|cell| !cell.text.is_empty()));
    rows.extend(below);
    Table { text_columns: 1, above, header, rows }
}

/// The spread of a population's pixels, if it was compared.
fn spread(analysis: &Analysis, population: &Population) -> Option<f64> {
    let ranked = analysis.comparisons.iter().flat_map(|comparison| &comparison.ranking);
    let mut own = ranked.filter(|one| {
        (&one.group, &one.camera, &one.model)
            == (&population.group, &population.camera, &population.model)
    });
    own.next()?.spread_px
}
