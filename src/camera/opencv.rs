//! `OPENCV`: pinhole, two focal lengths, two radial and two tangential terms.
//! Numbers five to eight are k1 k2 p1 p2; `OPENCV_FISHEYE` has k1 to k4 there.
//!
//! u = x / z, v = y / z, r2 = u^2 + v^2
//! s = 1 + k1 r2 + k2 r2^2
//! px = fx (s u + 2 p1 u v + p2 (r2 + 2 u^2)) + cx
//! py = fy (s v + 2 p2 u v + p1 (r2 + 2 v^2)) + cy
//!
//! D. C. Brown, Close-Range Camera Calibration, 1971.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Vector2, Vector3};

use super::lens::{self, Bent};
use super::param::{focal, polynomial, principal_point};
use super::{CameraModel, Linearized, OpenCv, Param};

impl CameraModel<8> for OpenCv {
    const NAME: &str = "OPENCV";
    const COLMAP_ID: Option<i32> = Some(4);
    const WIDEST_ANGLE: f64 = FRAC_PI_2;
    const PARAMS: [Param; 8] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        polynomial("k1"),
        polynomial("k2"),
        polynomial("p1"),
        polynomial("p2"),
    ];
    const AT_ONCE: bool = true;
    const EXAMPLES: &[[f64; 8]] = &[
        [1061.6, 1035.29, 640.0, 480.0, -0.333951, 0.121122, 0.0025596, 0.00419425],
        [465.7, 465.0, 376.0, 240.0, -0.275, 0.067, 0.0014, -0.00044],
        [2755.0, 2741.0, 1536.0, 1024.0, 0.0068, -0.0054, 0.0008, 0.0016],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 8], point: &Vector3<f64>) -> Option<Linearized<8>> {
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let seen = lens::pinhole(point)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen, bent(bend, seen.at)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 8], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let (ray, is_sure) = Self::unproject_at_once(params, pixel);
        if is_sure {
            return Some(ray);
        }
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let target = lens::undo_two_focals([fx, fy, cx, cy], pixel);
        Some(lens::unbend(target, |at| bent(bend, at))?.push(1.0))
    }

    #[inline(always)]
    fn unproject_at_once(params: &[f64; 8], pixel: &Vector2<f64>) -> (Vector3<f64>, bool) {
        let [fx, fy, cx, cy, k1, k2, p1, p2] = *params;
        let target = lens::undo_two_focals([fx, fy, cx, cy], pixel);
        let (at, is_sure) = lens::unbend_brown_at_once(target, &[k1, k2], [p1, p2]);
        (at.push(1.0), is_sure)
    }

    #[inline(always)]
    fn linearize_at_once(params: &[f64; 8], point: &Vector3<f64>) -> (Linearized<8>, bool) {
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let (seen, sees) = lens::pinhole_at_once(point);
        let (bent, unfolds) = bent_at_once(bend, seen.at);
        (lens::two_focals([fx, fy, cx, cy], seen, bent), sees && unfolds)
    }

    fn largest_angle(params: &[f64; 8]) -> f64 {
        let [.., k1, k2, _, _] = *params;
        lens::pinhole_fold(&[k1, k2])
    }
}

#[inline(always)]
fn bent([k1, k2, p1, p2]: [f64; 4], at: Vector2<f64>) -> Option<Bent<4>> {
    lens::brown(at, (&[k1, k2], [0, 1]), ([p1, p2], [2, 3]))
}

#[inline(always)]
fn bent_at_once([k1, k2, p1, p2]: [f64; 4], at: Vector2<f64>) -> (Bent<4>, bool) {
    lens::brown_at_once(at, (&[k1, k2], [0, 1]), ([p1, p2], [2, 3]))
}
