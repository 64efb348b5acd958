//! How groups compare, in tables and in words.

use super::number;
use super::table::{Cell, Table};
use crate::stability::{
    Components, GroupComparison, PairTest, ParameterTest, TestMethod, VarianceComponents,
};

/// Below this a corrected p tells two groups apart.
const LEVEL: f64 = 0.05;

/// Which camera the groups are compared by.
pub(super) fn comparison_title(comparison: &GroupComparison) -> String {
    let GroupComparison { camera, width, height, image_share, .. } = comparison;
    let over = match image_share {
        Some(share) if *share < 1.0 => format!("over {:.1} % of the image", 100.0 * share),
        Some(_) => "over the whole image".to_owned(),
        None => "no part of the image is seen in all runs".to_owned(),
    };
    format!("{camera}, {width} x {height}: spread {over}, rotations aligned")
}

/// The groups by their spread.
pub(super) fn ranking_table(comparison: &GroupComparison) -> Table {
    let header = ["group", "camera there", "model", "n", "spread px", "95 % of it", "raw px"];
    let rows = comparison.ranking.iter().map(|one| {
        let is_other = one.camera != comparison.camera;
        let interval = one.spread_interval_95.map_or(String::new(), interval);
        vec![
            one.group.as_str().into(),
            if is_other { one.camera.as_str().into() } else { Cell::default() },
            one.model.as_str().into(),
            one.n.to_string().into(),
            one.spread_px.map_or(String::new(), number::std).into(),
            interval.into(),
            one.raw_spread_px.map_or(String::new(), number::std).into(),
        ]
    });
    let header = header.map(str::to_owned).to_vec();
    Table { text_columns: 3, above: vec![], header, rows: rows.collect() }.without_empty_columns()
}

/// What the tests say, in sentences: of the spreads each, of parameters those that tell. No more than `most` of either.
pub(super) fn sentences(comparison: &GroupComparison, most: usize) -> Vec<String> {
    let mut told: Vec<String> = Vec::new();
    let spreads = &comparison.spreads;
    told.extend(spreads.iter().take(most).map(|test| sentence("spread", test)));
    if spreads.len() > most {
        let left = spreads.len() - most;
        let telling = spreads[most..].iter().filter(|test| tells(test)).count();
        told.push(format!("{left} more pairs, {telling} of them told apart: see the report"));
    }
    let with_spread = comparison.ranking.iter().filter(|one| one.spread_px.is_some()).count();
    if spreads.is_empty() && with_spread > 1 {
        told.push(format!(
            "{with_spread} groups are too many to test pair by pair: give fewer of them"
        ));
    }
    let parameters = &comparison.parameters;
    let telling: Vec<_> = parameters.iter().filter(|one| tells(&one.test)).collect();
    if !parameters.is_empty() {
        told.push(format!(
            "of {} tests of single parameters {} told apart",
            parameters.len(),
            match telling.len() {
                0 => "none finds its groups".to_owned(),
                1 => "1 finds its groups".to_owned(),
                count => format!("{count} find their groups"),
            }
        ));
    }
    let of_parameter =
        |one: &&ParameterTest| sentence(&format!("std of {}", one.parameter), &one.test);
    told.extend(telling.iter().take(most).map(of_parameter));
    told
}

fn tells(test: &PairTest) -> bool {
    test.p_holm < LEVEL
}

/// One test in words.
fn sentence(what: &str, test: &PairTest) -> String {
    let [more, less] = &test.groups;
    let [n_more, n_less] = test.n;
    let verdict = if tells(test) { "told apart" } else { "not told apart" };
    let method = match test.method {
        TestMethod::F => "F test: normal samples",
        TestMethod::BrownForsythe => "Brown-Forsythe test",
    };
    format!(
        "{more}'s {what} is {:.2} times {less}'s: {verdict} ({} after Holm, {method}, n = {n_more} and {n_less}); {}",
        test.ratio,
        said(test.p_holm),
        outlook(test),
    )
}

fn said(p: f64) -> String {
    let shown = probability(p);
    if shown.starts_with('<') { format!("p {shown}") } else { format!("p = {shown}") }
}

/// What so many runs can see of normal samples, and how many would be needed.
fn outlook(test: &PairTest) -> String {
    let runs = |n: Option<usize>| n.map_or("over 10000".to_owned(), |n| n.to_string());
    let mut said = format!(
        "so many runs see a ratio of 2 in {:.0} % of cases, {} runs each would in 80 %",
        100.0 * test.power_at_2,
        runs(test.n_for_2),
    );
    if !tells(test) {
        said.push_str(&format!("; this ratio needs {}", runs(test.n_for_ratio)));
    }
    said
}

