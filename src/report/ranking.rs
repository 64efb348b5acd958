//! Which heuristic chooses best, as tables and sentences.

use std::fmt::Write;

use super::number;
use super::table::{Cell as Text, Table, escaped};
use crate::selection::experiment::{Cell, ErrorParts, RankRow, Ranking, Ratio, Selection, Target};

/// For a terminal: the answer, the order, and the errors by size.
pub fn ranking_text(selection: &Selection) -> String {
    let mut out = String::new();
    for sentence in sentences(selection) {
        let _ = writeln!(out, "{sentence}");
    }
    if let Some(overall) = selection.rankings.first() {
        let _ = write!(out, "\n{}", ranking_table(overall).text());
    }
    let _ = write!(out, "\n{}", size_table(selection).text());
    if let Some(table) = target_table(selection) {
        let _ = write!(out, "\n{}", table.text());
    }
    out
}

/// As Markdown, with pictures (relative path, alternative text) at the end.
pub fn ranking_markdown(selection: &Selection, pictures: &[(String, String)]) -> String {
    let mut out = String::from("# Which images calibrate best\n\n");
    for sentence in sentences(selection) {
        let _ = writeln!(out, "{}\n", escaped(&sentence));
    }
    let _ = writeln!(out, "{}", escaped(&setting(selection)));
    for remark in &selection.remarks {
        let _ = write!(out, "\n- {}", escaped(remark));
    }
    for ranking in &selection.rankings {
        let title = escaped(&title(selection, ranking));
        let _ = write!(out, "\n\n## {title}\n\n{}", ranking_table(ranking).markdown());
        let _ = write!(out, "\n{}", escaped(&verdict(ranking)));
    }
    let _ = write!(out, "\n\n## Error in px by size\n\n{}", size_table(selection).markdown());
    if let Some(table) = target_table(selection) {
        let _ = write!(out, "\n## Images needed\n\n{}", table.markdown());
    }
    out.push_str(LEGEND);
    for (index, model) in selection.models.iter().enumerate() {
        let cells: Vec<&Cell> = selection.cells.iter().filter(|it| it.model == index).collect();
        let (name, sigma) = (escaped(&model.name), number::computed(model.sigma_px));
        let (units, pool) = (model.unit_count, model.pool_size);
        let _ = write!(
            out,
            "\n### {name}\n\n{units} images or frames that hang together, {pool} in a pool, noise {sigma} px.\n\n{}",
            cell_table(&cells).markdown()
        );
        out.push_str(&failures(&cells));
    }
    if !pictures.is_empty() {
        out.push_str("\n## Plots\n");
    }
    for (path, text) in pictures {
        let _ = write!(out, "\n![{}]({path})\n", escaped(text));
    }
    let _ = write!(out, "\nMade by calibstab {}.\n", selection.calibstab_version);
    out
}

/// What the columns of the cells mean.
const LEGEND: &str = "\n## Every cell

Error: RMS over the image and the repeats of how far the calibration is off, after it was turned onto what it is compared with, as \
poses would absorb; its square is that of the bias and (n - 1) / n of that of the spread. Raw: the same without turning. Held out: the \
median distance in px between points and where the images that were not chosen see them: lens and points as the chosen images give \
them, each pose from half of the image's observations, the other half measured. Overlap: the share of their images that two repeats \
have in common. Points that fewer than two of the chosen images see are left out, the others start where the full reconstruction has \
them, a little off.
";

/// The answer in plain words.
fn sentences(selection: &Selection) -> Vec<String> {
    let Some(overall) = selection.rankings.first() else { return Vec::new() };
    let mut sentences = vec![verdict(overall)];
    sentences.extend(by_size(selection));
    sentences.extend(models_agree(selection));
    sentences
}

