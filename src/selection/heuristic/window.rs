//! Consecutive images from a start of chance: how the thesis cut its sequences.

use super::super::field::Field;
use super::super::growth::Growth;
use super::super::{Choice, SelectionError};
use super::Heuristic;
use crate::synth::{Purpose, Random};

pub(super) const WINDOW: Heuristic = Heuristic {
    name: "window",
    summary: "consecutive images, from a start of chance; what does not hang together is passed over",
    choose,
};

fn choose(field: &Field<'_>) -> Result<Vec<Choice>, SelectionError> {
    let sequence = field.sequence();
    let count = sequence.len();
    let start = Random::new(field.seed, 0, Purpose::Selection).order(count - field.size + 1)[0];
    // Steps from the start; what comes before it counts on from the end.
    let mut steps = vec![0; count];
    for (place, &group) in sequence.iter().enumerate() {
        steps[group] = (place + count - start) % count;
    }
    Growth::by_score(
        field,
        |_, group| -(steps[group] as f64),
        |growth, group, _| match growth.chosen.last() {
            None => "the start of the window".to_owned(),
            Some(_) => format!("{} after the start of the window", steps[group]),
        },
    )
}
