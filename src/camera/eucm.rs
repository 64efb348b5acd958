//! `EUCM`: enhanced unified camera model.
//!
//! rho2 = x^2 + y^2, d = sqrt(beta rho2 + z^2), w = alpha d + (1 - alpha) z
//! px = fx x / w + cx, py = fy y / w + cy
//!
//! B. Khomutenko, G. Garcia, P. Martinet, An Enhanced Unified Camera Model, RAL 2016.

use nalgebra::{Vector1, Vector2, Vector3};

use super::lens;
use super::param::{extra, focal, principal_point};
use super::{CameraError, CameraModel, Eucm, Linearized, Pair, Param, estimate};

impl CameraModel<6> for Eucm {
    const NAME: &str = "EUCM";
    const COLMAP_ID: Option<i32> = Some(16);
    const PARAMS: [Param; 6] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        extra("alpha").within(0.0, 1.0),
        extra("beta").neutral_at(1.0).positive(),
    ];
    const AT_ONCE: bool = true;
    const EXAMPLES: &[[f64; 6]] = &[
        [500.0, 490.0, 320.0, 240.0, 0.6, 1.1],
        [500.0, 490.0, 320.0, 240.0, 0.45, 0.9],
        [420.0, 420.0, 512.0, 512.0, 0.8, 1.3],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 6], point: &Vector3<f64>) -> Option<Linearized<6>> {
        let (at, sees) = Self::linearize_at_once(params, point);
        sees.then_some(at)
    }

    #[inline(always)]
    fn unproject(params: &[f64; 6], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let (ray, sees) = Self::unproject_at_once(params, pixel);
        sees.then_some(ray)
    }

    #[inline(always)]
    fn linearize_at_once(params: &[f64; 6], point: &Vector3<f64>) -> (Linearized<6>, bool) {
        let [fx, fy, cx, cy, alpha, beta] = *params;
        let (seen, bent, sees) = lens::unified(point, alpha, beta);
        (lens::two_focals([fx, fy, cx, cy], seen, bent), sees)
    }

    #[inline(always)]
    fn unproject_at_once(params: &[f64; 6], pixel: &Vector2<f64>) -> (Vector3<f64>, bool) {
        let [fx, fy, cx, cy, alpha, beta] = *params;
        lens::undo_unified(lens::undo_two_focals([fx, fy, cx, cy], pixel), alpha, beta)
    }

    fn largest_angle(params: &[f64; 6]) -> f64 {
        let [.., alpha, beta] = *params;
        lens::unified_angle(alpha, beta)
    }

    /// By (alpha^2 beta) r^2 rho^2 - alpha 2 r z (rho - r z) = (rho - r z)^2: its w without its root, r rho = (u, v) (x, y).
    fn estimate_distortion(params: &[f64; 6], pairs: &[Pair]) -> Result<[f64; 6], CameraError> {
        let [fx, fy, cx, cy, ..] = *params;
        let [square, alpha] = estimate::fit(pairs, |ray, pixel| {
            let (r, rho) = estimate::radius(ray, &lens::undo_two_focals([fx, fy, cx, cy], pixel));
            let rest = rho - r * ray.z;
            let columns = [(r * rho).powi(2), -2.0 * r * ray.z * rest];
            (columns.map(Vector1::new), Vector1::new(rest * rest))
        })?;
        Ok([fx, fy, cx, cy, alpha, square / (alpha * alpha)])
    }

    fn denominator(params: &[f64; 6], point: &Vector3<f64>) -> Option<f64> {
        let [.., alpha, beta] = *params;
        Some(lens::unified_denominator(point, alpha, beta)[1])
    }
}
