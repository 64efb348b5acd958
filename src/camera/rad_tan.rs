//! `RADTAN`: `OPENCV` with a third radial term (ROS's plumb_bob).
//!
//! u = x / z, v = y / z, r2 = u^2 + v^2
//! s = 1 + k1 r2 + k2 r2^2 + k3 r2^3
//! px = fx (s u + 2 p1 u v + p2 (r2 + 2 u^2)) + cx
//! py = fy (s v + 2 p2 u v + p1 (r2 + 2 v^2)) + cy

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Vector2, Vector3};

use super::lens::{self, Bent};
use super::param::{focal, polynomial, principal_point};
use super::{CameraModel, Linearized, Param, RadTan};

impl CameraModel<9> for RadTan {
    const NAME: &str = "RADTAN";
    const COLMAP_ID: Option<i32> = None;
    const WIDEST_ANGLE: f64 = FRAC_PI_2;
    const PARAMS: [Param; 9] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        polynomial("k1"),
        polynomial("k2"),
        polynomial("p1"),
        polynomial("p2"),
        polynomial("k3"),
    ];
    const AT_ONCE: bool = true;
    const EXAMPLES: &[[f64; 9]] = &[
        [500.0, 490.0, 320.0, 240.0, -0.3, 0.12, 0.001, -0.002, -0.02],
        [500.0, 490.0, 320.0, 240.0, 0.1, -0.02, 0.001, -0.002, 0.01],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 9], point: &Vector3<f64>) -> Option<Linearized<9>> {
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let seen = lens::pinhole(point)?;
        Some(lens::two_focals([fx, fy, cx, cy], seen, bent(bend, seen.at)?))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 9], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let (ray, is_sure) = Self::unproject_at_once(params, pixel);
        if is_sure {
            return Some(ray);
        }
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let target = lens::undo_two_focals([fx, fy, cx, cy], pixel);
        Some(lens::unbend(target, |at| bent(bend, at))?.push(1.0))
    }

    #[inline(always)]
    fn unproject_at_once(params: &[f64; 9], pixel: &Vector2<f64>) -> (Vector3<f64>, bool) {
        let [fx, fy, cx, cy, k1, k2, p1, p2, k3] = *params;
        let target = lens::undo_two_focals([fx, fy, cx, cy], pixel);
        let (at, is_sure) = lens::unbend_brown_at_once(target, &[k1, k2, k3], [p1, p2]);
        (at.push(1.0), is_sure)
    }

    #[inline(always)]
    fn linearize_at_once(params: &[f64; 9], point: &Vector3<f64>) -> (Linearized<9>, bool) {
        let [fx, fy, cx, cy, bend @ ..] = *params;
        let (seen, sees) = lens::pinhole_at_once(point);
        let (bent, unfolds) = bent_at_once(bend, seen.at);
        (lens::two_focals([fx, fy, cx, cy], seen, bent), sees && unfolds)
    }

    fn largest_angle(params: &[f64; 9]) -> f64 {
        let [.., k1, k2, _, _, k3] = *params;
        lens::pinhole_fold(&[k1, k2, k3])
    }
}

#[inline(always)]
fn bent([k1, k2, p1, p2, k3]: [f64; 5], at: Vector2<f64>) -> Option<Bent<5>> {
    lens::brown(at, (&[k1, k2, k3], [0, 1, 4]), ([p1, p2], [2, 3]))
}

#[inline(always)]
fn bent_at_once([k1, k2, p1, p2, k3]: [f64; 5], at: Vector2<f64>) -> (Bent<5>, bool) {
    lens::brown_at_once(at, (&[k1, k2, k3], [0, 1, 4]), ([p1, p2], [2, 3]))
}
