//! How repeatable is the camera calibration that COLMAP gave you?

pub mod camera;
pub mod scene;
pub mod stability;
pub mod stats;
