//! What the panels of a figure leave out, in words below it.

use crate::stability::{Parameter, RunRecord, SampleState};

use super::font::clean;
use super::number::{short, unbroken};
use super::subject::{Row, Subject, drawn, held};

/// The held parameters with their values, the runs that a group lacks, and those that are suspect.
pub fn notes(subject: &Subject, rows: &[Row]) -> Vec<String> {
    let mut notes = Vec::new();
    let held: Vec<String> =
        rows.iter().filter(|row| !row.varies()).filter_map(|row| held_in(subject, row)).collect();
    if !held.is_empty() {
        notes.push(format!("{}, not drawn: {}.", held_word(rows), held.join("; ")));
    }
    for row in rows.iter().filter(|row| row.varies()) {
        notes.extend(partly_held(subject, row));
    }
    notes.extend(missing(subject, rows));
    notes.extend(suspect(subject));
    notes
}

/// What our own refinement held is known; of what COLMAP left it is presumed.
fn held_word(rows: &[Row]) -> &'static str {
    let mut samples =
        rows.iter().flat_map(|row| &row.cells).flat_map(|(_, parameter)| &parameter.samples);
    match samples.any(|sample| sample.state == SampleState::PresumedHeld) {
        true => "Presumed held",
        false => "Held",
    }
}

/// The runs of the subject's groups that are flagged or copies, and those that could not be read.
pub fn suspect(subject: &Subject) -> Vec<String> {
    /// A longer list is for the report's text.
    const LISTED: usize = 6;
    let is_shown =
        |run: &&RunRecord| subject.members.iter().any(|m| m.population.group == run.group);
    let runs = || subject.analysis.runs.iter().filter(is_shown);
    let flagged = runs().filter(|run| !run.flags.is_empty()).map(|run| {
        let flags: Vec<&str> = run.flags.iter().map(|flag| flag.name()).collect();
        let left_out = if run.is_used { "" } else { ", left out" };
        format!("{} of {} ({}{left_out})", clean(&run.run), clean(&run.group), flags.join(", "))
    });
    let copies = runs().filter_map(|run| {
        let original = run.duplicate_of.as_ref()?;
        Some(format!("{} of {} (of {})", clean(&run.run), clean(&run.group), clean(original)))
    });
    let skipped = subject.analysis.skipped.iter().map(|skipped| clean(&skipped.path));
    let kinds: [(&str, Vec<String>); 3] = [
        ("Flagged", flagged.collect()),
        ("Copies, not drawn", copies.collect()),
        ("Skipped, as they could not be read", skipped.collect()),
    ];
    let note = |(what, mut runs): (&str, Vec<String>)| {
        let more = runs.len().saturating_sub(LISTED);
        if more > 0 {
            runs.truncate(LISTED);
            runs.push(format!("{more} more"));
        }
        (!runs.is_empty()).then(|| format!("{what}: {}.", runs.join("; ")))
    };
    kinds.into_iter().filter_map(note).collect()
}

/// `cx = 376 px`, or by group where groups differ.
fn held_in(subject: &Subject, row: &Row) -> Option<String> {
    let mut groups_of: Vec<(String, Vec<&str>)> = Vec::new();
    for (member, parameter) in &row.cells {
        let Some(values) = held_values(parameter, row.unit) else { continue };
        let group = subject.members[*member].group.as_str();
        match groups_of.iter_mut().find(|(known, _)| *known == values) {
            Some((_, groups)) => groups.push(group),
            None => groups_of.push((values, vec![group])),
        }
    }
    match groups_of.as_slice() {
        [] => None,
        [(values, _)] => Some(unbroken(&format!("{} = {values}", row.name))),
        several => {
            let parts: Vec<String> = several
                .iter()
                .map(|(values, groups)| format!("{values} ({})", groups.join(", ")))
                .collect();
            Some(format!("{} {}", unbroken(&format!("{} =", row.name)), parts.join(", ")))
        }
    }
}

/// The values at which a parameter was held: nearly always one.
pub fn held_values(parameter: &Parameter, unit: &str) -> Option<String> {
    const LISTED: usize = 3;
    let mut values: Vec<f64> = parameter.samples.iter().filter_map(held).collect();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| a.to_bits() == b.to_bits());
    if values.is_empty() {
        return None;
    }
    let listed: Vec<String> = values.iter().take(LISTED).copied().map(short).collect();
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let more = if values.len() > LISTED {
        format!(" and {} more", values.len() - LISTED)
    } else {
        String::new()
    };
    Some(unbroken(&format!("{}{unit}{more}", listed.join(" or "))))
}

fn partly_held(subject: &Subject, row: &Row) -> Option<String> {
    let parts: Vec<String> = row
        .cells
        .iter()
        .filter_map(|(member, parameter)| {
            let values = held_values(parameter, row.unit)?;
            let count = parameter.samples.iter().filter_map(held).count();
            let group = &subject.members[*member].group;
            Some(format!("{values} in {count} of {} runs of {group}", parameter.samples.len()))
        })
        .collect();
    (!parts.is_empty())
        .then(|| format!("{} held in some runs, not drawn: {}.", row.name, parts.join("; ")))
}

/// How many runs of each group have no value: of any parameter, since a failed run lacks them all.
fn missing(subject: &Subject, rows: &[Row]) -> Option<String> {
    let mut parts = Vec::new();
    for (index, member) in subject.members.iter().enumerate() {
        let parameters: Vec<&Parameter> = rows
            .iter()
            .flat_map(|row| &row.cells)
            .filter(|(at, _)| *at == index)
            .map(|(_, parameter)| *parameter)
            .collect();
        let run_count =
            parameters.iter().map(|parameter| parameter.samples.len()).max().unwrap_or(0);
        let lacks = |run: usize| {
            let sample = |parameter: &&Parameter| {
                parameter.samples.get(run).is_none_or(|s| drawn(s).or(held(s)).is_none())
            };
            parameters.iter().any(sample)
        };
        let count = (0..run_count).filter(|&run| lacks(run)).count();
        if count > 0 {
            parts.push(format!("{count} of {run_count} of {}", member.group));
        }
    }
    (!parts.is_empty()).then(|| format!("Failed runs, not drawn: {}.", parts.join("; ")))
}
