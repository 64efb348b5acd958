//! D-optimal greedy: the image that adds most to the log determinant of the information, points held.
//!
//! Points held, information adds up and the gain of an image only falls: old gains are bounds, and few are computed anew
//! (M. Minoux, Accelerated Greedy Algorithms, 1978).

use nalgebra::DMatrix;

use super::super::field::Field;
use super::super::growth::Growth;
use super::super::information::log_det;
use super::super::{Choice, SelectionError};
use super::Heuristic;

pub(super) const D_OPTIMAL: Heuristic = Heuristic {
    name: "d-optimal",
    summary: "those that add most to what is known of the intrinsics, were points known",
    choose: |field| Ok(greedy(field, true)?.into_iter().map(|(choice, _)| choice).collect()),
};

/// What is known of each wanted camera so far, and its log determinant.
struct Known<'a> {
    field: &'a Field<'a>,
    cameras: Vec<(DMatrix<f64>, f64)>,
}

/// The choices in order, with their groups; without laziness every gain is computed in every step.
pub(super) fn greedy(
    field: &Field<'_>,
    is_lazy: bool,
) -> Result<Vec<(Choice, usize)>, SelectionError> {
    /// Of the gain: what rounding may lift a gain above its bound.
    const SLACK: f64 = 1e-9;
    let mut known = Known::new(field);
    let mut growth = Growth::new(field);
    let mut bounds = vec![f64::INFINITY; field.groups.len()];
    let mut choices = Vec::with_capacity(field.size);
    while choices.len() < field.size {
        let mut allowed = growth.allowed()?;
        allowed.sort_by(|&a, &b| bounds[b].total_cmp(&bounds[a]).then(a.cmp(&b)));
        let mut best: Option<(f64, usize)> = None;
        for group in allowed {
            if let Some((most, _)) = best
                && is_lazy
                && bounds[group] < most - SLACK * most.abs()
            {
                break;
            }
            let gain = known.gain(group);
            bounds[group] = gain;
            let is_better =
                |(most, first): (f64, usize)| gain.total_cmp(&most).then(first.cmp(&group)).is_gt();
            if best.is_none_or(is_better) {
                best = Some((gain, group));
            }
        }
        let Some((gain, group)) = best else { break };
        let reason = format!("adds {gain:.3} to the log determinant of the information");
        let images = field.groups[group].images.clone();
        choices.push((Choice { images, gain, reason }, group));
        known.add(group);
        growth.add(group);
    }
    Ok(choices)
}

impl<'a> Known<'a> {
    fn new(field: &'a Field<'a>) -> Self {
        let prior = |id| {
            let share = field.candidates.share_of(id);
            let weights = share.map(|param| field.candidates.prior_std(param).powi(-2));
            let matrix = DMatrix::from_diagonal(&weights.collect::<Vec<_>>().into());
            let start = log_det(&matrix).unwrap_or(f64::NEG_INFINITY);
            (matrix, start)
        };
        Self { field, cameras: field.wanted.iter().map(|&id| prior(id)).collect() }
    }

    /// What it would be with a group more, camera by camera.
    fn with(&self, group: usize) -> Vec<(usize, DMatrix<f64>)> {
        let candidates = self.field.candidates;
        let mut sums: Vec<(usize, DMatrix<f64>)> = Vec::new();
        for image in self.field.wanted_images(group) {
            let Ok(camera) = self.field.wanted.binary_search(&candidates.camera(image)) else {
                continue;
            };
            let own = candidates.own_information(image);
            match sums.iter_mut().find(|(other, _)| *other == camera) {
                Some((_, sum)) => *sum += own,
                None => sums.push((camera, &self.cameras[camera].0 + own)),
            }
        }
        sums
    }

    fn gain(&self, group: usize) -> f64 {
        let gain = |(camera, sum): &(usize, DMatrix<f64>)| {
            log_det(sum).map_or(f64::NEG_INFINITY, |after| after - self.cameras[*camera].1)
        };
        self.with(group).iter().map(gain).sum()
    }

    fn add(&mut self, group: usize) {
        for (camera, sum) in self.with(group) {
            let after = log_det(&sum).unwrap_or(f64::NEG_INFINITY);
            self.cameras[camera] = (sum, after);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::tests::{candidates, scene};
    use super::super::super::{Request, Unit};
    use super::*;

    #[test]
    fn lazy_greedy_chooses_what_greedy_chooses_bit_for_bit() {
        let mut count = 0;
        for (cameras, images) in [(1, 30), (3, 30), (2, 17)] {
            let candidates = candidates(&scene(cameras, images, 80));
            let pool: Vec<usize> = (0..candidates.image_count()).collect();
            let request =
                Request { pool: &pool, size: 12, seed: 0, unit: Unit::Image, camera: None };
            let field = Field::new(&candidates, &request).unwrap();
            let [lazy, eager] = [true, false].map(|is_lazy| greedy(&field, is_lazy).unwrap());
            assert_eq!(lazy, eager);
            count += lazy.len();
        }
        assert_eq!(count, 36);
    }
}
