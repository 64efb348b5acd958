//! Images by chance.

use super::super::field::Field;
use super::super::growth::Growth;
use super::super::{Choice, SelectionError};
use super::Heuristic;
use crate::synth::{Purpose, Random};

pub(super) const RANDOM: Heuristic = Heuristic {
    name: "random",
    summary: "by chance, among those that hang together with the ones drawn before",
    choose,
};

fn choose(field: &Field<'_>) -> Result<Vec<Choice>, SelectionError> {
    let mut draws = vec![0; field.groups.len()];
    let order = Random::new(field.seed, 0, Purpose::Selection).order(field.groups.len());
    order.iter().enumerate().for_each(|(draw, &group)| draws[group] = draw + 1);
    Growth::by_score(
        field,
        |_, group| -(draws[group] as f64),
        |_, group, _| format!("drawn as number {}", draws[group]),
    )
}
