//! What a change of intrinsics does in the image, after the rotation that poses absorb.
//!
//! G = B - A (A^T A)^-1 A^T B over all pixels together, A = d pixel / d rotation, B = d pixel / d parameters.

use nalgebra::{DMatrix, Matrix3, Vector2};

use crate::camera::Intrinsics;

/// G, two rows a pixel and a column for each free parameter; none where a pixel has no ray, or the pixels do not tell a rotation.
pub(super) fn effect(
    camera: &Intrinsics,
    free: &[usize],
    pixels: &[Vector2<f64>],
) -> Option<DMatrix<f64>> {
    let mut by_turn = DMatrix::zeros(2 * pixels.len(), 3);
    let mut by_params = DMatrix::zeros(2 * pixels.len(), free.len());
    for (index, pixel) in pixels.iter().enumerate() {
        let ray = camera.unproject(pixel).ok()?;
        let seen = camera.linearize(&ray)?;
        let turn = -seen.wrt_point * ray.cross_matrix();
        by_turn.fixed_view_mut::<2, 3>(2 * index, 0).copy_from(&turn);
        for (column, &place) in free.iter().enumerate() {
            let mut target = by_params.fixed_view_mut::<2, 1>(2 * index, column);
            target.copy_from(&seen.wrt_params.column(place));
        }
    }
    let square: Matrix3<f64> = (by_turn.transpose() * &by_turn).fixed_view::<3, 3>(0, 0).into();
    let turns = square.try_inverse()? * by_turn.tr_mul(&by_params);
    Some(by_params - by_turn * turns)
}

/// The variance of each pixel for parameters of this covariance, in px^2: tr(G Sigma G^T).
pub(super) fn variances(effect: &DMatrix<f64>, covariance: &DMatrix<f64>) -> Vec<f64> {
    let carried = effect * covariance;
    let row = |row: usize| carried.row(row).dot(&effect.row(row));
    (0..effect.nrows() / 2).map(|pixel| row(2 * pixel) + row(2 * pixel + 1)).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::camera::{Grid, Model};

    /// Where the rays of `camera` are seen by `other`, turned by what brings them nearest to where they were.
    fn displacements(camera: &Intrinsics, other: &Intrinsics, pixels: &[Vector2<f64>]) -> Vec<f64> {
        let rays: Vec<Vector3<f64>> =
            pixels.iter().map(|at| camera.unproject(at).unwrap()).collect();
        let off = |turn: &Rotation3<f64>| -> Vec<f64> {
            let seen = rays.iter().map(|ray| other.project(&(turn * ray)).unwrap());
            seen.zip(pixels).flat_map(|(seen, at)| [seen.x - at.x, seen.y - at.y]).collect()
        };
        let mut turn = Rotation3::identity();
        for _ in 0..6 {
            let residuals = off(&turn);
            let h = 1e-6;
            let columns: Vec<Vec<f64>> = (0..3)
                .map(|axis| {
                    let by = |h: f64| off(&(Rotation3::new(Vector3::ith(axis, h)) * turn));
                    by(h).iter().zip(by(-h)).map(|(up, down)| (up - down) / (2.0 * h)).collect()
                })
                .collect();
            let jacobian = DMatrix::from_fn(residuals.len(), 3, |row, column| columns[column][row]);
            let right =
                jacobian.tr_mul(&DMatrix::from_column_slice(residuals.len(), 1, &residuals));
            let step = jacobian.tr_mul(&jacobian).cholesky().unwrap().solve(&right);
            turn = Rotation3::new(Vector3::new(-step[0], -step[1], -step[2])) * turn;
        }
        off(&turn)
    }

    #[test]
    fn the_effect_is_what_finite_changes_do() {
        let cameras: [(&str, &[f64], &[f64]); 3] = [
            ("SIMPLE_RADIAL", &[1000.0, 650.0, 470.0, -0.05], &[0.1, 0.1, 0.1, 1e-5]),
            (
                "OPENCV",
                &[900.0, 910.0, 650.0, 470.0, -0.1, 0.03, 1e-3, -5e-4],
                &[0.1, 0.1, 0.1, 0.1, 1e-5, 1e-5, 1e-6, 1e-6],
            ),
            (
                "OPENCV_FISHEYE",
                &[400.0, 402.0, 640.0, 480.0, 0.02, -5e-3, 1e-3, -1e-4],
                &[0.05, 0.05, 0.05, 0.05, 5e-6, 5e-6, 5e-6, 2e-6],
            ),
        ];
        let pixels: Vec<Vector2<f64>> = Grid::new(1280, 960).pixels().step_by(29).collect();
        let mut count = 0;
        for (name, params, steps) in cameras {
            let model = Model::named(name).unwrap();
            let camera = model.with_params(params).unwrap();
            let free: Vec<usize> = (0..params.len()).collect();
            let found = effect(&camera, &free, &pixels).unwrap();
            for place in free {
                let moved = |times: f64| {
                    let mut params = params.to_vec();
                    params[place] += times * steps[place];
                    displacements(&camera, &model.with_params(&params).unwrap(), &pixels)
                };
                let slopes: Vec<f64> = moved(1.0)
                    .iter()
                    .zip(moved(-1.0))
                    .map(|(up, down)| (up - down) / (2.0 * steps[place]))
                    .collect();
                let want = DMatrix::from_column_slice(slopes.len(), 1, &slopes);
                let off = (found.columns(place, 1) - &want).norm() / want.norm();
                assert!(off < 1e-6, "{name} {place}: {off:e}");
                count += 1;
            }
        }
        assert_eq!(count, 20);
    }

    #[test]
    fn a_variance_is_the_trace_of_its_block() {
        let effect = DMatrix::from_row_slice(4, 2, &[1.0, 2.0, 0.0, 1.0, 3.0, 0.0, 1.0, 1.0]);
        let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 9.0]);
        // (1 2) S (1 2)^T + (0 1) S (0 1)^T = 4 + 4 + 36 + 9; (3 0) and (1 1): 36 + 4 + 2 + 9
        assert_eq!(variances(&effect, &covariance), [53.0, 51.0]);
    }
}
