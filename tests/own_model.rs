//! The example that brings a camera model of its own runs, and the laws that it uses can fail.

#![allow(dead_code, clippy::unwrap_used, reason = "the main of the example is not run here")]

#[path = "../examples/own_model.rs"]
mod example;

use calibstab::camera::{CameraModel, Linearized, Param};
use example::Stereographic;
use nalgebra::{Vector2, Vector3};

#[test]
fn a_model_of_a_users_own_keeps_the_laws() {
    assert_eq!(example::check::<Stereographic, 3>(), Ok(2000));
}

/// `Stereographic` with one derivative of the wrong sign, or a ray that leads elsewhere.
struct Wrong<const DERIVATIVE: bool>;

impl<const DERIVATIVE: bool> CameraModel<3> for Wrong<DERIVATIVE> {
    const NAME: &str = "WRONG";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 3] = Stereographic::PARAMS;
    const EXAMPLES: &[[f64; 3]] = Stereographic::EXAMPLES;

    fn linearize(params: &[f64; 3], point: &Vector3<f64>) -> Option<Linearized<3>> {
        let mut at = Stereographic::linearize(params, point)?;
        if DERIVATIVE {
            at.wrt_point[(0, 2)] *= -1.0;
        }
        Some(at)
    }

    fn unproject(params: &[f64; 3], pixel: &Vector2<f64>) -> Option<Vector3<f64>> {
        let moved = if DERIVATIVE { 0.0 } else { 1e-6 };
        Stereographic::unproject(params, &(pixel + Vector2::x() * moved))
    }

    fn largest_angle(params: &[f64; 3]) -> f64 {
        Stereographic::largest_angle(params)
    }
}

#[test]
fn the_laws_find_a_wrong_derivative_and_a_wrong_ray() {
    let broken = example::check::<Wrong<true>, 3>().unwrap_err();
    assert!(broken.contains("derivatives are off by"), "{broken}");
    let broken = example::check::<Wrong<false>, 3>().unwrap_err();
    assert!(broken.contains("the ray comes back"), "{broken}");
}