/// Every test of a comparison, one a row.
pub(super) fn test_table(comparison: &GroupComparison) -> Table {
    let header = [
        "of",
        "the greater",
        "the lesser",
        "test",
        "std",
        "std",
        "ratio",
        "n",
        "p",
        "p Holm",
        "power at 2",
        "n for 2",
        "n for ratio",
    ];
    let spreads = comparison.spreads.iter().map(|test| test_row("spread px", test));
    let parameters = comparison.parameters.iter().map(|one| test_row(&one.parameter, &one.test));
    let header = header.map(str::to_owned).to_vec();
    Table { text_columns: 4, above: vec![], header, rows: spreads.chain(parameters).collect() }
}

fn test_row(what: &str, test: &PairTest) -> Vec<Cell> {
    let corrected = probability(test.p_holm);
    let n = |n: Option<usize>| n.map_or("> 10000".to_owned(), |n| n.to_string());
    vec![
        what.into(),
        test.groups[0].as_str().into(),
        test.groups[1].as_str().into(),
        match test.method {
            TestMethod::F => "F".into(),
            TestMethod::BrownForsythe => "Brown-Forsythe".into(),
        },
        number::std(test.std[0]).into(),
        number::std(test.std[1]).into(),
        format!("{:.2}", test.ratio).into(),
        format!("{}, {}", test.n[0], test.n[1]).into(),
        probability(test.p).into(),
        if tells(test) { Cell::loud(corrected) } else { corrected.into() },
        format!("{:.0} %", 100.0 * test.power_at_2).into(),
        n(test.n_for_2).into(),
        n(test.n_for_ratio).into(),
    ]
}

/// Which camera the components are about.
pub(super) fn components_title(components: &Components) -> String {
    let Components { camera, model, width, height, parent, groups, .. } = components;
    let place = if parent.is_empty() { String::new() } else { format!("{parent}: ") };
    format!("{place}{camera}, {model} {width} x {height}, {} groups", groups.len())
}

/// The components in one sentence, of the pixels; none where no pixel is seen in all runs.
pub(super) fn components_sentence(components: &Components) -> Option<String> {
    let image = components.image.as_ref()?.aligned.as_ref()?;
    Some(format!(
        "with rotations aligned, repeatability {} px, between groups {} px (95 %: {}), reproducibility {} px; two runs differ by less than {} px \
         in a group and {} px in different groups (95 %)",
        number::std(image.repeatability_std),
        number::std(image.between_std),
        interval(image.between_interval_95),
        number::std(image.reproducibility_std),
        number::std(image.repeatability_limit),
        number::std(image.reproducibility_limit),
    ))
}

/// The components of pixels and parameters, one a row, under their names in ISO 5725.
pub(super) fn components_table(components: &Components) -> Table {
    let header = [
        "of",
        "repeatability std s_r",
        "95 %",
        "between groups s_L",
        "95 %",
        "reproducibility std s_R",
        "95 %",
        "limit r",
        "limit R",
        "p of no difference",
    ];
    let image = components.image.iter().flat_map(|image| {
        let aligned = image.aligned.iter().map(|found| components_row("image, aligned px", found));
        aligned.chain([components_row("image, raw px", &image.raw)])
    });
    let parameters =
        components.parameters.iter().map(|one| components_row(&one.parameter, &one.components));
    let header = header.map(str::to_owned).to_vec();
    Table { text_columns: 1, above: vec![], header, rows: image.chain(parameters).collect() }
}

fn components_row(what: &str, found: &VarianceComponents) -> Vec<Cell> {
    vec![
        what.into(),
        number::std(found.repeatability_std).into(),
        interval(found.repeatability_interval_95).into(),
        number::std(found.between_std).into(),
        interval(found.between_interval_95).into(),
        number::std(found.reproducibility_std).into(),
        interval(found.reproducibility_interval_95).into(),
        number::std(found.repeatability_limit).into(),
        number::std(found.reproducibility_limit).into(),
        probability(found.p).into(),
    ]
}

fn interval([low, high]: [f64; 2]) -> String {
    format!("{} .. {}", number::std(low), number::std(high))
}

/// Two digits, and none below the thousandth: there the model is what is wrong.
fn probability(p: f64) -> String {
    if p < 0.001 { "< 0.001".to_owned() } else { number::std(p) }
}
