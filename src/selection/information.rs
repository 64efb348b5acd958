//! What images tell of the intrinsics: exactly, with poses and points free, and by themselves, with points held.

use nalgebra::{DMatrix, Matrix6};

use super::Candidates;
use super::assembly::System;
use crate::bundle::Sensitivities;
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

/// Adds so many times the values to the sums before which they stand.
#[inline(always)]
fn add_times(sums: &mut [f64], values: &[f64], times: f64) {
    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value * times);
}

/// What each image tells of its own camera when points are held and its pose is free: J_t^T (I - P_pose) J_t / sigma^2.
pub(super) fn own(rows: &Sensitivities, sigma_px: f64) -> Vec<DMatrix<f64>> {
    let count = |image: usize| rows.share(rows.camera_of[image]).len();
    let mut sums: Vec<(Matrix6<f64>, DMatrix<f64>, DMatrix<f64>)> = (0..rows.images.len())
        .map(|image| {
            let count = count(image);
            (Matrix6::zeros(), DMatrix::zeros(6, count), DMatrix::zeros(count, count))
        })
        .collect();
    for (point, place) in rows.points.iter().enumerate() {
        for seen in rows.track(point) {
            let (poses, borders, squares) = &mut sums[seen.image];
            for (pose, params) in seen.wrt_pose(place).iter().zip(rows.wrt_params(seen)) {
                for (column, &right) in pose.iter().enumerate() {
                    add_times(&mut poses.as_mut_slice()[6 * column..], &pose[..=column], right);
                }
                let count = params.len();
                for (column, &right) in params.iter().enumerate() {
                    add_times(&mut borders.as_mut_slice()[6 * column..], pose, right);
                    let square = &mut squares.as_mut_slice()[count * column..];
                    add_times(square, &params[..=column], right);
                }
            }
        }
    }
    let reduce = |(poses, border, mut square): (Matrix6<f64>, DMatrix<f64>, DMatrix<f64>)| {
        let pose = |row: usize, column: usize| poses[(row.min(column), row.max(column))];
        let inverse = pseudo_inverse(&DMatrix::from_fn(6, 6, pose));
        square.fill_lower_triangle_with_upper_triangle();
        (square - border.tr_mul(&(inverse * &border))) / (sigma_px * sigma_px)
    };
    sums.into_iter().map(reduce).collect()
}
