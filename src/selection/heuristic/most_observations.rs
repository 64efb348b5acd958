//! The images that see most.

use super::super::field::Field;
use super::super::growth::Growth;
use super::super::{Choice, SelectionError};
use super::Heuristic;

pub(super) const MOST_OBSERVATIONS: Heuristic =
    Heuristic { name: "most-observations", summary: "those that see the most points", choose };

fn choose(field: &Field<'_>) -> Result<Vec<Choice>, SelectionError> {
    Growth::by_score(
        field,
        |_, group| {
            field.wanted_images(group).map(|at| field.candidates.point_count(at)).sum::<usize>()
                as f64
        },
        |_, _, gain| format!("sees {gain} points"),
    )
}
