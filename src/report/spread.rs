//! The tables and sentences of a spread.

use super::number;
use super::table::{Cell, Table};
use crate::stability::Population;
use crate::stability::spread::{DifferenceMeasure, Spread, SpreadMeasure};

/// A spread, one alignment a row.
pub(super) fn spread_table(spread: &Spread) -> Table {
    let header =
        ["spread", "rms px", "95 % px", "max px", "at", "rms deg", "max deg", "median-based px"];
    let mut rows = vec![row("as they are", &spread.raw), row("turned", &spread.rotated)];
    if let Some(moved) = &spread.moved {
        rows.push(row("turned and moved", &moved.measure));
    }
    Table { text_columns: 1, above: vec![], header: header.map(str::to_owned).to_vec(), rows }
}

fn row(name: &str, measure: &SpreadMeasure) -> Vec<Cell> {
    let numbers = [measure.rms_px, measure.p95_px, measure.max_px].map(number::computed);
    let more = [measure.rms_deg, measure.max_deg, measure.median_based_px].map(number::computed);
    let mut row = vec![Cell::from(name)];
    row.extend(numbers.map(Cell::from));
    row.push(place(measure.max_at).into());
    row.extend(more.map(Cell::from));
    row
}

pub(super) fn place([x, y]: [f64; 2]) -> String {
    format!("{x:.0}, {y:.0}")
}

/// A difference under "rms px", "95 % px", "max px", "at".
pub(super) fn difference_cells(measure: &DifferenceMeasure) -> Vec<Cell> {
    let numbers = [measure.rms_px, measure.p95_px, measure.max_px].map(number::computed);
    let mut cells: Vec<Cell> = numbers.map(Cell::from).into();
    cells.push(place(measure.max_at).into());
    cells
}

/// What a spread is over, which run is the odd one, and what the runs share.
pub(super) fn spread_words(spread: &Spread) -> String {
    let share = 100.0 * spread.cell_share;
    let mut words =
        format!("{} runs over {share:.0} % of the image (region {})", spread.n, spread.region);
    if let Some(moved) = &spread.moved {
        let [near, _, far] = moved.depths.map(number::std);
        words.push_str(&format!("; moved at {near}, 1 and {far} of the median depth"));
    }
    if spread.n > 2 {
        let worst = spread
            .runs
            .iter()
            .find(|run| run.run == spread.worst.run && run.camera_id == spread.worst.camera_id);
        if let Some(worst) = worst {
            let [rms, max] = [worst.rms_px, worst.max_px].map(number::computed);
            let at = place(worst.max_at);
            words.push_str(&format!(
                "; furthest off is {}: {rms} px, at most {max} px at {at}",
                worst.run
            ));
        }
    }
    words
}

/// What the runs of a population share, and what that does to its spread and std; nothing where it cannot be known.
pub(super) fn overlap_words(population: &Population) -> Option<String> {
    let overlap = population.overlap.as_ref()?;
    let shared = number::percent(overlap.shared_fraction);
    let mut words = format!("Runs share {shared} of their observations");
    match (overlap.independent_factor, overlap.independent_rms_px) {
        (Some(factor), Some(px)) => {
            let [factor, px] = [factor, px].map(number::computed);
            words.push_str(&format!(
                ": independent ones would show {factor} times the spread and std, turned {px} px"
            ));
        }
        (Some(_), None) => {}
        (None, _) => words.push_str(": these repeats show the solver's repeatability only"),
    }
    if let Some(factor) = overlap.jackknife_factor {
        let (taken, all) = (number::computed(overlap.images_per_run), overlap.image_count);
        let factor = number::computed(factor);
        words.push_str(&format!(
            "; if each is a random draw of {taken} of {all} images, all of them would have {factor} times the std (jackknife)"
        ));
    }
    Some(words)
}

/// The parts that the runs fall into, one a row; none when they agree.
pub(super) fn parts_table(population: &Population) -> Option<Table> {
    let clusters = population.clusters.as_ref()?;
    let names: Vec<&str> = population.parameters.iter().map(|one| one.name.as_str()).collect();
    let has =
        |name: &&str| clusters.parts.iter().any(|p| p.parameters.iter().any(|o| o.name == *name));
    let names: Vec<&str> = names.into_iter().filter(has).collect();
    let mut header: Vec<String> =
        ["part", "runs", "gap px", "spread px", "turned px"].map(str::to_owned).into();
    header.extend(names.iter().map(|name| format!("{name} mean +- std")));
    let rows = clusters.parts.iter().enumerate().map(|(index, part)| {
        let px = |px: Option<f64>| Cell::from(px.map_or(String::new(), number::computed));
        let mut runs = part.runs.clone();
        let more = runs.len().saturating_sub(6);
        runs.truncate(6);
        if more > 0 {
            runs.push(format!("+{more}"));
        }
        let mut row: Vec<Cell> = vec![(index + 1).to_string().into(), runs.join(" ").into()];
        row.push(px(part.gap_px));
        row.extend([0, 1].map(|at| px(part.spread_px.map(|spread| spread[at]))));
        row.extend(names.iter().map(|name| {
            let found = part.parameters.iter().find(|one| one.name == *name);
            let text = found.map(|one| {
                let mean = number::Places::of_std(one.std, one.mean).write(one.mean);
                format!("{mean} +- {}", number::std(one.std))
            });
            Cell::from(text.unwrap_or_default())
        }));
        row
    });
    Some(Table { text_columns: 2, above: vec![], header, rows: rows.collect() })
}
