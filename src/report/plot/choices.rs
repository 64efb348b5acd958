//! What was chosen from one model at one size: what the figures of an experiment show, one at a time.

use crate::selection::experiment::{Cell, ModelRecord, Sample, Selection};

/// A model of an experiment, and how many were chosen.
#[derive(Debug, Clone, Copy)]
pub struct Choices<'a> {
    pub selection: &'a Selection,
    /// The model's place among the models.
    pub at: usize,
    pub model: &'a ModelRecord,
    pub size: usize,
}

impl<'a> Choices<'a> {
    /// Of all models and sizes.
    pub fn all(selection: &'a Selection) -> Vec<Self> {
        let of_model = |(at, model): (usize, &'a ModelRecord)| {
            let of_size = move |&size| Self { selection, at, model, size };
            model.sizes.iter().map(of_size)
        };
        selection.models.iter().enumerate().flat_map(of_model).collect()
    }

    /// Words that tell the model from others, where there are others.
    pub fn of_model(&self) -> String {
        let Self { selection, model, .. } = self;
        if selection.models.len() > 1 { format!("{}: ", model.name) } else { String::new() }
    }

    /// What a file's name begins with.
    pub fn stem(&self) -> String {
        let Self { selection, at, size, .. } = self;
        let model =
            if selection.models.len() > 1 { format!("model-{}-", at + 1) } else { String::new() };
        format!("{model}size-{size}")
    }

    /// A cell for each heuristic that has one.
    pub fn cells(&self) -> impl Iterator<Item = &'a Cell> + use<'a> {
        let Self { selection, at, size, .. } = *self;
        selection.cells.iter().filter(move |cell| cell.model == at && cell.size == size)
    }

    /// What a heuristic chose.
    pub fn samples(&self, heuristic: &'a str) -> impl Iterator<Item = &'a Sample> + use<'a> {
        let Self { selection, at, size, .. } = *self;
        let samples = selection.samples.iter().map(|scored| &scored.sample);
        samples.filter(move |it| {
            it.draw.model == at && it.draw.size == size && it.heuristic == heuristic
        })
    }
}
