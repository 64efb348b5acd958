//! Why a scene cannot be adjusted.

use crate::scene::{CameraId, ImageId};

/// Why a scene cannot be adjusted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BundleError {
    /// A lone list of cameras.
    #[error("there are no images and points to adjust, only cameras")]
    NoGeometry,
    /// An image without a pose.
    #[error(
        "image {0} has no pose: its quaternion is zero, or its sensor's place on the rig is unknown"
    )]
    NoPose(ImageId),
    /// Every observation was dropped.
    #[error(
        "no observation is left: {unprojectable} of {total} cannot be projected at the start, the others are of points that only one image sees"
    )]
    NoObservation {
        /// All that the scene has.
        total: usize,
        /// Those that no lens sees.
        unprojectable: usize,
    },
    /// The cost at the start overflows.
    #[error("the residuals at the start are beyond all numbers")]
    NoCost,
    /// An adjusted camera is none.
    #[error("camera {0} was adjusted to what is no camera: {1}")]
    NoLens(CameraId, crate::camera::CameraError),
    /// A camera was named that the scene does not have.
    #[error("there is no camera {0}")]
    NoCamera(CameraId),
    /// A parameter was named that no camera has, or not the one for which it was named.
    #[error("{} has no parameter `{name}`; there are {known}", match camera { Some(id) => format!("camera {id}"), None => "no camera".to_owned() })]
    NoParam {
        /// The name.
        name: String,
        /// The camera for which it was named, if for one.
        camera: Option<CameraId>,
        /// The names that would have been understood.
        known: String,
    },
    /// The problem does not fit in memory.
    #[error("adjusting {images} images takes {} MB of memory, and {} MB are there", needed >> 20, limit >> 20)]
    Memory {
        /// The images.
        images: usize,
        /// What it would take, in bytes.
        needed: usize,
        /// What it may take, in bytes.
        limit: usize,
    },
    /// Pixels or a start that do not go with the scene.
    #[error("the pixels or the start are of another scene: it has other images, points or cameras")]
    OtherScene,
    /// More than 2^32 observations or blocks of them.
    #[error("a model of so many observations cannot be counted in 32 bits")]
    TooLarge,
}
