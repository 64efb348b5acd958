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
    Growth::by_score(
        field,
        |growth, group| match growth.chosen.is_empty() {
            true => partner_count(field, group) as f64,
            false => growth.shared(group) as f64,
        },
        |growth, _, gain| match growth.chosen.is_empty() {
            true => format!("others see its points {gain} times"),
            false => format!("shares {gain} points with those chosen before"),
        },
    )
}

/// How many times others see the points of a group.
pub(super) fn partner_count(field: &Field<'_>, group: usize) -> usize {
    let partners = |point: &usize| field.seen_by(*point).len().saturating_sub(1);
    field.groups[group].points.iter().map(partners).sum()
}
