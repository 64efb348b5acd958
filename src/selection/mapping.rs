//! What a small change of a lens does to its pixels over the image: the matrix of the expected mapping error.
//!
//! H = mean of G^T G over a grid, so that E[K] = tr(H Sigma). A. Hagemann, M. Knorr, H. Janssen, C. Stiller, Inferring Bias and
//! Uncertainty in Camera Calibration, IJCV 2022.

use nalgebra::{DMatrix, Matrix2xX, Matrix3, Matrix3xX, Vector2};

use crate::camera::{CameraModel, Grid, Job};
use crate::scene::Camera;

/// What a small change d of a camera's free parameters does after the rotation that undoes most of it: d^T H d is the mean over the
/// image of the squared shift, in px^2. None where the lens sees nothing of its image.
pub(super) fn mapping(camera: &Camera, free: &[usize]) -> Option<DMatrix<f64>> {
    let pixels = Grid::new(camera.width, camera.height).pixels().collect::<Vec<_>>();
    camera.intrinsics.visit(Sum { pixels: &pixels, free })
}

struct Sum<'a> {
    pixels: &'a [Vector2<f64>],
    free: &'a [usize],
}

impl Job for Sum<'_> {
    type Output = Option<DMatrix<f64>>;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Option<DMatrix<f64>> {
        let size = self.free.len();
        let mut by_params = DMatrix::zeros(size, size);
        let mut by_both = Matrix3xX::zeros(size);
        let mut by_turn = Matrix3::zeros();
        let mut count = 0;
        for pixel in self.pixels {
            let Some(ray) = M::unproject(params, pixel).and_then(|ray| ray.try_normalize(0.0))
            else {
                continue;
            };
            let Some(seen) = M::linearize(params, &ray) else { continue };
            let shift =
                Matrix2xX::from_fn(size, |row, place| seen.wrt_params[(row, self.free[place])]);
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
}
