//! A point's own block of J^T J, and the factor by which the point is eliminated.

use super::linearize::Row;
use super::products::fused;

/// The point's own block of J^T J, and its gradient.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointBlock {
    /// J_point^T J_point: xx, yx, yy, zx, zy, zz.
    square: [f64; 6],
    /// Its diagonal, were no row to count negative: what damping goes by.
    pub diagonal: [f64; 3],
    pub gradient: [f64; 3],
}

/// L^-1 of V = L L^T, lower triangle; a direction that is not determined has a row of zeros.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InverseFactor {
    rows: [[f64; 3]; 3],
    pub nullity: usize,
}

impl PointBlock {
    /// Sums over weighed rows.
    #[inline(always)]
    pub(super) fn of<const FUSED: bool>(rows: &[Row]) -> Self {
        let (mut square, mut diagonal, mut gradient) = ([0.0; 6], [0.0; 3], [0.0; 3]);
        for row in rows {
            for (axis, sign) in [row.sign, 1.0].into_iter().enumerate() {
                let [x, y, z] = row.wrt_point[axis];
                for (sum, value) in diagonal.iter_mut().zip([x, y, z]) {
                    *sum = fused::<FUSED>(value, value, *sum);
                }
                let (a, b, c) = (sign * x, sign * y, sign * z);
                let (left, right) = ([a, b, b, c, c, c], [x, x, y, x, y, z]);
                for at in 0..6 {
                    square[at] = fused::<FUSED>(left[at], right[at], square[at]);
                }
                for (sum, value) in gradient.iter_mut().zip([x, y, z]) {
                    *sum = fused::<FUSED>(value, row.residual[axis], *sum);
                }
            }
        }
        Self { square, diagonal, gradient }
    }

    /// Sums over rows of which nothing is known but d pixel / d point.
    #[inline(always)]
    pub(super) fn of_derivatives<'a>(rows: impl Iterator<Item = &'a [[f64; 3]; 2]>) -> Self {
        let mut square = [0.0; 6];
        for [x, y, z] in rows.flatten() {
            for (sum, value) in square.iter_mut().zip([x * x, y * x, y * y, z * x, z * y, z * z]) {
                *sum += value;
            }
        }
        let [xx, _, yy, _, _, zz] = square;
        Self { square, diagonal: [xx, yy, zz], gradient: [0.0; 3] }
    }

    /// Whether the undamped block is positive definite beyond rounding.
    pub(super) fn is_positive(&self) -> bool {
        /// Of the diagonal. More would take in sound points of small parallax, whose steps then are short for ever.
        const MARGIN: f64 = 1e-10;
        let [xx, yx, yy, zx, zy, zz] = self.square;
        let [x, y, z] = self.diagonal;
        let (xx, yy, zz) = (xx - MARGIN * x, yy - MARGIN * y, zz - MARGIN * z);
        let minor = xx * yy - yx * yx;
        let whole = zz * minor - xx * zy * zy - yy * zx * zx + 2.0 * yx * zx * zy;
        xx > 0.0 && minor > 0.0 && whole > 0.0
    }

    /// The inverse of the factor of V + damping diag(V).
    #[inline(always)]
    pub(super) fn factor(&self, damping: f64) -> InverseFactor {
        /// The square of the smallest parallax, in radians, that rounding leaves visible.
        const NULL: f64 = 1e-14;
        let [xx, yx, yy, zx, zy, zz] = self.square;
        let [more_x, more_y, more_z] = self.diagonal;
        let mut nullity = 0;
        let mut inverse_root = |pivot: f64, diagonal: f64| {
            if pivot > NULL * diagonal {
                1.0 / pivot.sqrt()
            } else {
                nullity += 1;
                0.0
            }
        };
        let a = inverse_root(xx + damping * more_x, xx);
        let (l10, l20) = (yx * a, zx * a);
        let b = inverse_root(yy + damping * more_y - l10 * l10, yy);
        let l21 = (zy - l20 * l10) * b;
        let c = inverse_root(zz + damping * more_z - l20 * l20 - l21 * l21, zz);
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
    pub(crate) fn times(&self, v: &[f64; 3]) -> [f64; 3] {
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
