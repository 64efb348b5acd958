//! Images that look in unlike directions.

use super::super::field::Field;
use super::super::{Choice, SelectionError};
use super::{Heuristic, farthest_first};

pub(super) const DIRECTIONS: Heuristic = Heuristic {
    name: "directions",
    summary: "those that look in a direction farthest from the others'",
    choose,
};

fn choose(field: &Field<'_>) -> Result<Vec<Choice>, SelectionError> {
    let axis = |group| field.wanted_images(group).next().map(|image| field.candidates.axis(image));
    let axes: Vec<_> = (0..field.groups.len()).filter_map(axis).collect();
    farthest_first(
        field,
        |one, other| axes[one].angle(&axes[other]).to_degrees(),
        |gain| format!("looks {gain:.1} degrees away from the nearest chosen before"),
    )
}
