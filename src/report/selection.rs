//! Which images were chosen, and why.

use super::number;
use super::table::{Cell, Table};
use crate::selection::{Candidates, Choice};

/// A line for each choice, in order, and what all of them tell of the lenses together.
pub fn selection_text(candidates: &Candidates, choices: &[Choice]) -> String {
    let row = |choice: &Choice| -> Vec<Cell> {
        let named = |name: &dyn Fn(usize) -> String| {
            choice.images.iter().map(|&image| name(image)).collect::<Vec<_>>().join(", ")
        };
        let names = named(&|image| candidates.name(image).to_owned());
        let cameras = match candidates.cameras() {
            [_] => String::new(),
            _ => named(&|image| candidates.camera(image).to_string()),
        };
        vec![names.into(), cameras.into(), choice.reason.as_str().into()]
    };
    let table = Table {
        text_columns: 3,
        header: ["image", "camera", "why"].map(str::to_owned).to_vec(),
        rows: choices.iter().map(row).collect(),
        ..Table::default()
    };
    table.without_empty_columns().text() + &expected(candidates, choices)
}

/// What the images tell of each lens.
fn expected(candidates: &Candidates, choices: &[Choice]) -> String {
    let images: Vec<usize> = choices.iter().flat_map(|it| it.images.iter().copied()).collect();
    let information = candidates.information(&images);
    let mut seen: Vec<_> = images.iter().map(|&image| candidates.camera(image)).collect();
    seen.sort_unstable();
    seen.dedup();
    let line = |camera| match candidates.mapping_error(&information, &[camera]) {
        Some(squared) => format!(
            "camera {camera}: an expected error of {} px over the image for each px of noise, poses and points free\n",
            number::std(squared.sqrt())
        ),
        None => format!(
            "camera {camera}: these images leave a direction of its intrinsics open: choose more, or free fewer parameters\n"
        ),
    };
    seen.into_iter().map(line).collect()
}
