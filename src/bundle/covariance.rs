//! How well the intrinsics are determined: their covariance, and the directions that the observations leave open.
//!
//! Sigma = sigma^2 Lambda^-1, Lambda the intrinsics' Schur complement after points and poses; no gauge enters it.

use nalgebra::DMatrix;

use super::schur::{Information, Layout};
use crate::scene::CameraId;

/// An eigenvalue of the scaled information below this share of the largest is rounding: that direction is open.
const OPEN: f64 = 1e-10;
/// A parameter that, changed by its whole size or by 1, moves pixels by less than this, in px, changes nothing but rounding.
const UNSEEN_PX: f64 = 1e-9;
/// Parameters that have less than this share in an open direction are not named.
const SMALL_SHARE: f64 = 0.1;

/// A free parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FreeParam {
    /// Its camera.
    pub camera: CameraId,
    /// Its place among that camera's parameters.
    pub place: usize,
    /// Its name.
    pub name: &'static str,
}

/// How well the intrinsics are determined.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    /// The parameters that moved, camera by camera: the order of rows and columns.
    pub params: Vec<FreeParam>,
    /// Their covariance, in their own units; none while a direction is open.
    pub matrix: Option<Vec<Vec<f64>>>,
    /// Directions that the observations leave open.
    pub open: Vec<OpenDirection>,
}

/// A change of intrinsics that the observations do not notice.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenDirection {
    /// The parameters that take part, as indices of `Covariance::params`, with their changes relative to each other, in their own units.
    pub changes: Vec<(usize, f64)>,
}

impl Covariance {
    /// From the information of so many residuals, for variance one; `values` are those of the parameters.
    pub(super) fn new(
        params: Vec<FreeParam>,
        values: &[f64],
        residuals: usize,
        layout: &Layout,
        information: &Information,
    ) -> Self {
        // The border's unknowns less those that fill it up.
        let border = layout.poses..layout.size;
        let places: Vec<usize> =
            border.filter(|&at| !layout.held[at]).map(|at| at - layout.poses).collect();
        let scales: Vec<f64> = places.iter().map(|&at| information.scales[at]).collect();
        let value = |row: usize, column: usize| {
            let (row, column) = (places[row].max(places[column]), places[row].min(places[column]));
            information.rows[row][column]
        };
        // What no observation depends on has a scale of zero; it is open by itself, as is what moves no pixel.
        let root = (residuals as f64).sqrt();
        let moves = |&at: &usize| {
            scales[at] > 0.0 && values[at].abs().max(1.0) > UNSEEN_PX * root * scales[at]
        };
        let is_seen: Vec<usize> = (0..places.len()).filter(moves).collect();
        let mut open: Vec<OpenDirection> = (0..places.len())
            .filter(|at| !moves(at))
            .map(|at| OpenDirection { changes: vec![(at, 1.0)] })
            .collect();
        let scaled = DMatrix::from_fn(is_seen.len(), is_seen.len(), |row, column| {
            value(is_seen[row], is_seen[column])
        });
        if is_seen.is_empty() || !scaled.iter().all(|value| value.is_finite()) {
            // Nothing to decompose; numbers that overflowed tell of no direction.
            open.extend(is_seen.iter().map(|&at| OpenDirection { changes: vec![(at, 1.0)] }));
            return Self { params, matrix: open.is_empty().then(Vec::new), open };
        }
        let eigen = scaled.symmetric_eigen();
        let largest = eigen.eigenvalues.iter().fold(0.0, |most: f64, &value| most.max(value));
        let inverse = |value: f64| 1.0 / value;
        for (at, &value) in eigen.eigenvalues.iter().enumerate() {
            // Not a number is open too.
            if value > OPEN * largest {
                continue;
            }
            let vector = eigen.eigenvectors.column(at);
            let most = vector.amax();
            let parts =
                vector.iter().zip(&is_seen).filter(|(part, _)| part.abs() >= SMALL_SHARE * most);
            let changes = parts.map(|(part, &param)| (param, part * scales[param])).collect();
            open.push(OpenDirection { changes });
        }
        let matrix = open.is_empty().then(|| {
            let inverted = &eigen.eigenvectors
                * DMatrix::from_diagonal(&eigen.eigenvalues.map(inverse))
                * eigen.eigenvectors.transpose();
            let entry = |row: usize, column: usize| {
                0.5 * scales[row]
                    * scales[column]
                    * (inverted[(row, column)] + inverted[(column, row)])
            };
            let row = |row: usize| (0..places.len()).map(|column| entry(row, column)).collect();
            (0..places.len()).map(row).collect()
        });
        Self { params, matrix, open }
    }

    /// How many parameters the priors determine: the trace of H^-1 P.
    pub(super) fn share_of_priors(&self, weights: &[f64]) -> f64 {
        let rows = self.matrix.iter().flatten().enumerate();
        rows.map(|(at, row)| row[at] * weights[at]).sum()
    }

    /// For residuals of this variance; without one nothing is known. Priors of these weights P are part of the information H, but
    /// their variance is what they say: Sigma = H^-1 (variance (H - P) + P) H^-1.
    pub(super) fn scale(&mut self, variance: Option<f64>, weights: &[f64]) {
        if let Some((matrix, variance)) = self.matrix.as_mut().zip(variance) {
            let plain = matrix.clone();
            for (row, of_row) in matrix.iter_mut().zip(&plain) {
                for (entry, of_column) in row.iter_mut().zip(&plain) {
                    let through = of_row.iter().zip(of_column).zip(weights);
                    let by_priors: f64 = through.map(|((a, b), weight)| a * weight * b).sum();
                    *entry += (1.0 / variance - 1.0) * by_priors;
                }
            }
        }
        self.matrix = self.matrix.take().zip(variance).map(|(mut matrix, variance)| {
            matrix.iter_mut().flatten().for_each(|entry| *entry *= variance);
            matrix
        });
    }

    /// Standard deviations, in the order of the parameters.
    pub fn stds(&self) -> Option<Vec<f64>> {
        let matrix = self.matrix.as_ref()?;
        Some(matrix.iter().enumerate().map(|(at, row)| row[at].sqrt()).collect())
    }

    /// The correlation of two parameters.
    pub fn correlation(&self, one: usize, other: usize) -> Option<f64> {
        let matrix = self.matrix.as_ref()?;
        Some(matrix[one][other] / (matrix[one][one] * matrix[other][other]).sqrt())
    }

    /// An open direction in words: `fx +1 with k1 -0.0002`.
    pub fn words(&self, direction: &OpenDirection) -> String {
        let several = self.params.iter().any(|param| param.camera != self.params[0].camera);
        let unit = direction.changes.first().map_or(1.0, |(_, change)| *change);
        let part = |&(at, change): &(usize, f64)| {
            let FreeParam { camera, name, .. } = self.params[at];
            let camera = if several { format!("camera {camera} ") } else { String::new() };
            format!("{camera}{name} {}", three_digits(change / unit))
        };
        direction.changes.iter().map(part).collect::<Vec<_>>().join(" with ")
    }
}

/// A signed number of three significant digits, however small.
fn three_digits(value: f64) -> String {
    let short = format!("{value:.2e}").parse::<f64>();
    short.map_or_else(|_| value.to_string(), |short| format!("{short:+}"))
}
