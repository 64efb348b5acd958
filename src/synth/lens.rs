//! A camera of any model with a lens as one could buy it, for an image of any size.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Vector2, Vector3};

use super::frame::Frame;
use crate::camera::{CameraModel, Intrinsics, Job, Model, ParamClass};
use crate::scene::Camera;

/// What an image's corner sees, in degrees off the axis: a 24 mm lens before 35 mm film sees 42, a fisheye more than 90.
const CORNER_DEGREES: f64 = 40.0;
const CORNER_DEGREES_OF_FISHEYE: f64 = 115.0;

/// A corner sees at most this share of the angle at which the lens folds.
const CORNER_OF_FOLD: f64 = 0.9;

/// A camera of this model, its distortion that of the model's first example, its focal length such that the corners of
/// the image see 40 degrees off the axis, those of a fisheye 115, if the lens sees so far.
pub fn camera(model: &Model, width: u64, height: u64) -> Option<Camera> {
    let any = model.with_params(&vec![1.0; model.params.len()]).ok()?;
    let example = model.with_params(&any.visit(FirstExample)).ok()?;
    let scale = corner_scale(&example, width, height)?;
    let mut size = [width as f64, height as f64].into_iter();
    let mut centre = [width as f64 / 2.0, height as f64 / 2.0].into_iter();
    let mut params = Vec::new();
    for (param, &value) in model.params.iter().zip(example.params()) {
        params.push(match param.class {
            ParamClass::PrincipalPoint => centre.next()?,
            ParamClass::Metadata => size.next()?,
            ParamClass::Focal | ParamClass::Extra if param.unit.starts_with("px") => {
                (value * scale * 10.0).round() / 10.0
            }
            ParamClass::Focal | ParamClass::Extra => value,
        });
    }
    Some(Camera { intrinsics: model.with_params(&params).ok()?, width, height })
}

/// By what lengths in px grow from the example to an image of this size; 1 where the model's angles do not depend on them.
fn corner_scale(example: &Intrinsics, width: u64, height: u64) -> Option<f64> {
    if example.model().params.iter().all(|param| param.class == ParamClass::Metadata) {
        return Some(1.0);
    }
    let largest = example.largest_angle();
    let is_fisheye = largest > FRAC_PI_2 + 1e-6;
    let wanted = if is_fisheye { CORNER_DEGREES_OF_FISHEYE } else { CORNER_DEGREES };
    let angle = wanted.to_radians().min(CORNER_OF_FOLD * largest);
    let axis = Frame::axis(example);
    let corner = Vector3::new(angle.sin(), 0.0, axis.z * angle.cos());
    let reach = (example.project(&corner).ok()? - example.project(&axis).ok()?).norm();
    Some(Vector2::new(width as f64, height as f64).norm() / 2.0 / reach)
}

struct FirstExample;

impl Job for FirstExample {
    type Output = Vec<f64>;

    fn run<M: CameraModel<N>, const N: usize>(self, _: &[f64; N]) -> Vec<f64> {
        M::EXAMPLES[0].to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::MODELS;

    #[test]
    fn the_lens_of_every_model_sees_its_whole_image_and_keeps_its_shape_at_any_size() {
        let mut fisheyes = 0;
        for model in MODELS {
            let [small, large] = [1, 4].map(|k| camera(model, 640 * k, 480 * k).unwrap());
            let mut widest: f64 = 0.0;
            for share in [[0.01, 0.01], [0.99, 0.01], [0.5, 0.99], [0.01, 0.99], [0.5, 0.5]] {
                let ray = |camera: &Camera| {
                    let pixel = Frame::of(camera).at(share);
                    camera
                        .intrinsics
                        .unproject(&pixel)
                        .unwrap_or_else(|e| panic!("{}: {e}", model.name))
                };
                let (ray, of_large) = (ray(&small), ray(&large));
                // Lengths are rounded to 0.1 px: an F-Theta lens takes 0.05 px 2^4 times, at a radius of some 300 px.
                assert!((ray - of_large).norm() < 5e-3, "{}: {ray} {of_large}", model.name);
                widest = widest.max(ray.angle(&Frame::axis(&small.intrinsics)).to_degrees());
            }
            assert!((35.0..180.0).contains(&widest), "{}: {widest}", model.name);
            fisheyes += usize::from(widest > 90.0);
        }
        assert!(fisheyes >= 8, "{fisheyes}");
    }
}
