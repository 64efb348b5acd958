//! From the plane to pixels, and back.

use nalgebra::{ArrayStorage, Matrix2, Matrix2x3, SMatrix, Vector2};

use super::{Bent, Seen};

/// A projection with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearized<const N: usize> {
    /// The pixel.
    pub pixel: Vector2<f64>,
    /// d pixel / d point.
    pub wrt_point: Matrix2x3<f64>,
    /// d pixel / d parameters, in file order.
    pub wrt_params: SMatrix<f64, 2, N>,
}

impl<const N: usize> Linearized<N> {
    /// What stands for no projection.
    pub(in super::super) const NONE: Self = Self {
        pixel: Vector2::new(f64::NAN, f64::NAN),
        wrt_point: SMatrix::from_array_storage(ArrayStorage([[f64::NAN; 2]; 3])),
        wrt_params: SMatrix::from_array_storage(ArrayStorage([[f64::NAN; 2]; N])),
    };
}

/// px = fx u + cx, py = fy v + cy: the first four parameters are fx, fy, cx, cy, the others the coefficients of the bend.
#[inline(always)]
pub fn two_focals<const K: usize, const N: usize>(
    [fx, fy, cx, cy]: [f64; 4],
    seen: Seen,
    bent: Bent<K>,
) -> Linearized<N> {
    let [x, y]: [f64; 2] = bent.at.into();
    let scale = |column: Vector2<f64>| Vector2::new(fx * column.x, fy * column.y);
    let [first, second]: [Vector2<f64>; 2] = bent.wrt_at.data.0.map(Into::into);
    let mut wrt_params = SMatrix::<f64, 2, N>::zeros();
    wrt_params.set_column(0, &Vector2::new(x, 0.0));
    wrt_params.set_column(1, &Vector2::new(0.0, y));
    wrt_params.set_column(2, &Vector2::x());
    wrt_params.set_column(3, &Vector2::y());
    for column in 0..K {
        wrt_params.set_column(4 + column, &scale(bent.wrt_coefficients.column(column).into()));
    }
    Linearized {
        pixel: Vector2::new(fx * x + cx, fy * y + cy),
        wrt_point: seen.chain(&Matrix2::from_columns(&[scale(first), scale(second)])),
        wrt_params,
    }
}

/// The same with one focal length: the first three parameters are f, cx, cy.
#[inline(always)]
pub fn one_focal<const K: usize, const N: usize>(
    [f, cx, cy]: [f64; 3],
    seen: Seen,
    bent: Bent<K>,
) -> Linearized<N> {
    let mut wrt_params = SMatrix::<f64, 2, N>::zeros();
    wrt_params.set_column(0, &bent.at);
    wrt_params.set_column(1, &Vector2::x());
    wrt_params.set_column(2, &Vector2::y());
    for column in 0..K {
        wrt_params.set_column(3 + column, &(bent.wrt_coefficients.column(column) * f));
    }
    Linearized {
        pixel: bent.at * f + Vector2::new(cx, cy),
        wrt_point: seen.chain(&(bent.wrt_at * f)),
        wrt_params,
    }
}

/// From pixels back to the plane.
#[inline(always)]
pub fn undo_two_focals([fx, fy, cx, cy]: [f64; 4], pixel: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new((pixel.x - cx) / fx, (pixel.y - cy) / fy)
}

/// From pixels back to the plane, with one focal length.
#[inline(always)]
pub fn undo_one_focal([f, cx, cy]: [f64; 3], pixel: &Vector2<f64>) -> Vector2<f64> {
    undo_two_focals([f, f, cx, cy], pixel)
}
