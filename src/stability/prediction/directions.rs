//! The covariance taken apart by what it does in the image.

use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::Serialize;

/// A change of all parameters together that is as likely as one std of one, and independent of the other directions.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Direction {
    /// The changes, in the parameters' own units.
    pub changes: Vec<f64>,
    /// How far they move the image after turning it back: RMS over the cells, in px.
    pub moves_px: f64,
}

/// With Sigma = L L^T and H the mean over the cells of G^T G: L times the eigenvectors of L^T H L. The squares of what they move
/// add up to the expected mapping error. From the one that moves the image most to the one that moves it least.
pub(super) fn directions(
    covariance: &DMatrix<f64>,
    effect: &DMatrix<f64>,
) -> Option<Vec<Direction>> {
    let scales = covariance.diagonal().map(f64::sqrt);
    let count = scales.len();
    let scaled = DMatrix::from_fn(count, count, |row, column| {
        covariance[(row, column)] / (scales[row] * scales[column])
    });
    let root = scaled.cholesky()?.unpack();
    let root = DMatrix::from_fn(count, count, |row, column| scales[row] * root[(row, column)]);
    let carried = effect * &root;
    let eigen = (carried.tr_mul(&carried) / (effect.nrows() as f64 / 2.0)).symmetric_eigen();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let direction = |&at: &usize| {
        let changes: DVector<f64> = &root * eigen.eigenvectors.column(at);
        // A direction has two ends: the one in which its largest part grows.
        let largest = changes.component_div(&scales).iamax();
        let sign = changes[largest].signum();
        Direction {
            changes: changes.iter().map(|change| sign * change).collect(),
            moves_px: eigen.eigenvalues[at].max(0.0).sqrt(),
        }
    };
    Some(order.iter().map(direction).collect())
}