/// Who wins, or who cannot be told apart.
fn verdict(ranking: &Ranking) -> String {
    let Some(first) = ranking.rows.first() else {
        return "No heuristic gave calibrations often enough to be ranked.".to_owned();
    };
    let against_chance = |row: &RankRow| match row.to_random {
        Some(ratio) => format!(", {} of chance's", ratio_words(ratio)),
        None => String::new(),
    };
    let error = number::computed(first.rms_px);
    if ranking.winner.as_ref() == Some(&first.heuristic) {
        let name = &first.heuristic;
        let next = ranking.rows.get(1).and_then(|next| Some((next, next.to_first?)));
        let next = next.map_or_else(String::new, |(next, ratio)| {
            format!("; the next, {}, has {} times as much", next.heuristic, ratio_words(ratio))
        });
        return format!(
            "{name} chooses best, and that is certain: an error of {error} px{}{next}.",
            against_chance(first)
        );
    }
    let name = &first.heuristic;
    let is_told =
        ranking.rows.iter().any(|row| row.to_first.is_some_and(|it| it.interval_95.is_some()));
    let why = match is_told {
        true => "none of them is shown to be better than the others",
        false => "without independent replicates nothing tells whether a difference is certain",
    };
    let tied = ranking.first.join(", ");
    let best = format!("least error: {name}, {error} px{}", against_chance(first));
    match ranking.first.len() == ranking.rows.len() {
        true => format!("No winner: {why}. The {best}."),
        false => format!("No single winner among {tied}: {why}. The {best}."),
    }
}

/// At which sizes who wins, where that differs from the whole.
fn by_size(selection: &Selection) -> Option<String> {
    let of_sizes: Vec<String> = selection
        .rankings
        .iter()
        .filter_map(|ranking| {
            let (size, first) = (ranking.size?, ranking.rows.first()?);
            let tied = ranking.first.len();
            let words = match (&ranking.winner, tied) {
                (Some(winner), _) => format!("{winner} wins"),
                (None, tied) => format!("{} first, {tied} tied", first.heuristic),
            };
            Some(format!("of {size}: {words}"))
        })
        .collect();
    (!of_sizes.is_empty()).then(|| format!("By size, {}.", of_sizes.join("; ")))
}

fn models_agree(selection: &Selection) -> Option<String> {
    let agreement = selection.agreement.as_ref()?;
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for best in &agreement.best {
        match counts.iter_mut().find(|(name, _)| name == best) {
            Some((_, count)) => *count += 1,
            None => counts.push((best, 1)),
        }
    }
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let all = agreement.best.len();
    let counts: Vec<String> =
        counts.iter().map(|(name, count)| format!("{name} in {count}")).collect();
    let concordance = agreement.concordance.map_or_else(String::new, |w| {
        format!("; the orders agree with a concordance (Kendall's W) of {w:.2}")
    });
    Some(format!("Least error of {all} models: {}{concordance}.", counts.join(", ")))
}

/// What was done, in a sentence.
fn setting(selection: &Selection) -> String {
    let options = &selection.options;
    let compared = match &options.truth {
        Some(truth) => format!("the known cameras of {}", truth.path),
        None => "the full reconstruction".to_owned(),
    };
    let noise = match options.noise.as_str() {
        "redraw" => "with noise drawn anew",
        _ => "with the noise as it was measured",
    };
    format!(
        "{} repeats of each size, pool {}, {noise}, seed {}, moving: {}; compared with {compared}.",
        options.repeats,
        options.pool,
        options.seed,
        options.refine.join(", ")
    )
}

fn title(selection: &Selection, ranking: &Ranking) -> String {
    match (ranking.model, ranking.size) {
        (Some(model), _) => format!("Of {}", selection.models[model].name),
        (None, Some(size)) => format!("Of size {size}"),
        (None, None) => "Over all sizes".to_owned(),
    }
}

fn ratio_words(ratio: Ratio) -> String {
    let interval =
        ratio.interval_95.map_or_else(String::new, |[low, high]| format!(" [{low:.2}, {high:.2}]"));
    format!("{:.2}{interval}", ratio.ratio)
}

fn ranking_table(ranking: &Ranking) -> Table {
    let row = |row: &RankRow| -> Vec<Text> {
        let ratio = |ratio: Option<Ratio>| ratio.map_or_else(String::new, ratio_words);
        vec![
            row.heuristic.as_str().into(),
            row.rank.to_string().into(),
            number::computed(row.rms_px).into(),
            ratio(row.to_first).into(),
            ratio(row.to_random).into(),
        ]
    };
    let mut rows: Vec<Vec<Text>> = ranking.rows.iter().map(row).collect();
    rows.extend(
        ranking.unranked.iter().map(|name| {
            vec![name.as_str().into(), "fails".into(), "".into(), "".into(), "".into()]
        }),
    );
    Table {
        text_columns: 1,
        above: vec![],
        header: ["heuristic", "rank", "error px", "times the first's", "times chance's"]
            .map(str::to_owned)
            .to_vec(),
        rows,
    }
    .without_empty_columns()
}

