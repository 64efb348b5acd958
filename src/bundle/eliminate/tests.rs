//! The pass against the same algebra on whole matrices.

use nalgebra::{DMatrix, DVector};

use super::super::problem::Problem;
use super::super::testing::{World, camera};
use super::super::{Options, Refine, Which};
use super::*;
use crate::camera::ParamClass::{Extra, Focal, PrincipalPoint};

const IMAGES: usize = 5;
const POINTS: usize = 12;
/// Poses and intrinsics.
const KEPT: usize = 6 * IMAGES + 8;

/// Residuals of about twice the loss's scale: many count negative.
fn problem() -> (Problem, Options) {
    let lens = camera("OPENCV", &[1000.0, 1010.0, 645.0, 472.0, -0.1, 0.03, 0.001, -0.0005]);
    let world = World::ring(vec![lens], 5, POINTS).with_noise(1.5);
    let others = [Focal, PrincipalPoint, Extra].map(Which::Class).to_vec();
    let refine = Refine { others, ..Refine::default() };
    let options = Options { refine, loss: Loss::Cauchy(1.0), ..Options::default() };
    (Problem::new(&world.scene(), &options).unwrap(), options)
}

fn view<'a>(problem: &'a Problem, options: &Options) -> View<'a> {
    View {
        lenses: &problem.lenses,
        params: &problem.start.params,
        poses: &problem.start.poses,
        points: &problem.start.points,
        width: problem.layout.width,
        loss: options.loss,
        bends: true,
        moves_poses: true,
        moves_points: true,
    }
}

/// J^T S J and J^T r over poses, intrinsics and points, and how many rows count negative.
fn whole(chunk: &Chunk, view: &View<'_>) -> (DMatrix<f64>, DVector<f64>, usize) {
    let size = KEPT + 3 * view.points.len();
    let (mut square, mut gradient) = (DMatrix::zeros(size, size), DVector::zeros(size));
    let (mut rows, mut start, mut negative) = (vec![Row::ZERO; chunk.longest], 0, 0);
    for (index, (point, &end)) in view.points.iter().zip(&chunk.ends).enumerate() {
        let track = &chunk.sightings[start..end as usize];
        start = end as usize;
        block_of::<8, false>(chunk, view, (point, track), &mut rows);
        for (seen, row) in track.iter().zip(&rows) {
            negative += usize::from(row.sign < 0.0);
            for (axis, sign) in [row.sign, 1.0].into_iter().enumerate() {
                let along = Vector3::from(row.wrt_point[axis]);
                let mut whole = DVector::zeros(size);
                let turn = point.cross(&along);
                whole.rows_mut(6 * seen.image as usize, 3).copy_from(&turn);
                whole.rows_mut(6 * seen.image as usize + 3, 3).copy_from(&along);
                whole.rows_mut(6 * IMAGES, 8).copy_from_slice(&row.wrt_params[axis][..8]);
                whole.rows_mut(KEPT + 3 * index, 3).copy_from(&along);
                gradient += &whole * row.residual[axis];
                square += sign * &whole * whole.transpose();
            }
        }
    }
    (square, gradient, negative)
}

/// The sums of the only chunk, as a matrix and a vector over poses and intrinsics.
fn summed(chunk: &Chunk, sums: &Sums) -> (DMatrix<f64>, DVector<f64>) {
    let (mut square, mut gradient) = (DMatrix::zeros(KEPT, KEPT), DVector::zeros(KEPT));
    for second in 0..IMAGES {
        for first in 0..=second {
            let block = &sums.pose_blocks[chunk.pose_pose[pair(first, second)] as usize];
            for (row, values) in block.iter().enumerate() {
                for column in 0..6 {
                    square[(6 * second + column, 6 * first + row)] = values[column];
                }
                if first == second {
                    gradient[6 * second + row] = values[6];
                }
            }
        }
        let start = chunk.pose_camera[second] as usize;
        for (at, value) in sums.blocks[start..start + 48].iter().enumerate() {
            square[(6 * IMAGES + at % 8, 6 * second + at / 8)] = *value;
        }
    }
    let start = chunk.camera_camera[0] as usize;
    for (at, value) in sums.blocks[start..start + 64].iter().enumerate() {
        square[(6 * IMAGES + at / 8, 6 * IMAGES + at % 8)] = *value;
    }
    gradient.rows_mut(6 * IMAGES, 8).copy_from_slice(&sums.cameras[0][0][..8]);
    square.fill_upper_triangle_with_lower_triangle();
    (square, gradient)
}

#[test]
fn what_is_summed_is_the_schur_complement_of_the_whole_with_and_without_fused_arithmetic() {
    let (problem, options) = problem();
    let ([chunk], view) = (problem.chunks.as_slice(), view(&problem, &options)) else {
        panic!("one chunk was expected")
    };
    let (square, gradient, negative) = whole(chunk, &view);
    assert!(negative > 5, "{negative}");
    let points = square.view_range(KEPT.., KEPT..).into_owned().try_inverse().unwrap();
    let side = square.view_range(..KEPT, KEPT..) * points;
    let schur = square.view_range(..KEPT, ..KEPT) - &side * square.view_range(KEPT.., ..KEPT);
    let reduced = gradient.rows_range(..KEPT) - side * gradient.rows_range(KEPT..);
    // Columns of very unlike size: each number is held against those of its row and column.
    let scale = square.diagonal().map(|value| value.abs().sqrt());
    type Pass = fn(&Chunk, &View<'_>, f64, &mut Sums);
    let passes: [Pass; 3] = [add_points::<8, false>, add_points::<8, true>, eliminate];
    for pass in passes {
        let mut sums = Sums::default();
        sums.clear(chunk);
        pass(chunk, &view, 0.0, &mut sums);
        let (found, found_gradient) = summed(chunk, &sums);
        for row in 0..KEPT {
            let apart = (found_gradient[row] - reduced[row]).abs();
            assert!(apart < 1e-9 * scale[row], "{row}: {apart:.1e}");
            for column in 0..KEPT {
                let apart = (found[(row, column)] - schur[(row, column)]).abs();
                assert!(apart < 1e-9 * scale[row] * scale[column], "{row} {column}: {apart:.1e}");
            }
        }
    }
}
