//! The heuristics: one file each, and one line in the list.

mod baseline;
mod coverage;
mod covisibility;
mod d_optimal;
mod directions;
mod growing_error;
mod mapping_error;
mod most_observations;
mod random;
mod stride;
mod window;

pub use mapping_error::elimination_order;

use super::field::Field;
use super::growth::Growth;
use super::{Candidates, Choice, Request, SelectionError};

/// A rule that chooses images. Same request, same choices; they hang together and show every wanted camera.
#[derive(Debug)]
pub struct Heuristic {
    /// What it is called.
    pub name: &'static str,
    /// What it does, in a line.
    pub summary: &'static str,
    pub(super) choose: fn(&Field<'_>) -> Result<Vec<Choice>, SelectionError>,
}

/// All of them, simple ones first.
pub const HEURISTICS: &[Heuristic] = &[
    window::WINDOW,
    stride::STRIDE,
    RANDOM,
    most_observations::MOST_OBSERVATIONS,
    coverage::COVERAGE,
    directions::DIRECTIONS,
    baseline::BASELINE,
    covisibility::COVISIBILITY,
    d_optimal::D_OPTIMAL,
    growing_error::GROWING_ERROR,
    mapping_error::MAPPING_ERROR,
];

/// By chance: what others must beat.
pub const RANDOM: Heuristic = random::RANDOM;

/// The one that is taken when none is asked for.
pub const RECOMMENDED: &str = "growing-error";

impl Heuristic {
    /// The one of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        HEURISTICS.iter().find(|it| it.name == name)
    }

    /// Chooses.
    pub fn choose(
        &self,
        candidates: &Candidates,
        request: &Request<'_>,
    ) -> Result<Vec<Choice>, SelectionError> {
        (self.choose)(&Field::new(candidates, request)?)
    }
}

/// The first choice of those that go by distance: what sees most. Then the farthest from all that are chosen.
fn farthest_first(
    field: &Field<'_>,
    distance: impl Fn(usize, usize) -> f64,
    words: impl Fn(f64) -> String,
) -> Result<Vec<Choice>, SelectionError> {
    let mut nearest = vec![f64::INFINITY; field.groups.len()];
    let mut done = 0;
    Growth::by_score(
        field,
        |growth, group| {
            if growth.chosen.is_empty() {
                return field.groups[group].points.len() as f64;
            }
            while let Some(&last) = growth.chosen.get(done) {
                for (other, least) in nearest.iter_mut().enumerate() {
                    *least = least.min(distance(last, other));
                }
                done += 1;
            }
            nearest[group]
        },
        |growth, _, gain| match growth.chosen.is_empty() {
            true => format!("sees the most points, {gain}"),
            false => words(gain),
        },
    )
}
