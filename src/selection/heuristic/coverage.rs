//! Images whose points fill the image plane evenly.

use std::collections::BTreeMap;

use super::super::field::Field;
use super::super::growth::Growth;
use super::super::{Choice, SelectionError};
use super::Heuristic;

pub(super) const COVERAGE: Heuristic = Heuristic {
    name: "coverage",
    summary: "those with points in parts of the image plane where the others have few",
    choose,
};

fn choose(field: &Field<'_>) -> Result<Vec<Choice>, SelectionError> {
    let mut filled: BTreeMap<(u32, usize), usize> = BTreeMap::new();
    let mut done = 0;
    let cells = |group: usize| {
        field.wanted_images(group).flat_map(|image| {
            let camera = field.candidates.camera(image).0;
            field.candidates.cells_of[image].iter().map(move |&cell| (camera, cell))
        })
    };
    Growth::by_score(
        field,
        |growth, group| {
            while let Some(&last) = growth.chosen.get(done) {
                cells(last).for_each(|cell| *filled.entry(cell).or_default() += 1);
                done += 1;
            }
            // The first image in a part of the plane counts 1, the second a half, ...
            let worth = |cell| 1.0 / (1 + filled.get(&cell).copied().unwrap_or(0)) as f64;
            cells(group).map(worth).sum()
        },
        |_, _, gain| format!("fills the image plane by {gain:.2} parts more"),
    )
}
