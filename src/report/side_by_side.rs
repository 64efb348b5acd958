//! The groups of runs side by side, for comparing them.

use std::collections::BTreeMap;

use super::sections::parameter_row;
use super::table::{Cell, Span, Table};
use crate::stability::{Analysis, Parameter, ParameterClass, Population, SampleState};

/// The columns of each group: the third to sixth of a parameter's row. A narrow terminal gets all but the last.
const COLUMNS: [&str; 4] = ["mean", "std", "std px", "std %"];

/// The groups side by side, as in tables 4.1 to 4.3 of the thesis: per camera and parameter, each group's mean, standard
/// deviation, and the latter in px and in percent. Where they would be wider than `width`, they do without percent and are split.
pub(super) fn side_by_side(analysis: &Analysis, width: Option<usize>) -> Vec<Table> {
    let mut groups: Vec<&str> = analysis.populations.iter().map(|one| one.group.as_str()).collect();
    groups.sort_by(|a, b| natord::compare(a, b));
    groups.dedup();
    let fits = |table: &Table| width.is_none_or(|width| table.width() <= width);
    let whole = side_by_side_table(analysis, &groups, &COLUMNS);
    if fits(&whole) {
        return vec![whole];
    }
    let mut tables = Vec::new();
    let mut rest = groups.as_slice();
    while !rest.is_empty() {
        let table = |count: usize| side_by_side_table(analysis, &rest[..count], &COLUMNS[..3]);
        let count = (2..=rest.len()).take_while(|&count| fits(&table(count))).last().unwrap_or(1);
        tables.push(table(count));
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

fn side_by_side_table(analysis: &Analysis, groups: &[&str], columns: &[&str]) -> Table {
    let mut header = ["camera", "model", "parameter"].map(str::to_owned).to_vec();
    let text_columns = header.len();
    let mut above = vec![Span { columns: text_columns, title: String::new() }];
    for group in groups {
        header.extend(columns.iter().map(|column| (*column).to_owned()));
        above.push(Span { columns: columns.len(), title: (*group).to_owned() });
    }
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut row_of: BTreeMap<RowKey, usize> = BTreeMap::new();
    for population in &analysis.populations {
        let Some(group) = groups.iter().position(|group| *group == population.group) else {
            continue;
        };
        let start = text_columns + columns.len() * group;
        let cells = start..start + columns.len();
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
            rows[row][cells.clone()]
                .clone_from_slice(&parameter_row(parameter, None)[2..2 + columns.len()]);
        }
    }
    Table { text_columns, above, header, rows }
}

/// Whether all that is known of the parameter was held: it says nothing about stability.
fn is_held(parameter: &Parameter) -> bool {
    use SampleState::{Failed, Held, PresumedHeld};
    parameter.samples.iter().all(|s| matches!(s.state, Held | PresumedHeld | Failed))
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
            "camera 1|several|fx|501.0|1.0|2.0|0.20 %|601.0|1.0|2.0|0.17 %",
            "camera 1|OPENCV|k1|-0.110|0.010|0.020|9.1 %||||",
            "camera 1|RADTAN|k1|||||-0.110|0.010|0.020|9.1 %",
        ];
        assert_eq!(tables.iter().flat_map(rows).collect::<Vec<_>>(), want);
    }

    #[test]
    fn two_models_in_one_group_never_overwrite_each_other() {
        let analysis = analysis(vec![opencv("a", "OPENCV", 500.0), opencv("a", "RADTAN", 600.0)]);
        let found: Vec<String> = side_by_side(&analysis, None).iter().flat_map(rows).collect();
        assert_eq!(found.len(), 4);
        assert!(found.contains(&"camera 1|OPENCV|fx|501.0|1.0|2.0|0.20 %".to_owned()), "{found:?}");
        assert!(found.contains(&"camera 1|RADTAN|fx|601.0|1.0|2.0|0.17 %".to_owned()), "{found:?}");
    }

    #[test]
    fn a_narrow_terminal_gets_several_tables_with_every_group() {
        let groups = ["a", "b", "c", "d"];
        let analysis =
            analysis(groups.iter().map(|group| opencv(group, "OPENCV", 500.0)).collect());
        let tables = side_by_side(&analysis, Some(80));
        assert!(tables.len() > 1 && tables.iter().all(|table| table.width() <= 80));
        assert!(tables.iter().all(|table| !table.header.contains(&"std %".to_owned())));
        let titles: Vec<&str> = tables
            .iter()
            .flat_map(|table| &table.above[1..])
            .map(|span| span.title.as_str())
            .collect();
        assert_eq!(titles, groups);
    }
}
