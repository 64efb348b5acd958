//! What images tell of the intrinsics: exactly, with poses and points free, and by themselves, with points held.

use multiversion::multiversion;
use nalgebra::{DMatrix, Vector3};

use super::Candidates;
use super::assembly::System;
use crate::bundle::{Sensed, Sensitivities};
use crate::scene::CameraId;

/// An eigenvalue of the scaled information below this share of the largest is rounding: that direction is open.
const OPEN: f64 = 1e-10;

/// What images tell of the free parameters: the inverse of their covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Information {
    /// In the order of `Candidates::params`; zero for cameras that took none of the images.
    pub matrix: DMatrix<f64>,
}

impl Information {
    /// The covariance of some parameters, whatever the others are; none where a direction of these is open.
    pub fn covariance(&self, params: &[usize]) -> Option<DMatrix<f64>> {
        let others: Vec<usize> =
            (0..self.matrix.nrows()).filter(|at| !params.contains(at)).collect();
        let part = |rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |row, column| {
                self.matrix[(rows[row], columns[column])]
            })
        };
        let mut left = part(params, params);
        if !others.is_empty() {
            let border = part(&others, params);
            left -= border.tr_mul(&(pseudo_inverse(&part(&others, &others)) * &border));
        }
        let (scales, scaled) = scaled(&left);
        let eigen = scaled.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        // Not a number is open too.
        let is_closed = |&value: &f64| value > OPEN * largest;
        if !eigen.eigenvalues.iter().all(is_closed) {
            return None;
        }
        let inverse = inverted(&eigen, |value| 1.0 / value);
        Some(DMatrix::from_fn(params.len(), params.len(), |row, column| {
            scales[row] * scales[column] * inverse[(row, column)]
        }))
    }

    /// The natural logarithm of its determinant; none where a direction is open.
    pub fn log_det(&self) -> Option<f64> {
        log_det(&self.matrix)
    }
}

/// ln det of a positive definite matrix.
pub(super) fn log_det(matrix: &DMatrix<f64>) -> Option<f64> {
    let factor = matrix.clone().cholesky()?;
    Some(2.0 * factor.l_dirty().diagonal().iter().map(|pivot| pivot.ln()).sum::<f64>())
}

type Eigen = nalgebra::SymmetricEigen<f64, nalgebra::Dyn>;

fn inverted(eigen: &Eigen, inverse: impl Fn(f64) -> f64) -> DMatrix<f64> {
    let vectors = &eigen.eigenvectors;
    vectors * DMatrix::from_diagonal(&eigen.eigenvalues.map(inverse)) * vectors.transpose()
}

/// One over the root of the diagonal, and the matrix with a diagonal of ones; nothing where nothing is known.
fn scaled(matrix: &DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let root = |value: &f64| if *value > 0.0 { 1.0 / value.sqrt() } else { 0.0 };
    let scales: Vec<f64> = matrix.diagonal().iter().map(root).collect();
    let entry = |row: usize, column: usize| {
        0.5 * scales[row] * scales[column] * (matrix[(row, column)] + matrix[(column, row)])
    };
    let scaled = DMatrix::from_fn(scales.len(), scales.len(), entry);
    (scales, scaled)
}

/// Parameters that are not wanted may be open: what they would carry there is nothing.
fn pseudo_inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let (scales, scaled) = scaled(matrix);
    let eigen = scaled.symmetric_eigen();
    let least = OPEN * eigen.eigenvalues.max();
    let inverse =
        inverted(&eigen, |value| if value > least && value > 0.0 { 1.0 / value } else { 0.0 });
    DMatrix::from_fn(scales.len(), scales.len(), |row, column| {
        scales[row] * scales[column] * inverse[(row, column)]
    })
}

impl Candidates {
    /// What some images together tell of all parameters, their poses and points free. Points that fewer than two of them see
    /// count for nothing.
    pub fn information(&self, images: &[usize]) -> Information {
        System::new(self, images).information()
    }

    /// The mean of the expected squared mapping errors of some cameras, in px^2: how far the lens that is found is expected to
    /// be off over its image, turned as it fits best. None where a direction is open or a camera is not seen.
    pub fn mapping_error(&self, information: &Information, cameras: &[CameraId]) -> Option<f64> {
        let places: Vec<usize> = cameras
            .iter()
            .map(|id| self.cameras().binary_search(id).ok())
            .collect::<Option<_>>()?;
        let params: Vec<usize> =
            places.iter().flat_map(|&camera| self.rows.share(camera)).collect();
        let covariance = information.covariance(&params)?;
        let (mut sum, mut start) = (0.0, 0);
        for &camera in &places {
            let count = self.rows.share(camera).len();
            sum += self.mappings[camera]
                .as_ref()?
                .dot(&covariance.view((start, start), (count, count)));
            start += count;
        }
        (sum.is_finite() && !places.is_empty()).then(|| sum / places.len() as f64)
    }
}

/// The sum of products of rows of an image's pose and its camera's parameters.
type Square<const WIDTH: usize> = [[f64; WIDTH]; WIDTH];

/// What each image tells of its own camera when points are held and its pose is free: J_t^T (I - P_pose) J_t / sigma^2.
pub(super) fn own(rows: &Sensitivities, sigma_px: f64) -> Vec<DMatrix<f64>> {
    // Compiled for rows of two widths: the pose's six columns, and those of ten parameters or of all that a camera can have.
    match (0..rows.cameras.len()).all(|camera| rows.share(camera).len() <= 10) {
        true => own_of_width::<16>(rows, sigma_px),
        false => own_of_width::<24>(rows, sigma_px),
    }
}

fn own_of_width<const WIDTH: usize>(rows: &Sensitivities, sigma_px: f64) -> Vec<DMatrix<f64>> {
    let mut squares = vec![[[0.0; WIDTH]; WIDTH]; rows.images.len()];
    for (point, place) in rows.points.iter().enumerate() {
        add_squares(&mut squares, rows, rows.track(point), place);
    }
    let reduce = |(image, square): (usize, &Square<WIDTH>)| {
        let count = rows.share(rows.camera_of[image]).len();
        let part = |first_row: usize, first_column: usize, height: usize, width: usize| {
            DMatrix::from_fn(height, width, |row, column| {
                let (row, column) = (first_row + row, first_column + column);
                square[row.max(column)][row.min(column)]
            })
        };
        let border = part(0, 6, 6, count);
        let inverse = pseudo_inverse(&part(0, 0, 6, 6));
        (part(6, 6, count, count) - border.tr_mul(&(inverse * &border))) / (sigma_px * sigma_px)
    };
    squares.iter().enumerate().map(reduce).collect()
}

#[multiversion(targets("x86_64+avx2+fma"))]
fn add_squares<const WIDTH: usize>(
    squares: &mut [Square<WIDTH>],
    rows: &Sensitivities,
    track: &[Sensed],
    place: &Vector3<f64>,
) {
    for seen in track {
        let square = &mut squares[seen.image];
        for (pose, params) in seen.wrt_pose(place).iter().zip(rows.wrt_params(seen)) {
            let mut row = [0.0; WIDTH];
            let (first, rest) = row.split_at_mut(6);
            first.copy_from_slice(pose);
            rest[..params.len()].copy_from_slice(params);
            for (sums, &left) in square.iter_mut().zip(&row[..6 + params.len()]) {
                // In full, since a width that is known is quicker than half the work.
                sums.iter_mut().zip(&row).for_each(|(sum, right)| *sum += left * right);
            }
        }
    }
}
