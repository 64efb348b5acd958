//! `DOUBLE_SPHERE`: double sphere model of Usenko, Demmel and Cremers.
//!
//! d1 = |(x, y, z)|, s = xi d1 + z, d2 = sqrt(x^2 + y^2 + s^2), w = alpha d2 + (1 - alpha) s
//! px = fx x / w + cx, py = fy y / w + cy
//!
//! V. Usenko, N. Demmel, D. Cremers, The Double Sphere Camera Model, 3DV 2018.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::lens::{self, Bent};
use super::param::{extra, focal, principal_point};
use super::{CameraError, CameraModel, DoubleSphere, Linearized, Pair, Param, estimate};

impl CameraModel<6> for DoubleSphere {
    const NAME: &str = "DOUBLE_SPHERE";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 6] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        extra("xi").within(-1.0, 1.0),
        extra("alpha").within(0.0, 1.0),
    ];
    const AT_ONCE: bool = true;
    const EXAMPLES: &[[f64; 6]] = &[
        [313.0, 313.0, 638.0, 514.0, -0.18, 0.59],
        [500.0, 490.0, 320.0, 240.0, 0.2, 0.4],
        [420.0, 420.0, 512.0, 512.0, -0.3, 0.7],
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
        let [fx, fy, cx, cy, xi, alpha] = *params;
        let [d1, s, d2, w] = spheres(point, xi, alpha);
        let wrt_d1 = point / d1;
        let wrt_s = wrt_d1 * xi + Vector3::z();
        let wrt_d2 = (Vector3::new(point.x, point.y, 0.0) + wrt_s * s) / d2;
        // Behind the second the map folds, where the paper's equation 43 ends a little too early.
        let unfolds = w > 0.0 && alpha * s + (1.0 - alpha) * d2 > 0.0;
        let (seen, is_finite) =
            lens::over_at_once(point, w, wrt_d2 * alpha + wrt_s * (1.0 - alpha));
        let wrt_xi = (alpha * s / d2 + 1.0 - alpha) * d1;
        let wrt_coefficients =
            Matrix2::from_columns(&[seen.at * (-wrt_xi / w), seen.at * (-(d2 - s) / w)]);
        let bent = Bent { at: seen.at, wrt_at: Matrix2::identity(), wrt_coefficients };
        (lens::two_focals([fx, fy, cx, cy], seen, bent), unfolds && is_finite)
    }

    #[inline(always)]
    fn unproject_at_once(params: &[f64; 6], pixel: &Vector2<f64>) -> (Vector3<f64>, bool) {
        let [fx, fy, cx, cy, xi, alpha] = *params;
        let at = lens::undo_two_focals([fx, fy, cx, cy], pixel);
        let r2 = at.norm_squared();
        let under = 1.0 - (2.0 * alpha - 1.0) * r2;
        let mz = (1.0 - alpha * alpha * r2) / (alpha * under.sqrt() + 1.0 - alpha);
        let over = mz * mz + (1.0 - xi * xi) * r2;
        let scale = (mz * xi + over.sqrt()) / (mz * mz + r2);
        ((at * scale).push(scale * mz - xi), under >= 0.0 && over >= 0.0)
    }

    fn largest_angle(params: &[f64; 6]) -> f64 {
        let [.., xi, alpha] = *params;
        // On the second sphere cos = -least; from there back to the first.
        let least = if alpha > 0.5 { (1.0 - alpha) / alpha } else { alpha / (1.0 - alpha) };
        let distance = (1.0 - xi * xi * (1.0 - least * least)).sqrt() - xi * least;
        (-least * distance - xi).clamp(-1.0, 1.0).acos()
    }

    /// For each xi by alpha (d2 - s) (u, v) = (x, y) - s (u, v), and xi by search.
    fn estimate_distortion(params: &[f64; 6], pairs: &[Pair]) -> Result<[f64; 6], CameraError> {
        let [fx, fy, cx, cy, ..] = *params;
        let with = |xi: f64| {
            let [alpha] = estimate::fit(pairs, |ray, pixel| {
                let at = lens::undo_two_focals([fx, fy, cx, cy], pixel);
                let [_, s, d2, _] = spheres(ray, xi, 0.0);
                ([at * (d2 - s)], ray.xy() - at * s)
            })?;
            Ok([fx, fy, cx, cy, xi, alpha])
        };
        estimate::search::<Self, 6>([-1.0, 1.0], pairs, with)
    }

    fn denominator(params: &[f64; 6], point: &Vector3<f64>) -> Option<f64> {
        let [.., xi, alpha] = *params;
        Some(spheres(point, xi, alpha)[3])
    }
}

/// d1, s, d2 and w.
#[inline(always)]
fn spheres(point: &Vector3<f64>, xi: f64, alpha: f64) -> [f64; 4] {
    let d1 = point.norm();
    let s = xi * d1 + point.z;
    let d2 = (point.xy().norm_squared() + s * s).sqrt();
    [d1, s, d2, alpha * d2 + (1.0 - alpha) * s]
}
