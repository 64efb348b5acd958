//! `EQUIRECTANGULAR`: the whole sphere; its width and height are never optimised.
//!
//! px = w (atan2(x, z) / 2 pi + 1/2), py = h (atan2(y, |(x, z)|) / pi + 1/2)

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};

use super::param::metadata;
use super::{CameraModel, Equirectangular, Linearized, Param};

impl CameraModel<2> for Equirectangular {
    const NAME: &str = "EQUIRECTANGULAR";
    const COLMAP_ID: Option<i32> = Some(17);
    const PARAMS: [Param; 2] = [metadata("w").positive(), metadata("h").positive()];
    const EXAMPLES: &[[f64; 2]] = &[[2000.0, 1000.0], [4096.0, 2048.0]];

    #[inline(always)]
    fn linearize(params: &[f64; 2], point: &Vector3<f64>) -> Option<Linearized<2>> {
        let [w, h] = *params;
        let [x, y, z]: [f64; 3] = (*point).into();
        let across2 = x * x + z * z;
        let across = across2.sqrt();
        let norm2 = point.norm_squared();
        // A NaN is not above zero.
        let has_longitude = across > 0.0 && norm2.is_finite();
        let share = Vector2::new(x.atan2(z) / TAU + 0.5, y.atan2(across) / PI + 0.5);
        let wrt_point = Matrix2x3::new(
            w * z / (TAU * across2),
            0.0,
            -w * x / (TAU * across2),
            -h * x * y / (PI * across * norm2),
            h * across / (PI * norm2),
            -h * z * y / (PI * across * norm2),
        );
        let pixel = Vector2::new(w * share.x, h * share.y);
        let wrt_params = Matrix2::from_diagonal(&share);
        has_longitude.then_some(Linearized { pixel, wrt_point, wrt_params })
    }

    #[inline(always)]
    fn unproject(params: &[f64; 2], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [w, h] = *params;
        let longitude = TAU * (pixel.x / w - 0.5);
        let latitude = PI * (pixel.y / h - 0.5);
        let is_inside = longitude.abs() <= PI && latitude.abs() < FRAC_PI_2;
        let across = latitude.cos();
        let ray = Vector3::new(across * longitude.sin(), latitude.sin(), across * longitude.cos());
        is_inside.then_some(ray)
    }

    fn largest_angle(_: &[f64; 2]) -> f64 {
        PI
    }
}
