//! Images taken from unlike places: farthest-first k-centre.

use super::super::field::Field;
use super::super::{Choice, SelectionError};
use super::{Heuristic, farthest_first};

pub(super) const BASELINE: Heuristic = Heuristic {
    name: "baseline",
    summary: "those taken farthest from where the others were",
    choose,
};

fn choose(field: &Field<'_>) -> Result<Vec<Choice>, SelectionError> {
    let centre =
        |group| field.wanted_images(group).next().map(|image| field.candidates.centre(image));
    let centres: Vec<_> = (0..field.groups.len()).filter_map(centre).collect();
    farthest_first(
        field,
        |one, other| (centres[one] - centres[other]).norm(),
        |gain| format!("taken {:.1} % of the scene's size away from the nearest", 100.0 * gain),
    )
}
