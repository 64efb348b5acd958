//! What a small change of a lens does to its pixels over the image: the matrix of the expected mapping error.
//!
//! H = mean of G^T G over a grid, so that E[K] = tr(H Sigma). A. Hagemann, M. Knorr, H. Janssen, C. Stiller, Inferring Bias and
//! Uncertainty in Camera Calibration, IJCV 2022.

use nalgebra::{DMatrix, Matrix2xX, Matrix3, Matrix3xX};

use crate::camera::Grid;
use crate::scene::Camera;

/// What a small change d of a camera's free parameters does after the rotation that undoes most of it: d^T H d is the mean over the
/// image of the squared shift, in px^2. None where the lens sees nothing of its image.
pub(super) fn mapping(camera: &Camera, free: &[usize]) -> Option<DMatrix<f64>> {
    let mut by_params = DMatrix::zeros(free.len(), free.len());
    let mut by_both = Matrix3xX::zeros(free.len());
    let mut by_turn = Matrix3::zeros();
    let mut count = 0;
    for pixel in Grid::new(camera.width, camera.height).pixels() {
        let Ok(ray) = camera.intrinsics.unproject(&pixel) else { continue };
        let Some(seen) = camera.intrinsics.linearize(&ray) else { continue };
        let shift = Matrix2xX::from_fn(free.len(), |row, at| seen.wrt_params[(row, free[at])]);
        // The ray turned by w moves by w x ray.
        let turn = seen.wrt_point * -ray.cross_matrix();
        by_params += shift.tr_mul(&shift);
        by_both += turn.tr_mul(&shift);
        by_turn += turn.tr_mul(&turn);
        count += 1;
    }
    let undone = by_turn.cholesky()?.solve(&by_both);
    Some((by_params - by_both.tr_mul(&undone)) / f64::from(count))
}
