//! How well the intrinsics are determined: their covariance, and the directions that the observations leave open.
//!
//! All of it is made of Lambda, the intrinsics' Schur complement after points and poses; no gauge enters it.

use nalgebra::linalg::SymmetricEigen;
use nalgebra::{DMatrix, DVector, Dyn};

use super::clustered::Clustered;
use super::schur::{Information, Layout};
use crate::scene::CameraId;

/// An eigenvalue of the scaled information below this share of the largest is rounding: that direction is open.
const OPEN: f64 = 1e-10;
/// So is one below this share of what the parameters have before poses and points are eliminated: where all directions are open,
/// the largest is rounding too.
const ROUNDING: f64 = 1e-12;
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
    /// Their covariance, in their own units. None while a direction is open, when no residual is left over, or when a robust loss
    /// has no minimum at the end.
    pub matrix: Option<Vec<Vec<f64>>>,
    /// The same if the errors of one image depend on each other, for each camera with images enough to tell.
    pub clustered: Vec<Clustered>,
    /// Directions that the observations leave open.
    pub open: Vec<OpenDirection>,
}

/// A change of intrinsics that the observations do not notice.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenDirection {
    /// The parameters that take part, as indices of `Covariance::params`, with their changes relative to each other, in their own units.
    pub changes: Vec<(usize, f64)>,
}

/// The Schur complement of the parameters that move, after points and poses.
#[derive(Debug, Clone)]
pub(super) struct Lambda {
    /// With columns scaled.
    scaled: DMatrix<f64>,
    scales: DVector<f64>,
}

impl Lambda {
    /// Without the border's unknowns that stay, and those that fill it up.
    pub(super) fn new(layout: &Layout, information: &Information) -> Self {
        let border = layout.poses..layout.size;
        let places: Vec<usize> =
            border.filter(|&at| !layout.held[at]).map(|at| at - layout.poses).collect();
        let value = |row: usize, column: usize| {
            let (row, column) = (places[row].max(places[column]), places[row].min(places[column]));
            information.rows[row][column]
        };
        let scales = places.iter().map(|&at| information.scales[at]);
        Self {
            scaled: DMatrix::from_fn(places.len(), places.len(), value),
            scales: DVector::from_iterator(places.len(), scales),
        }
    }

    /// In the parameters' own units.
    pub(super) fn matrix(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.scales.len(), self.scales.len(), |row, column| {
            self.scaled[(row, column)] / (self.scales[row] * self.scales[column])
        })
    }

    /// Its inverse; none unless it is positive definite beyond rounding.
    pub(super) fn inverse(&self) -> Option<DMatrix<f64>> {
        if self.scales.is_empty()
            || self.scales.iter().any(|scale| *scale <= 0.0)
            || !is_finite(&self.scaled)
        {
            return None;
        }
        let all: Vec<usize> = (0..self.scales.len()).collect();
        let eigen = self.scaled.clone().symmetric_eigen();
        let least = least_determined(&eigen);
        eigen.eigenvalues.iter().all(|value| *value > least).then(|| self.inverted(&eigen, &all))
    }

    /// From the eigenvalues of the scaled matrix of these parameters.
    fn inverted(&self, eigen: &SymmetricEigen<f64, Dyn>, params: &[usize]) -> DMatrix<f64> {
        let inverse = |value: f64| 1.0 / value;
        let inverted = &eigen.eigenvectors
            * DMatrix::from_diagonal(&eigen.eigenvalues.map(inverse))
            * eigen.eigenvectors.transpose();
        DMatrix::from_fn(params.len(), params.len(), |row, column| {
            0.5 * self.scales[params[row]]
                * self.scales[params[column]]
                * (inverted[(row, column)] + inverted[(column, row)])
        })
    }
}

/// Eigenvalues up to this are rounding.
fn least_determined(eigen: &SymmetricEigen<f64, Dyn>) -> f64 {
    eigen.eigenvalues.iter().fold(ROUNDING, |least, &value| least.max(OPEN * value))
}

fn is_finite(matrix: &DMatrix<f64>) -> bool {
    matrix.iter().all(|value| value.is_finite())
}

/// The directions that the observations leave open, or the inverse of the information where that is nothing.
pub(super) fn open_or_inverse(
    lambda: &Lambda,
    values: &[f64],
    residuals: usize,
) -> Result<DMatrix<f64>, Vec<OpenDirection>> {
    // What no observation depends on has a scale of zero; it is open by itself, as is what moves no pixel.
    let (scales, root) = (&lambda.scales, (residuals as f64).sqrt());
    let moves =
        |&at: &usize| scales[at] > 0.0 && values[at].abs().max(1.0) > UNSEEN_PX * root * scales[at];
    let alone = |at: usize| OpenDirection { changes: vec![(at, 1.0)] };
    let is_seen: Vec<usize> = (0..scales.len()).filter(moves).collect();
    let mut open: Vec<OpenDirection> =
        (0..scales.len()).filter(|at| !moves(at)).map(alone).collect();
    let scaled = lambda.scaled.select_rows(&is_seen).select_columns(&is_seen);
    if is_seen.is_empty() || !is_finite(&scaled) {
        // Nothing to decompose; numbers that overflowed tell of no direction.
        open.extend(is_seen.iter().map(|&at| alone(at)));
        return if open.is_empty() { Ok(DMatrix::zeros(0, 0)) } else { Err(open) };
    }
    let eigen = scaled.symmetric_eigen();
    let least = least_determined(&eigen);
    for (at, &value) in eigen.eigenvalues.iter().enumerate() {
        // Not a number is open too.
        if value > least {
            continue;
        }
        let vector = eigen.eigenvectors.column(at);
        let most = vector.amax();
        let parts =
            vector.iter().zip(&is_seen).filter(|(part, _)| part.abs() >= SMALL_SHARE * most);
        let changes = parts.map(|(part, &param)| (param, part * scales[param])).collect();
        open.push(OpenDirection { changes });
    }
    if open.is_empty() { Ok(lambda.inverted(&eigen, &is_seen)) } else { Err(open) }
}

impl Covariance {
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
