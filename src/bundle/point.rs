//! A point's own block of J^T J, and the factor by which the point is eliminated.

use super::linearize::Row;
use super::products::fused;

/// The point's own block of J^T J, and its gradient.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointBlock {
    /// J_point^T J_point: xx, yx, yy, zx, zy, zz.
    pub square: [f64; 6],
    pub gradient: [f64; 3],
}

/// L^-1 of V = L L^T, lower triangle; a direction that is not determined has a row of zeros.
#[derive(Debug, Clone, Copy)]
pub(super) struct InverseFactor {
    rows: [[f64; 3]; 3],
    pub nullity: usize,
}

impl PointBlock {
    /// Sums over weighed rows.
    #[inline(always)]
    pub(super) fn of<const FUSED: bool>(rows: &[Row]) -> Self {
        let (mut square, mut gradient) = ([0.0; 6], [0.0; 3]);
        for row in rows {
            for axis in 0..2 {
                let [x, y, z] = row.wrt_point[axis];
                let (left, right) = ([x, y, y, z, z, z], [x, x, y, x, y, z]);
                for at in 0..6 {
                    square[at] = fused::<FUSED>(left[at], right[at], square[at]);
                }
                for (sum, value) in gradient.iter_mut().zip([x, y, z]) {
                    *sum = fused::<FUSED>(value, row.residual[axis], *sum);
                }
            }
        }
        Self { square, gradient }
    }

    /// The inverse of the factor of V + damping diag(V).
    #[inline(always)]
    pub(super) fn factor(&self, damping: f64) -> InverseFactor {
        /// The square of the smallest parallax, in radians, that rounding leaves visible.
        const NULL: f64 = 1e-14;
        let [xx, yx, yy, zx, zy, zz] = self.square;
        let more = 1.0 + damping;
        let mut nullity = 0;
        let mut inverse_root = |pivot: f64, diagonal: f64| {
            if pivot > NULL * diagonal {
                1.0 / pivot.sqrt()
            } else {
                nullity += 1;
                0.0
            }
        };
        let a = inverse_root(xx * more, xx);
        let (l10, l20) = (yx * a, zx * a);
        let b = inverse_root(yy * more - l10 * l10, yy);
        let l21 = (zy - l20 * l10) * b;
        let c = inverse_root(zz * more - l20 * l20 - l21 * l21, zz);
        let ba = -l10 * a * b;
        let ca = -(l20 * a + l21 * ba) * c;
        let cb = -l21 * b * c;
        InverseFactor { rows: [[a, 0.0, 0.0], [ba, b, 0.0], [ca, cb, c]], nullity }
    }
}

impl InverseFactor {
    /// That of a point which stays.
    pub(super) const ZERO: Self = Self { rows: [[0.0; 3]; 3], nullity: 0 };

    /// L^-1 v
    #[inline(always)]
    pub(super) fn times(&self, v: &[f64; 3]) -> [f64; 3] {
        let [[a, ..], [ba, b, _], [ca, cb, c]] = self.rows;
        [a * v[0], ba * v[0] + b * v[1], ca * v[0] + cb * v[1] + c * v[2]]
    }

    /// L^-T v
    #[inline(always)]
    pub(super) fn transpose_times(&self, v: &[f64; 3]) -> [f64; 3] {
        let [[a, ..], [ba, b, _], [ca, cb, c]] = self.rows;
        [a * v[0] + ba * v[1] + ca * v[2], b * v[1] + cb * v[2], c * v[2]]
    }
}

