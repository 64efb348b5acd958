//! Why a camera has no counterpart in another model.

use crate::camera::CameraError;

/// Why a camera has no counterpart in another model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConvertError {
    /// The camera is none to begin with.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// One of the models is a map of all directions.
    #[error("{model} is a map of all directions, not a lens: there is nothing to fit")]
    NotALens {
        /// The model.
        model: &'static str,
    },
    /// One looks along Z, the other along -Z.
    #[error("{from} and {to} look in opposite directions along Z: no ray is seen by both")]
    LooksAway {
        /// The camera's model.
        from: &'static str,
        /// The model wanted.
        to: &'static str,
    },
    /// The camera itself folds inside its image.
    #[error("{model} folds inside the image: {} of its pixels have no ray", percent(*unseen_share))]
    SourceFolds {
        /// The camera's model.
        model: &'static str,
        /// The share of the pixels without a ray.
        unseen_share: f64,
    },
    /// Too few cells of the image have a ray.
    #[error("{model} sees next to nothing in the image")]
    NothingSeen {
        /// The camera's model.
        model: &'static str,
    },
    /// The image shows more than any lens of the wanted model can see.
    #[error(
        "the image reaches {:.1}° from the optical axis, {model} sees less than {:.0}°",
        largest_angle.to_degrees(),
        widest_angle.to_degrees()
    )]
    TooWide {
        /// The model wanted.
        model: &'static str,
        /// How far from the axis the image reaches, in radians.
        largest_angle: f64,
        /// How far the model sees at most, in radians.
        widest_angle: f64,
    },
    /// No lens of the wanted model was found that sees all that the image shows, and is the best of those near it.
    #[error(
        "{model} comes nowhere near without folding inside the image, which reaches {:.1}° from the optical axis",
        largest_angle.to_degrees()
    )]
    NoFit {
        /// The model wanted.
        model: &'static str,
        /// How far from the axis the image reaches, in radians.
        largest_angle: f64,
    },
    /// The nearest lens of the wanted model folds inside the image.
    #[error("the nearest {model} folds inside the image")]
    TargetFolds {
        /// The model wanted.
        model: &'static str,
    },
}

/// A share of pixels, of which one in a million may be the news.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 0.1 { format!("{percent:.1} %") } else { format!("{percent:.4} %") }
}
