//! `SIMPLE_PINHOLE`: pinhole, one focal length.
//!
//! u = x / z, v = y / z, r2 = u^2 + v^2
//! px = f u + cx, py = f v + cy

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{focal, principal_point};
use super::{CameraModel, Linearized, Param, SimplePinhole};

impl CameraModel<3> for SimplePinhole {
    const NAME: &str = "SIMPLE_PINHOLE";
    const COLMAP_ID: Option<i32> = Some(0);
    const WIDEST_ANGLE: f64 = FRAC_PI_2;
    const PARAMS: [Param; 3] = [focal("f"), principal_point("cx"), principal_point("cy")];
    const EXAMPLES: &[[f64; 3]] = &[[500.0, 320.0, 240.0], [1200.5, 500.0, 700.0]];

    #[inline(always)]
    fn linearize(params: &[f64; 3], point: &Vector3<f64>) -> Option<Linearized<3>> {
        let [f, cx, cy] = *params;
        let seen = lens::pinhole(point)?;
        Some(lens::one_focal([f, cx, cy], seen, lens::straight(seen.at)))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 3], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [f, cx, cy] = *params;
        Some(lens::undo_one_focal([f, cx, cy], pixel).push(1.0))
    }

    fn largest_angle(_: &[f64; 3]) -> f64 {
        FRAC_PI_2
    }
}
