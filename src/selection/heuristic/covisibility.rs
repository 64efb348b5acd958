//! Images that share most with each other.

use super::super::field::Field;
use super::super::growth::Growth;
use super::super::{Choice, SelectionError};
use super::Heuristic;

pub(super) const COVISIBILITY: Heuristic = Heuristic {
    name: "covisibility",
    summary: "those that share the most points with the ones chosen before",
    choose,
};

fn choose(field: &Field<'_>) -> Result<Vec<Choice>, SelectionError> {
    let partners = |point: &usize| field.seen_by(*point).len().saturating_sub(1);
    Growth::by_score(
        field,
        |growth, group| match growth.chosen.is_empty() {
            true => field.groups[group].points.iter().map(partners).sum::<usize>() as f64,
            false => growth.shared(group) as f64,
        },
        |growth, _, gain| match growth.chosen.is_empty() {
            true => format!("others see its points {gain} times"),
            false => format!("shares {gain} points with those chosen before"),
        },
    )
}
