//! Why images cannot be chosen.

use crate::bundle::BundleError;
use crate::scene::CameraId;

/// Why images cannot be chosen.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SelectionError {
    /// A scene that cannot be adjusted.
    #[error(transparent)]
    Bundle(#[from] BundleError),
    /// No parameter moves.
    #[error("no parameter of any camera is free: there is nothing to calibrate")]
    NothingFree,
    /// None are asked for.
    #[error("no images are asked for; at least two are needed")]
    TooFew,
    /// More are asked for than hang together.
    #[error(
        "{size} are asked for, and of the {pool} there are {connected} that shared points hold together"
    )]
    TooMany {
        /// How many are asked for.
        size: usize,
        /// How many there are to choose from.
        pool: usize,
        /// How many of them belong to the largest part.
        connected: usize,
    },
    /// The camera is not in the pool.
    #[error("there is no image of camera {0} to choose")]
    NoCamera(CameraId),
    /// More cameras than images.
    #[error("{size} cannot show all {cameras} cameras; aim at one camera")]
    TooManyCameras {
        /// How many are asked for.
        size: usize,
        /// How many cameras there are.
        cameras: usize,
    },
    /// A camera whose images do not hang together with the others.
    #[error(
        "camera {0} shares too few points with the images chosen for others; aim at one camera, or choose whole frames"
    )]
    Unreached(CameraId),
    /// Not even all images determine the camera.
    #[error("all {0} together leave a direction of the intrinsics open: no subset determines it")]
    Undetermined(usize),
    /// Beyond what the exact heuristic can do.
    #[error("the exact heuristic takes up to {most} images, and {size} are asked for")]
    TooLarge {
        /// How many are asked for.
        size: usize,
        /// How many it takes.
        most: usize,
    },
}
