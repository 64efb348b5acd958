//! A camera model of your own, and the crate's laws on it: `cargo run --example own_model`.
//!
//! The stereographic fisheye: r = 2 f tan(theta / 2), in directions (x, y, z) of length d
//! px = f u + cx, py = f v + cy, (u, v) = 2 (x, y) / (d + z)

use std::process::ExitCode;

use calibstab::camera::param::{focal, principal_point};
use calibstab::camera::{CameraModel, Linearized, Param, laws};
use nalgebra::{Matrix2x3, Vector2, Vector3};

/// The lens of this example.
pub struct Stereographic;

impl CameraModel<3> for Stereographic {
    const NAME: &str = "STEREOGRAPHIC";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 3] = [focal("f"), principal_point("cx"), principal_point("cy")];
    const EXAMPLES: &[[f64; 3]] = &[[400.0, 512.0, 512.0], [250.0, 320.0, 240.0]];

    fn linearize(params: &[f64; 3], point: &Vector3<f64>) -> Option<Linearized<3>> {
        let [f, cx, cy] = *params;
        let d = point.norm();
        let w = 0.5 * (d + point.z);
        // Straight behind the camera is everywhere in the image, and what is no number nowhere.
        let is_seen = w > 1e-9 * d;
        let at = point.xy() / w;
        let wrt_w = (point / d + Vector3::z()) * 0.5;
        let wrt_point = (Matrix2x3::identity() - at * wrt_w.transpose()) * (f / w);
        let wrt_params = Matrix2x3::new(at.x, 1.0, 0.0, at.y, 0.0, 1.0);
        let pixel = at * f + Vector2::new(cx, cy);
        is_seen.then_some(Linearized { pixel, wrt_point, wrt_params })
    }

    fn unproject(params: &[f64; 3], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [f, cx, cy] = *params;
        let at = (pixel - Vector2::new(cx, cy)) / f;
        Some(at.push(1.0 - 0.25 * at.norm_squared()))
    }

    fn largest_angle(_: &[f64; 3]) -> f64 {
        std::f64::consts::PI
    }
}

/// How many checks passed, or the first that did not.
pub fn check<M: CameraModel<N>, const N: usize>() -> Result<usize, String> {
    let mut checks = 0;
    for params in M::EXAMPLES {
        for point in points() {
            let says = |what: &str| format!("{} {params:?} at {point:?}: {what}", M::NAME);
            if let Some(error) = laws::derivative_error::<M, N>(params, &point) {
                checks += 1;
                if error > 1e-8 {
                    return Err(says(&format!("derivatives are off by {error:.1e}")));
                }
            }
            if let Some([angle, allowed]) = laws::round_trip_error::<M, N>(params, &point) {
                checks += 1;
                if angle > allowed {
                    return Err(says(&format!("the ray comes back {angle:.1e} rad off")));
                }
            }
        }
    }
    // Half of the directions lie before the camera; a law that meets fewer has not been checked.
    if checks < M::EXAMPLES.len() * points().count() {
        Err(format!("only {checks} checks"))
    } else {
        Ok(checks)
    }
}

/// Directions on a spiral over the sphere, at several distances.
fn points() -> impl Iterator<Item = Vector3<f64>> {
    (0..500).map(|index| {
        let z = 1.0 - (2.0 * f64::from(index) + 1.0) / 500.0;
        let (sin, cos) = (2.4 * f64::from(index)).sin_cos();
        let across = (1.0 - z * z).sqrt();
        Vector3::new(across * cos, across * sin, z) * f64::from(1 + index % 7)
    })
}

#[allow(clippy::print_stdout, clippy::print_stderr)] // its only purpose
fn main() -> ExitCode {
    match check::<Stereographic, 3>() {
        Ok(checks) => {
            println!("{} keeps the laws: {checks} checks", Stereographic::NAME);
            ExitCode::SUCCESS
        }
        Err(broken) => {
            eprintln!("{broken}");
            ExitCode::FAILURE
        }
    }
}
