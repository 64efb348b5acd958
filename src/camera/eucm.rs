//! `EUCM`: enhanced unified camera model.
//!
//! rho2 = x^2 + y^2, d = sqrt(beta rho2 + z^2), w = alpha d + (1 - alpha) z
//! px = fx x / w + cx, py = fy y / w + cy
//!
//! B. Khomutenko, G. Garcia, P. Martinet, An Enhanced Unified Camera Model, RAL 2016.

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{extra, focal, principal_point};
use super::{CameraModel, Eucm, Linearized, Param};

impl CameraModel<6> for Eucm {
    const NAME: &str = "EUCM";
    const COLMAP_ID: Option<i32> = Some(16);
    const PARAMS: [Param; 6] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        extra("alpha"),
        extra("beta").neutral_at(1.0),
    ];
    const EXAMPLES: &[[f64; 6]] = &[
        [500.0, 490.0, 320.0, 240.0, 0.6, 1.1],
        [500.0, 490.0, 320.0, 240.0, 0.45, 0.9],
        [420.0, 420.0, 512.0, 512.0, 0.8, 1.3],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 6], point: &Vector3<f64>) -> Option<Linearized<6>> {
        let [fx, fy, cx, cy, alpha, beta] = *params;
        let seen = lens::unified(point, alpha, beta)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen.0, seen.1))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 6], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [fx, fy, cx, cy, alpha, beta] = *params;
        lens::undo_unified(lens::undo_two_focals([fx, fy, cx, cy], pixel), alpha, beta)
    }

    fn largest_angle(params: &[f64; 6]) -> f64 {
        let [.., alpha, beta] = *params;
        lens::unified_angle(alpha, beta)
    }
}
