//! The image's edges, and where a camera looks, for every model alike.

use nalgebra::{Vector2, Vector3};

use crate::camera::{Intrinsics, ParamClass};
use crate::scene::Camera;

/// The pixels of an image: from the first corner to the last.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    first: Vector2<f64>,
    last: Vector2<f64>,
}

impl Frame {
    /// The image of this camera. A model without a principal point counts its pixels from the image's centre.
    pub fn of(camera: &Camera) -> Self {
        let size = Vector2::new(camera.width as f64, camera.height as f64);
        let counts_from_centre = camera
            .intrinsics
            .model()
            .params
            .iter()
            .all(|param| matches!(param.class, ParamClass::Focal | ParamClass::Extra));
        let first = if counts_from_centre { -size / 2.0 } else { Vector2::zeros() };
        Self { first, last: first + size }
    }

    /// Whether the pixel lies in the image.
    pub fn holds(&self, pixel: &Vector2<f64>) -> bool {
        *pixel >= self.first && *pixel <= self.last
    }

    /// The pixel at this share of width and height.
    #[cfg(test)]
    pub fn at(&self, share: [f64; 2]) -> Vector2<f64> {
        self.first + (self.last - self.first).component_mul(&Vector2::from(share))
    }

    /// The direction in which the camera looks: +Z, or -Z for the models of Bundle Adjustment in the Large.
    pub fn axis(intrinsics: &Intrinsics) -> Vector3<f64> {
        let ahead = Vector3::z();
        if intrinsics.project(&ahead).is_ok() { ahead } else { -ahead }
    }
}
