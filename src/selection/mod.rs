//! Which images calibrate a camera best: heuristics that choose some, and what any subset tells of the intrinsics.
//!
//! A heuristic is one file in `heuristic/` and one line in `HEURISTICS`. Knows nothing of files.

mod assembly;
mod candidates;
mod error;
pub mod experiment;
mod field;
mod growth;
mod heuristic;
mod information;
mod mapping;
#[cfg(test)]
mod tests;

pub use candidates::{Candidates, SIGMA_PX};
pub use error::SelectionError;
pub use heuristic::{HEURISTICS, Heuristic, RANDOM, RECOMMENDED, elimination_order};
pub use information::Information;

use crate::scene::CameraId;

/// What is asked of a heuristic.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The images from which it may choose, by their places in `Candidates`, ascending.
    pub pool: &'a [usize],
    /// How many it is to choose: images, or frames.
    pub size: usize,
    /// What chance, where a heuristic leaves anything to it, is drawn from.
    pub seed: u64,
    /// What is chosen at a time.
    pub unit: Unit,
    /// The camera whose intrinsics are wanted; all of the pool's if none. Images of others are chosen only as parts of frames.
    pub camera: Option<CameraId>,
}

/// What is chosen at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// An image.
    #[default]
    Image,
    /// All images in the pool that a rig took at once.
    Frame,
}

/// What was chosen at a time, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The places of the images in `Candidates`: one, or those of a frame.
    pub images: Vec<usize>,
    /// By how much it was better to take it than not, in the heuristic's own unit.
    pub gain: f64,
    /// The same in words.
    pub reason: String,
}
