//! `BAL_STRICT`: Bundle Adjustment in the Large as published; looks along -Z.
//!
//! u = -x / z, v = -y / z, s = 1 + k1 r2 + k2 r2^2, r2 = u^2 + v^2
//! px = f s u, py = f s v; y points up
//!
//! S. Agarwal, N. Snavely, S. Seitz, R. Szeliski, Bundle Adjustment in the Large, ECCV 2010.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{SMatrix, Vector2, Vector3};

use super::lens;
use super::param::{focal, polynomial};
use super::{BalStrict, CameraModel, Linearized, Param};

impl CameraModel<3> for BalStrict {
    const NAME: &str = "BAL_STRICT";
    const COLMAP_ID: Option<i32> = None;
    const WIDEST_ANGLE: f64 = FRAC_PI_2;
    const PARAMS: [Param; 3] = [focal("f"), polynomial("k1"), polynomial("k2")];
    const EXAMPLES: &[[f64; 3]] = &[[500.0, -0.1, 0.02], [700.0, 0.1, -0.08]];

    #[inline(always)]
    fn linearize(params: &[f64; 3], point: &Vector3<f64>) -> Option<Linearized<3>> {
        let [f, k @ ..] = *params;
        let seen = lens::pinhole_behind(point)?;
        let bent = lens::radial(seen.at, &k)?;
        let mut wrt_params = SMatrix::<f64, 2, 3>::zeros();
        wrt_params.set_column(0, &bent.at);
        wrt_params.fixed_columns_mut::<2>(1).copy_from(&(bent.wrt_coefficients * f));
        let wrt_point = seen.chain(&(bent.wrt_at * f));
        Some(Linearized { pixel: bent.at * f, wrt_point, wrt_params })
    }

    #[inline(always)]
    fn unproject(params: &[f64; 3], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [f, k @ ..] = *params;
        Some(lens::unbend_radial(pixel / f, &k)?.push(-1.0))
    }

    fn largest_angle(params: &[f64; 3]) -> f64 {
        let [_, k1, k2] = *params;
        lens::pinhole_fold(&[k1, k2])
    }
}