/// The error of each heuristic at each size: with its interval of one model, the geometric mean of several.
fn size_table(selection: &Selection) -> Table {
    let mut sizes: Vec<usize> = selection.cells.iter().map(|cell| cell.size).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let error = |name: &str, size: usize| -> String {
        let own = selection.cells.iter().filter(|it| it.size == size && it.heuristic == name);
        let own: Vec<&Cell> = own.collect();
        let logs: Option<f64> = own.iter().map(|it| Some(it.error?.rms_px.ln())).sum();
        let Some(logs) = logs else { return "fails".to_owned() };
        let mean = number::computed((logs / own.len() as f64).exp());
        match own.as_slice() {
            [alone] => format!("{mean}{}", interval(alone.interval_95)),
            _ => mean,
        }
    };
    let row = |(name, _): &(String, String)| -> Vec<Text> {
        let errors = sizes.iter().map(|&size| error(name, size).into());
        std::iter::once(name.as_str().into()).chain(errors).collect()
    };
    let header = sizes.iter().map(|size| format!("of {size}"));
    Table {
        text_columns: 1,
        above: vec![],
        header: std::iter::once("error px".to_owned()).chain(header).collect(),
        rows: selection.options.heuristics.iter().map(row).collect(),
    }
}

fn interval(interval: Option<[f64; 2]>) -> String {
    interval.map_or_else(String::new, |ends| {
        let [low, high] = ends.map(number::std);
        format!(" [{low}, {high}]")
    })
}

fn target_table(selection: &Selection) -> Option<Table> {
    let target_px = selection.options.target_px?;
    let size =
        |size: Option<usize>| size.map_or_else(|| "none tried".to_owned(), |it| it.to_string());
    let row = |target: &Target| -> Vec<Text> {
        vec![
            target.heuristic.as_str().into(),
            size(target.size).into(),
            size(target.certain_size).into(),
        ]
    };
    Some(Table {
        text_columns: 1,
        above: vec![],
        header: vec![
            "heuristic".to_owned(),
            format!("images for {} px", number::value(target_px)),
            "certainly".to_owned(),
        ],
        rows: selection.targets.iter().map(row).collect(),
    })
}

fn cell_table(cells: &[&Cell]) -> Table {
    let row = |cell: &&Cell| -> Vec<Text> {
        let px = |value: Option<f64>| value.map_or_else(String::new, number::computed);
        let parts = |parts: Option<ErrorParts>| -> [Text; 3] {
            [
                px(parts.map(|it| it.rms_px)).into(),
                px(parts.map(|it| it.bias_px)).into(),
                px(parts.and_then(|it| it.spread_px)).into(),
            ]
        };
        let [error, bias, spread] = parts(cell.error);
        let [raw_error, raw_bias, raw_spread] = parts(cell.raw);
        let failures = if cell.failures > 0 { cell.failures.to_string() } else { String::new() };
        vec![
            cell.heuristic.as_str().into(),
            cell.size.to_string().into(),
            cell.n.to_string().into(),
            failures.into(),
            error,
            interval(cell.interval_95).into(),
            bias,
            spread,
            raw_error,
            raw_bias,
            raw_spread,
            px(cell.held_out_px).into(),
            cell.overlap.map_or_else(String::new, |share| format!("{share:.2}")).into(),
        ]
    };
    Table {
        text_columns: 1,
        above: vec![],
        header: [
            "heuristic",
            "size",
            "n",
            "failures",
            "error",
            "95 %",
            "bias",
            "spread",
            "raw error",
            "raw bias",
            "raw spread",
            "held out",
            "overlap",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows: cells.iter().map(row).collect(),
    }
    .without_empty_columns()
}

/// Why there are cells with fewer calibrations than repeats.
fn failures(cells: &[&Cell]) -> String {
    let mut out = String::new();
    for cell in cells {
        for (reason, count) in &cell.reasons {
            let (name, size) = (&cell.heuristic, cell.size);
            let _ = write!(out, "\n- {name}, {size}, {count} of its repeats: {}", escaped(reason));
        }
    }
    if out.is_empty() { out } else { out + "\n" }
}
