//! `PINHOLE`: pinhole, two focal lengths.
//!
//! u = x / z, v = y / z, r2 = u^2 + v^2
//! px = fx u + cx, py = fy v + cy

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{focal, principal_point};
use super::{CameraModel, Linearized, Param, Pinhole};

impl CameraModel<4> for Pinhole {
    const NAME: &str = "PINHOLE";
    const COLMAP_ID: Option<i32> = Some(1);
    const WIDEST_ANGLE: f64 = FRAC_PI_2;
    const PARAMS: [Param; 4] =
        [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy")];
    const EXAMPLES: &[[f64; 4]] = &[[500.0, 490.0, 320.0, 240.0], [1200.5, 800.0, 500.0, 700.0]];

    #[inline(always)]
    fn linearize(params: &[f64; 4], point: &Vector3<f64>) -> Option<Linearized<4>> {
        let [fx, fy, cx, cy] = *params;
        let seen = lens::pinhole(point)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen, lens::straight(seen.at)))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 4], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [fx, fy, cx, cy] = *params;
        Some(lens::undo_two_focals([fx, fy, cx, cy], pixel).push(1.0))
    }

    fn largest_angle(_: &[f64; 4]) -> f64 {
        FRAC_PI_2
    }
}
