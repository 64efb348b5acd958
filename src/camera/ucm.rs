//! `UCM`: unified camera model.
//!
//! rho2 = x^2 + y^2, d = sqrt(rho2 + z^2), w = alpha d + (1 - alpha) z
//! px = fx x / w + cx, py = fy y / w + cy
//!
//! C. Mei, P. Rives, Single View Point Omnidirectional Camera Calibration from Planar Grids, ICRA 2007,
//! in the form of V. Usenko, N. Demmel, D. Cremers, The Double Sphere Camera Model, 3DV 2018.

use nalgebra::{Vector2, Vector3};

use super::lens::{self, Bent};
use super::param::{extra, focal, principal_point};
use super::{CameraError, CameraModel, Linearized, Pair, Param, Ucm, estimate};

impl CameraModel<5> for Ucm {
    const NAME: &str = "UCM";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 5] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        extra("alpha").within(0.0, 1.0),
    ];
    const AT_ONCE: bool = true;
    const EXAMPLES: &[[f64; 5]] = &[
        [500.0, 490.0, 320.0, 240.0, 0.6],
        [500.0, 490.0, 320.0, 240.0, 0.3],
        [420.0, 420.0, 512.0, 512.0, 0.8],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 5], point: &Vector3<f64>) -> Option<Linearized<5>> {
        let (at, sees) = Self::linearize_at_once(params, point);
        sees.then_some(at)
    }

    #[inline(always)]
    fn unproject(params: &[f64; 5], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let (ray, sees) = Self::unproject_at_once(params, pixel);
        sees.then_some(ray)
    }

    #[inline(always)]
    fn linearize_at_once(params: &[f64; 5], point: &Vector3<f64>) -> (Linearized<5>, bool) {
        let [fx, fy, cx, cy, alpha] = *params;
        let (seen, bent, sees) = lens::unified(point, alpha, 1.0);
        let wrt_coefficients = bent.wrt_coefficients.fixed_columns::<1>(0).into();
        let bent = Bent { at: bent.at, wrt_at: bent.wrt_at, wrt_coefficients };
        (lens::two_focals([fx, fy, cx, cy], seen, bent), sees)
    }

    #[inline(always)]
    fn unproject_at_once(params: &[f64; 5], pixel: &Vector2<f64>) -> (Vector3<f64>, bool) {
        let [fx, fy, cx, cy, alpha] = *params;
        lens::undo_unified(lens::undo_two_focals([fx, fy, cx, cy], pixel), alpha, 1.0)
    }

    fn largest_angle(params: &[f64; 5]) -> f64 {
        let [.., alpha] = *params;
        lens::unified_angle(alpha, 1.0)
    }

    /// By alpha (d - z) (u, v) = (x, y) - z (u, v).
    fn estimate_distortion(params: &[f64; 5], pairs: &[Pair]) -> Result<[f64; 5], CameraError> {
        let [fx, fy, cx, cy, _] = *params;
        let [alpha] = estimate::fit(pairs, |ray, pixel| {
            let at = lens::undo_two_focals([fx, fy, cx, cy], pixel);
            ([at * (ray.norm() - ray.z)], ray.xy() - at * ray.z)
        })?;
        Ok([fx, fy, cx, cy, alpha])
    }

    fn denominator(params: &[f64; 5], point: &Vector3<f64>) -> Option<f64> {
        let [.., alpha] = *params;
        Some(lens::unified_denominator(point, alpha, 1.0)[1])
    }
}
