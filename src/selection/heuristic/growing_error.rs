//! The least expected mapping error, poses and points free, built up image by image: near the exact choice at a small part of its cost.
//!
//! A prior makes the first steps, of which no information tells anything, well defined, as in the D-optimal greedy. Points held,
//! an image that shares nothing would count in full; here it counts by what it adds to those chosen.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::super::assembly::System;
use super::super::field::Field;
use super::super::growth::Growth;
use super::super::information::Information;
use super::super::{Choice, SelectionError};
use super::Heuristic;
use super::covisibility::partner_count;

pub(super) const GROWING_ERROR: Heuristic = Heuristic {
    name: "growing-error",
    summary: "those that leave the least expected error of the lens, one added after the other: nearly exact, and fast",
    choose,
};

/// So many are tried in a step: those that share the most points with the ones chosen.
const MOST_TRIED: usize = 60;

fn choose(field: &Field<'_>) -> Result<Vec<Choice>, SelectionError> {
    let mut growth = Growth::new(field);
    let mut choices = Vec::with_capacity(field.size);
    let prior = prior(field);
    let widest = field.groups.iter().map(|group| group.images.len()).max().unwrap_or(0);
    while choices.len() < field.size {
        let mut tried = growth.allowed()?;
        let is_first = growth.chosen.is_empty();
        let share = |group: usize| match is_first {
            true => partner_count(field, group),
            false => growth.shared(group),
        };
        tried.sort_by_key(|&group| (std::cmp::Reverse(share(group)), group));
        tried.truncate(if is_first { 1 } else { MOST_TRIED });
        let images = field.images_of(&growth.chosen);
        let system = System::with_room(field.candidates, &images, widest);
        let now = error_px(field, system.clone(), &prior);
        let errors: Vec<Option<f64>> = tried
            .par_iter()
            .map(|&group| {
                let grown = system.exchanged(&[], &field.groups[group].images);
                error_px(field, grown, &prior)
            })
            .collect();
        let best = errors.iter().zip(&tried).filter_map(|(error, &group)| Some(((*error)?, group)));
        let best = best.reduce(|one, other| if other.0 < one.0 { other } else { one });
        let (Some((error, group)), Some(now)) = (best, now) else { break };
        let reason = match is_first {
            true => format!("others see its points {} times", share(group)),
            false => format!("brings the expected mapping error from {now:.3} px to {error:.3}"),
        };
        let images = field.groups[group].images.clone();
        choices.push(Choice { images, gain: now - error, reason });
        growth.add(group);
    }
    if choices.len() < field.size {
        return Err(SelectionError::Undetermined(field.groups.len()));
    }
    Ok(choices)
}

/// What is known before any image.
fn prior(field: &Field<'_>) -> DMatrix<f64> {
    let weights = (0..field.candidates.params().len())
        .map(|param| field.candidates.prior_std(param).powi(-2))
        .collect::<Vec<_>>();
    DMatrix::from_diagonal(&weights.into())
}

/// The root of the expected mapping error with the prior, in px.
fn error_px(field: &Field<'_>, system: System<'_>, prior: &DMatrix<f64>) -> Option<f64> {
    let information = Information { matrix: system.information().matrix + prior };
    Some(field.candidates.mapping_error(&information, &field.wanted)?.sqrt())
}
