//! Whether residuals are of one size: points that fit far worse than most make sigma a mean of two things.
//!
//! The squares of a point's m residual vectors sum to about sigma^2 chi-square with 2 m - 3 degrees, as the point itself takes
//! three: single residuals of short tracks are not normal even where noise is.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use crate::bundle::{Observation, Outcome};
use crate::scene::CameraId;
use crate::stats::{Sorted, chi_square_quantile, chi_square_tail};

/// Of points with normal noise, this share lies beyond.
pub(in crate::stability) const TAIL: f64 = 1e-3;

/// How alike in size the residuals of a camera's points are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Tails {
    /// The points that the camera saw.
    pub points: usize,
    /// The noise of one coordinate by the median of those points, in px: what sigma is without the few that fit worst.
    pub robust_sigma_px: f64,
    /// Sigma of all of these points as a multiple of that.
    pub sigma_ratio: f64,
    /// The share of points that fit worse than 1 in 1000 would with normal noise of the robust sigma.
    pub beyond_share: f64,
    /// Probability of so many of them or more with normal noise.
    pub p: f64,
}

/// The residuals of a run, point by point.
pub(in super::super) struct Tracks {
    /// The sum of squares of each point, and how many observations it has.
    sums: Vec<(f64, usize)>,
    /// What poses and intrinsics leave of the freedom that the points leave.
    share: f64,
    taken: usize,
}

impl Tracks {
    pub fn new(outcome: &Outcome, observations: &[Observation], moves_points: bool) -> Self {
        let count = observations.iter().map(|seen| seen.track + 1).max().unwrap_or(0);
        let mut sums: Vec<(f64, usize)> = vec![(0.0, 0); count];
        for seen in observations {
            let (sum, count) = &mut sums[seen.track];
            *sum += seen.residual[0].powi(2) + seen.residual[1].powi(2);
            *count += 1;
        }
        let taken = if moves_points { 3 } else { 0 };
        let left: usize = sums.iter().map(|(_, count)| (2 * count).saturating_sub(taken)).sum();
        let freedom = (2 * outcome.observations).saturating_sub(outcome.rank);
        Self { sums, share: freedom as f64 / left.max(1) as f64, taken }
    }

    fn freedom(&self, count: usize) -> usize {
        (2 * count).saturating_sub(self.taken)
    }

    /// The sum of squares of one camera's residuals, and how many of these are free: of each point an equal share.
    pub fn of_camera(&self, observations: &[Observation], camera: CameraId) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for seen in observations.iter().filter(|seen| seen.camera == camera) {
            let count = self.sums[seen.track].1;
            sums[0] += seen.residual[0].powi(2) + seen.residual[1].powi(2);
            sums[1] += self.share * self.freedom(count) as f64 / count as f64;
        }
        sums
    }

    /// Of the points that a camera saw.
    pub fn tails(&self, observations: &[Observation], camera: CameraId) -> Option<Tails> {
        let of_camera = observations.iter().filter(|seen| seen.camera == camera);
        let mut seen: Vec<usize> = of_camera.map(|seen| seen.track).collect();
        seen.sort_unstable();
        seen.dedup();
        let points: Vec<(f64, usize)> = seen
            .into_iter()
            .map(|track| (self.sums[track].0 / self.share, self.freedom(self.sums[track].1)))
            .filter(|(_, degrees)| *degrees > 0)
            .collect();
        let mut quantiles: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        for &(_, degrees) in &points {
            if let std::collections::btree_map::Entry::Vacant(entry) = quantiles.entry(degrees) {
                let quantile = |p| chi_square_quantile(p, degrees as f64);
                entry.insert([quantile(0.5)?, quantile(1.0 - TAIL)?]);
            }
        }
        let by_median = points.iter().map(|(sum, degrees)| sum / quantiles[degrees][0]).collect();
        let robust = Sorted::new(by_median)?.median();
        let sum: f64 = points.iter().map(|(sum, _)| sum).sum();
        let degrees: usize = points.iter().map(|(_, degrees)| degrees).sum();
        let is_beyond = |(sum, degrees): &&(f64, usize)| *sum > robust * quantiles[degrees][1];
        let beyond = points.iter().filter(is_beyond).count();
        (robust > 0.0).then(|| Tails {
            points: points.len(),
            robust_sigma_px: robust.sqrt(),
            sigma_ratio: (sum / degrees as f64 / robust).sqrt(),
            beyond_share: beyond as f64 / points.len() as f64,
            p: at_least(beyond, TAIL * points.len() as f64),
        })
    }
}

/// Probability that a Poisson variable of this mean is so large or larger.
fn at_least(count: usize, mean: f64) -> f64 {
    // It is below as long as chi-square with twice as many degrees exceeds twice the mean.
    let below = chi_square_tail(2.0 * mean, 2.0 * count as f64);
    below.map_or(1.0, |below| 1.0 - below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_poissons() {
        // 1 - e^-m, 1 - e^-m (1 + m)
        let m = 0.7_f64;
        assert!((at_least(0, m) - 1.0).abs() < 1e-15);
        assert!((at_least(1, m) - (1.0 - (-m).exp())).abs() < 1e-12);
        assert!((at_least(2, m) - (1.0 - (-m).exp() * (1.0 + m))).abs() < 1e-12);
    }
}
