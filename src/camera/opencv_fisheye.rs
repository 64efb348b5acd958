//! `OPENCV_FISHEYE`: Kannala-Brandt: four terms in the angle from the axis.
//!
//! theta = angle from the axis, (u, v) = theta (x, y) / |(x, y)|, r2 = theta^2
//! s = 1 + k1 r2 + k2 r2^2 + k3 r2^3 + k4 r2^4,  px = fx s u + cx, py = fy s v + cy
//!
//! J. Kannala, S. Brandt, A Generic Camera Model and Calibration Method, PAMI 2006.

use nalgebra::{Vector2, Vector3};

use super::lens;
use super::param::{focal, polynomial, principal_point};
use super::{CameraModel, Linearized, OpenCvFisheye, Param};

impl CameraModel<8> for OpenCvFisheye {
    const NAME: &str = "OPENCV_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(5);
    const PARAMS: [Param; 8] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        polynomial("k1"),
        polynomial("k2"),
        polynomial("k3"),
        polynomial("k4"),
    ];
    const AT_ONCE: bool = true;
    const EXAMPLES: &[[f64; 8]] = &[
        [402.294, 437.448, 512.0, 512.0, -0.0814756, 0.121485, -0.0880346, 0.0181435],
        [428.331, 444.79, 512.0, 512.0, 0.00974985, 0.0337692, -0.0801194, 0.0217839],
        [419.591, 418.346, 512.0, 512.0, -0.0748247, 0.00877295, -0.00344216, 0.000329053],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 8], point: &Vector3<f64>) -> Option<Linearized<8>> {
        let [fx, fy, cx, cy, k @ ..] = *params;
        let seen = lens::equidistant(point)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen, lens::radial(seen.at, &k)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 8], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [fx, fy, cx, cy, k @ ..] = *params;
        lens::undo_equidistant(lens::unbend_radial(
            lens::undo_two_focals([fx, fy, cx, cy], pixel),
            &k,
        )?)
    }

    #[inline(always)]
    fn unproject_at_once(params: &[f64; 8], pixel: &Vector2<f64>) -> (Vector3<f64>, bool) {
        let [fx, fy, cx, cy, k @ ..] = *params;
        let target = lens::undo_two_focals([fx, fy, cx, cy], pixel);
        let (at, unfolds) = lens::unbend_radial_at_once(target, &k);
        let (ray, sees) = lens::undo_equidistant_at_once(at);
        (ray, sees && unfolds)
    }

    #[inline(always)]
    fn linearize_at_once(params: &[f64; 8], point: &Vector3<f64>) -> (Linearized<8>, bool) {
        let [fx, fy, cx, cy, k @ ..] = *params;
        let (seen, sees) = lens::equidistant_at_once(point);
        let (bent, unfolds) = lens::radial_at_once(seen.at, &k);
        (lens::two_focals([fx, fy, cx, cy], seen, bent), sees && unfolds)
    }

    fn largest_angle(params: &[f64; 8]) -> f64 {
        let [.., k1, k2, k3, k4] = *params;
        lens::fisheye_fold(&[k1, k2, k3, k4])
    }
}
