//! Whether runs differ by more than their covariances allow.
//!
//! theta^ = (sum Lambda_r)^-1 sum Lambda_r theta_r, T = sum (theta_r - theta^)^T Lambda_r (theta_r - theta^), Lambda_r = Sigma_r^-1:
//! chi-square with p (n - 1) degrees if the runs are independent and each Sigma_r is right.

use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::Serialize;

use super::super::Overlap;
use super::Estimate;
use crate::stats::chi_square_tail;

/// How much the runs differ, in units of what their covariances predict.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Consistency {
    /// How many runs.
    pub n: usize,
    /// The parameters that all of them estimated.
    pub parameters: Vec<String>,
    /// Their mean over the runs, weighted by the inverse covariances.
    pub weighted_mean: Vec<f64>,
    /// The std of that mean by the covariances, if the runs are independent.
    pub weighted_mean_std: Vec<f64>,
    /// p (n - 1) for p parameters.
    pub degrees: usize,
    /// As the runs are.
    pub found: Ratio,
    /// As independent runs would show it: T over (1 - shared fraction). None where nothing is known of what they share, or too much.
    pub independent: Option<Ratio>,
}

/// A sum of squares beside what is expected of it.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct Ratio {
    /// T: the sum of the squared deviations from the weighted mean, each in its covariance.
    pub statistic: f64,
    /// Probability of so much or more, if the covariances tell all.
    pub p: f64,
    /// sqrt(T / degrees), the Birge ratio: 1 is what the covariances predict.
    pub birge: f64,
}

impl Ratio {
    fn new(statistic: f64, degrees: usize) -> Option<Self> {
        let p = chi_square_tail(statistic, degrees as f64)?;
        Some(Self { statistic, p, birge: (statistic / degrees as f64).sqrt() })
    }
}

/// Of two runs or more that have covariances; none where they estimated nothing in common.
pub(super) fn consistency(
    estimates: &[Estimate],
    overlap: Option<&Overlap>,
) -> Option<Consistency> {
    let first = estimates.first()?;
    let is_common = |place: &&usize| estimates.iter().all(|one| one.free.contains(place));
    let common: Vec<usize> = first.free.iter().filter(is_common).copied().collect();
    if common.is_empty() || estimates.len() < 2 {
        return None;
    }
    let rows: Vec<(DVector<f64>, DMatrix<f64>)> =
        estimates.iter().map(|one| of_common(one, &common)).collect();
    let sum = rows.iter().map(|(_, covariance)| covariance.diagonal()).sum::<DVector<f64>>();
    // Units differ by many orders: everything in units of the mean std, from the first run on.
    let scales = sum.map(|variance| (variance / rows.len() as f64).sqrt());
    let mut weights: Vec<DMatrix<f64>> = Vec::new();
    let mut offsets: Vec<DVector<f64>> = Vec::new();
    for (values, covariance) in &rows {
        let scaled = DMatrix::from_fn(common.len(), common.len(), |row, column| {
            covariance[(row, column)] / (scales[row] * scales[column])
        });
        weights.push(scaled.cholesky()?.inverse());
        offsets.push((values - &rows[0].0).component_div(&scales));
    }
    let total = weights.iter().fold(DMatrix::zeros(common.len(), common.len()), |sum, w| sum + w);
    let right: DVector<f64> =
        weights.iter().zip(&offsets).map(|(weight, offset)| weight * offset).sum();
    let total = total.cholesky()?;
    let mean = total.solve(&right);
    let square = |(weight, offset): (&DMatrix<f64>, &DVector<f64>)| {
        let off = offset - &mean;
        off.dot(&(weight * &off))
    };
    let statistic: f64 = weights.iter().zip(&offsets).map(square).sum();
    let degrees = common.len() * (estimates.len() - 1);
    let independent = overlap.and_then(|overlap| overlap.independent_factor);
    let stds = total.inverse().diagonal().map(f64::sqrt).component_mul(&scales);
    Some(Consistency {
        n: estimates.len(),
        parameters: common.iter().map(|&place| first.names[place].name.to_owned()).collect(),
        weighted_mean: (&rows[0].0 + mean.component_mul(&scales)).iter().copied().collect(),
        weighted_mean_std: stds.iter().copied().collect(),
        degrees,
        found: Ratio::new(statistic, degrees)?,
        independent: independent
            .and_then(|factor| Ratio::new(statistic * factor * factor, degrees)),
    })
}

/// The values and the covariance of some of the parameters.
fn of_common(one: &Estimate, common: &[usize]) -> (DVector<f64>, DMatrix<f64>) {
    let at: Vec<usize> =
        common.iter().filter_map(|place| one.free.iter().position(|free| free == place)).collect();
    let values = DVector::from_iterator(common.len(), common.iter().map(|&p| one.values[p]));
    let pick = |row: usize, column: usize| one.covariance[(at[row], at[column])];
    (values, DMatrix::from_fn(common.len(), common.len(), pick))
}
