//! The least expected mapping error, poses and points free: exact, by leaving out one after the other, and by exchanges.
//!
//! A. Hagemann, M. Knorr, H. Janssen, C. Stiller, Inferring Bias and Uncertainty in Camera Calibration, IJCV 2022. One image alone
//! tells nothing of a focal length, so that nothing can be built up from one: elimination starts from all.

use rayon::prelude::*;

use super::super::assembly::System;
use super::super::field::Field;
use super::super::{Candidates, Choice, Request, SelectionError};
use super::{Heuristic, d_optimal};

pub(super) const MAPPING_ERROR: Heuristic = Heuristic {
    name: "mapping-error",
    summary: "those that leave the least expected error of the lens over the image: exact, and slow",
    choose,
};

/// With more images than this an elimination takes minutes.
const MOST_IMAGES: usize = 100;
/// An exchange that gains less than this share is rounding.
const LEAST_GAIN: f64 = 1e-9;

fn choose(field: &Field<'_>) -> Result<Vec<Choice>, SelectionError> {
    let size = field.groups.iter().map(|group| group.images.len()).sum();
    if size > MOST_IMAGES {
        return Err(SelectionError::TooLarge { size, most: MOST_IMAGES });
    }
    let greedy: Vec<usize> =
        d_optimal::greedy(field, true)?.into_iter().map(|(_, group)| group).collect();
    let starts = [Some(greedy), eliminate(field)?];
    let polished = starts.into_iter().flatten().filter_map(|start| polish(field, start));
    let best =
        polished.reduce(|one, other| if other.error_px < one.error_px { other } else { one });
    let best = best.ok_or(SelectionError::Undetermined(size))?;
    Ok(best.choices(field))
}

/// Some groups, ascending, and their expected mapping error.
#[derive(Debug, Clone)]
struct Chosen {
    groups: Vec<usize>,
    error_px: f64,
}

/// The images that go, in order, when again and again those go whose loss leaves the least expected mapping error, until so many
/// images or frames are left as are asked for. It ends early where nothing more can go.
pub fn elimination_order(
    candidates: &Candidates,
    request: &Request<'_>,
) -> Result<Vec<Vec<usize>>, SelectionError> {
    let field = Field::new(candidates, request)?;
    let order = eliminated(&field)?;
    Ok(order.into_iter().map(|group| field.groups[group].images.clone()).collect())
}

fn eliminated(field: &Field<'_>) -> Result<Vec<usize>, SelectionError> {
    let mut left: Vec<usize> = (0..field.groups.len()).collect();
    let all = field.images_of(&left);
    if error_px(field, System::new(field.candidates, &all)).is_none() {
        return Err(SelectionError::Undetermined(all.len()));
    }
    let mut order = Vec::new();
    while left.len() > field.size {
        let system = System::new(field.candidates, &field.images_of(&left));
        let errors: Vec<Option<f64>> =
            left.par_iter().map(|&out| error_without(field, &system, &left, out)).collect();
        let Some((at, _)) = least(&errors) else { break };
        order.push(left.remove(at));
    }
    Ok(order)
}

/// What elimination leaves; none where it ended early.
fn eliminate(field: &Field<'_>) -> Result<Option<Vec<usize>>, SelectionError> {
    let order = eliminated(field)?;
    let left = (0..field.groups.len()).filter(|group| !order.contains(group)).collect::<Vec<_>>();
    Ok((left.len() == field.size).then_some(left))
}

/// The best of all exchanges of one for one, until none gains.
fn polish(field: &Field<'_>, mut groups: Vec<usize>) -> Option<Chosen> {
    let widest = field.groups.iter().map(|group| group.images.len()).max()?;
    loop {
        groups.sort_unstable();
        let system = System::with_room(field.candidates, &field.images_of(&groups), widest);
        let now = error_px(field, system.clone())?;
        let others = (0..field.groups.len()).filter(|group| !groups.contains(group));
        let pairs: Vec<(usize, usize)> =
            others.flat_map(|into| (0..groups.len()).map(move |out| (out, into))).collect();
        // Each leaves once, for all that may enter: of what remains only the points of that one change.
        let without: Vec<System<'_>> = groups
            .par_iter()
            .map(|&out| system.exchanged(&field.groups[out].images, &[]))
            .collect();
        let errors: Vec<Option<f64>> = pairs
            .par_iter()
            .map(|&(out, into)| {
                let mut changed = groups.clone();
                changed[out] = into;
                field.is_sound(&changed).then_some(())?;
                error_px(field, without[out].exchanged(&[], &field.groups[into].images))
            })
            .collect();
        match least(&errors) {
            Some((at, error)) if error < now * (1.0 - LEAST_GAIN) => {
                groups[pairs[at].0] = pairs[at].1;
            }
            _ => return Some(Chosen { groups, error_px: now }),
        }
    }
}

impl Chosen {
    fn choices(&self, field: &Field<'_>) -> Vec<Choice> {
        let system = System::new(field.candidates, &field.images_of(&self.groups));
        let choice = |&group: &usize| {
            let images = field.groups[group].images.clone();
            let now = self.error_px;
            let error = error_px(field, system.exchanged(&images, &[]));
            let (gain, reason) = match error {
                Some(error) => {
                    let words = format!(
                        "without it the expected mapping error is {error:.3} px, not {now:.3}"
                    );
                    (error - now, words)
                }
                None => {
                    (f64::INFINITY, "without it a direction of the intrinsics is open".to_owned())
                }
            };
            Choice { images, gain, reason }
        };
        let mut choices: Vec<Choice> = self.groups.par_iter().map(choice).collect();
        choices.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        choices
    }
}

fn error_without(
    field: &Field<'_>,
    system: &System<'_>,
    groups: &[usize],
    out: usize,
) -> Option<f64> {
    let left: Vec<usize> = groups.iter().copied().filter(|&group| group != out).collect();
    field.is_sound(&left).then_some(())?;
    error_px(field, system.exchanged(&field.groups[out].images, &[]))
}

/// The root of the expected mapping error, in px.
fn error_px(field: &Field<'_>, system: System<'_>) -> Option<f64> {
    let information = system.information();
    Some(field.candidates.mapping_error(&information, &field.wanted)?.sqrt())
}

/// The least of those that are, and the first of these.
fn least(errors: &[Option<f64>]) -> Option<(usize, f64)> {
    let known = errors.iter().enumerate().filter_map(|(at, error)| Some((at, (*error)?)));
    known.reduce(|one, other| if other.1 < one.1 { other } else { one })
}
