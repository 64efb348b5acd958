//! `DIVISION`: one-parameter division model, two focal lengths.
//!
//! w = (z + sqrt(z^2 - 4 k (x^2 + y^2))) / 2
//! px = fx x / w + cx, py = fy y / w + cy; back: (x, y, z) = (u, v, 1 + k (u^2 + v^2))
//!
//! A. Fitzgibbon, Simultaneous Linear Estimation of Multiple View Geometry and Lens Distortion, CVPR 2001.

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{extra, focal, principal_point};
use super::{CameraError, CameraModel, Division, Linearized, Pair, Param, estimate};

impl CameraModel<5> for Division {
    const NAME: &str = "DIVISION";
    const COLMAP_ID: Option<i32> = Some(13);
    const PARAMS: [Param; 5] =
        [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), extra("k")];
    const EXAMPLES: &[[f64; 5]] = &[
        [500.0, 490.0, 320.0, 240.0, -0.2],
        [500.0, 490.0, 320.0, 240.0, 0.1],
        [427.0, 425.0, 512.0, 512.0, -0.6],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 5], point: &Vector3<f64>) -> Option<Linearized<5>> {
        let [fx, fy, cx, cy, k] = *params;
        let (seen, bent) = lens::division(point, k)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen, bent))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 5], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [fx, fy, cx, cy, k] = *params;
        lens::undo_division(lens::undo_two_focals([fx, fy, cx, cy], pixel), k)
    }

    fn largest_angle(params: &[f64; 5]) -> f64 {
        let [.., k] = *params;
        lens::division_angle(k)
    }

    /// By k r2 (x, y) = z (u, v) - (x, y).
    fn estimate_distortion(params: &[f64; 5], pairs: &[Pair]) -> Result<[f64; 5], CameraError> {
        let [fx, fy, cx, cy, _] = *params;
        let [k] = estimate::fit(pairs, |ray, pixel| {
            lens::division_equation(ray, lens::undo_two_focals([fx, fy, cx, cy], pixel))
        })?;
        Ok([fx, fy, cx, cy, k])
    }
}
