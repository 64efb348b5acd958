//! `FOV`: field-of-view model of Devernay and Faugeras; omega in radians.
//!
//! a = 2 tan(omega / 2), phi = atan2(a rho, z), rho = |(x, y)|
//! px = fx (phi / omega) x / rho + cx, py = fy (phi / omega) y / rho + cy
//!
//! omega and -omega are one lens; at 0 it is a pinhole. COLMAP 4.2 is wrong below 0.01.
//! F. Devernay, O. Faugeras, Straight Lines Have to Be Straight, MVA 2001.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix2, Vector2, Vector3};

use super::lens::{self, Bent, Seen};
use super::param::{extra, focal, principal_point};
use super::{CameraError, CameraModel, Fov, Linearized, Pair, Param, estimate};

impl CameraModel<5> for Fov {
    const NAME: &str = "FOV";
    const COLMAP_ID: Option<i32> = Some(7);
    const PARAMS: [Param; 5] = [
        focal("fx"),
        focal("fy"),
        principal_point("cx"),
        principal_point("cy"),
        extra("omega").in_unit("rad").within(-PI, PI),
    ];
    const EXAMPLES: &[[f64; 5]] = &[
        [500.0, 490.0, 320.0, 240.0, 0.9],
        [500.0, 490.0, 320.0, 240.0, -1.4],
        [500.0, 490.0, 320.0, 240.0, 0.005],
        [300.0, 300.0, 320.0, 240.0, 0.0],
    ];

    #[inline(always)]
    fn linearize(params: &[f64; 5], point: &Vector3<f64>) -> Option<Linearized<5>> {
        let [fx, fy, cx, cy, omega] = *params;
        let width = omega.abs().max(NARROWEST);
        if width <= NARROWEST && point.z <= 0.0 {
            return None;
        }
        let a = 2.0 * (0.5 * width).tan();
        let seen = lens::equidistant(&Vector3::new(a * point.x, a * point.y, point.z))?;
        let at = seen.at / width;
        let seen = Seen {
            at,
            stretch: seen.stretch * a / width,
            slant: seen.slant.map(|[column, row]| [column * a / width, row]),
            wrt_z: seen.wrt_z / width,
        };
        let wrt_coefficients = at * (relative_wrt_width(width, a, point) * omega.signum());
        let bent = Bent { at, wrt_at: Matrix2::identity(), wrt_coefficients };
        Some(lens::two_focals([fx, fy, cx, cy], seen, bent))
    }

    #[inline(always)]
    fn unproject(params: &[f64; 5], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [fx, fy, cx, cy, omega] = *params;
        let width = omega.abs().max(NARROWEST);
        let a = 2.0 * (0.5 * width).tan();
        let ray = lens::undo_equidistant(lens::undo_two_focals([fx, fy, cx, cy], pixel) * width)?;
        Some(Vector3::new(ray.x / a, ray.y / a, ray.z))
    }

    fn largest_angle(params: &[f64; 5]) -> f64 {
        let [.., omega] = *params;
        if omega.abs() > NARROWEST { PI } else { FRAC_PI_2 }
    }

    /// By search: no equation is linear in omega, of which only the size can be found.
    fn estimate_distortion(params: &[f64; 5], pairs: &[Pair]) -> Result<[f64; 5], CameraError> {
        let [fx, fy, cx, cy, _] = *params;
        estimate::search::<Self, 5>([0.0, PI], pairs, |omega| Ok([fx, fy, cx, cy, omega]))
    }
}

/// Below this width the lens is a pinhole to the last bit.
const NARROWEST: f64 = 1e-9;

/// d (phi / omega) / d omega over phi / omega, for omega > 0.
#[inline(always)]
fn relative_wrt_width(width: f64, a: f64, point: &Vector3<f64>) -> f64 {
    /// Where the difference below would lose more digits than this series lacks.
    const NARROW: f64 = 1e-3;
    if width <= NARROWEST {
        return 0.0;
    }
    let z = point.z;
    let rho = point.xy().norm();
    if z > 0.0 && width * rho.max(z) < NARROW * z {
        let r2 = rho * rho / (z * z);
        let w3 = width.powi(3);
        let slope = width / 6.0 + w3 / 30.0 - r2 * (2.0 * width / 3.0 + w3 / 3.0 - 0.8 * w3 * r2);
        return slope / (1.0 + width * width * (1.0 / 12.0 - r2 / 3.0));
    }
    let phi = (a * rho).atan2(z);
    let wrt_width = (1.0 + 0.25 * a * a) * rho * z / (a * a * rho * rho + z * z);
    wrt_width / phi - 1.0 / width
}
