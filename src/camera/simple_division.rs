//! `SIMPLE_DIVISION`: one-parameter division model, one focal length.
//!
//! w = (z + sqrt(z^2 - 4 k (x^2 + y^2))) / 2
//! px = f x / w + cx, py = f y / w + cy; back: (x, y, z) = (u, v, 1 + k (u^2 + v^2))
//!
//! A. Fitzgibbon, Simultaneous Linear Estimation of Multiple View Geometry and Lens Distortion, CVPR 2001.

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{extra, focal, principal_point};
use super::{CameraError, CameraModel, Linearized, Pair, Param, SimpleDivision, estimate};

impl CameraModel<4> for SimpleDivision {
    const NAME: &str = "SIMPLE_DIVISION";
    const COLMAP_ID: Option<i32> = Some(12);
    const PARAMS: [Param; 4] =
        [focal("f"), principal_point("cx"), principal_point("cy"), extra("k")];
    const EXAMPLES: &[[f64; 4]] =
        &[[500.0, 320.0, 240.0, -0.2], [500.0, 320.0, 240.0, 0.1], [427.0, 512.0, 512.0, -0.6]];

    #[inline(always)]
    fn linearize(params: &[f64; 4], point: &Vector3<f64>) -> Option<Linearized<4>> {
        let [f, cx, cy, k] = *params;
        let (seen, bent) = lens::division(point, k)?;
        Some(lens::one_focal([f, cx, cy], seen, bent))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 4], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [f, cx, cy, k] = *params;
        lens::undo_division(lens::undo_one_focal([f, cx, cy], pixel), k)
    }

    fn largest_angle(params: &[f64; 4]) -> f64 {
        let [.., k] = *params;
        lens::division_angle(k)
    }

    /// By k r2 (x, y) = z (u, v) - (x, y).
    fn estimate_distortion(params: &[f64; 4], pairs: &[Pair]) -> Result<[f64; 4], CameraError> {
        let [f, cx, cy, _] = *params;
        let [k] = estimate::fit(pairs, |ray, pixel| {
            lens::division_equation(ray, lens::undo_one_focal([f, cx, cy], pixel))
        })?;
        Ok([f, cx, cy, k])
    }
}
