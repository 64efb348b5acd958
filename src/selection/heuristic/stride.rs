//! Images at even steps through the sequence.

use super::super::field::Field;
use super::super::growth::Growth;
use super::super::{Choice, SelectionError};
use super::Heuristic;

pub(super) const STRIDE: Heuristic = Heuristic {
    name: "stride",
    summary: "at even steps through the sequence, or as near to them as hangs together",
    choose,
};

fn choose(field: &Field<'_>) -> Result<Vec<Choice>, SelectionError> {
    let sequence = field.sequence();
    let mut places = vec![0; sequence.len()];
    sequence.iter().enumerate().for_each(|(place, &group)| places[group] = place);
    // The middles of as many equal parts of the sequence.
    let mut targets: Vec<usize> =
        (0..field.size).map(|part| (2 * part + 1) * sequence.len() / (2 * field.size)).collect();
    let mut done = 0;
    let off = |target: usize, group: usize| target.abs_diff(places[group]);
    Growth::by_score(
        field,
        |growth, group| {
            while let Some(&last) = growth.chosen.get(done) {
                if let Some(met) = (0..targets.len()).min_by_key(|&at| off(targets[at], last)) {
                    targets.remove(met);
                }
                done += 1;
            }
            let nearest = targets.iter().map(|&target| off(target, group)).min();
            nearest.map_or(f64::NEG_INFINITY, |off| -(off as f64))
        },
        |_, group, gain| {
            let (place, count) = (places[group] + 1, places.len());
            format!("number {place} of {count} in the sequence, {} beside an even step", -gain)
        },
    )
}
