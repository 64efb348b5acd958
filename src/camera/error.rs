//! Why something is no camera.

use std::fmt;

use super::{MODELS, Param, ParamClass};

/// Why something is no camera.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// No model has this name or number.
    #[error("{0}")]
    UnknownModel(ModelName),
    /// A model was given too few or too many parameters.
    #[error("{model} takes {want} parameters, found {got}")]
    ParamCount {
        /// The model's name.
        model: &'static str,
        /// How many it takes.
        want: usize,
        /// How many it was given.
        got: usize,
    },
    /// A focal length is NaN or infinite.
    #[error("the focal length is not finite")]
    FocalLengthNotFinite,
    /// The principal point is NaN or infinite.
    #[error("the principal point is not finite")]
    PrincipalPointNotFinite,
    /// Another parameter is NaN or infinite.
    #[error("{name} is {value}, not a finite number")]
    DistortionNotFinite {
        /// The parameter's name.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A focal length is zero or negative: files may say so, no lens does. One focal length stands for both.
    #[error("the focal lengths are {fx} and {fy}, and must be above 0")]
    FocalLengthNotPositive {
        /// Along x, in px.
        fx: f64,
        /// Along y, in px.
        fy: f64,
    },
    /// A parameter has a value for which its model's formula is no lens.
    #[error("{param} is {value}, and must be {}", Range(*min, *max))]
    ParameterOutOfRange {
        /// The parameter's name.
        param: &'static str,
        /// Its value.
        value: f64,
        /// The least value that it may have.
        min: f64,
        /// The greatest.
        max: f64,
    },
    /// The point is where the camera is: it has no direction.
    #[error("the point is at the camera's centre")]
    PointAtCameraCenter,
    /// The point is behind a camera that sees only what is before it.
    #[error("the point is behind the camera: its z is {z}, and must be above {min_z}")]
    PointBehindCamera {
        /// The point's depth, along the direction in which the camera looks.
        z: f64,
        /// The least depth that is seen.
        min_z: f64,
    },
    /// The point is further from the axis than the lens sees, or than its distortion is one-to-one.
    #[error("the point is beyond the angle that the lens sees")]
    ProjectionOutOfBounds,
    /// The formula divides by something that is not positive there.
    #[error("projecting divides by {value}, which must be above 0")]
    DenominatorTooSmall {
        /// What it divides by, for the point at unit distance.
        value: f64,
    },
    /// No point is seen at the pixel.
    #[error("no ray leads to the pixel ({x}, {y})")]
    PointOutsideImage {
        /// Its x, in px.
        x: f64,
        /// Its y, in px.
        y: f64,
    },
    /// A calculation has no answer that numbers can tell.
    #[error("{operation}: {details}")]
    NumericalError {
        /// What was to be found.
        operation: &'static str,
        /// Why it was not.
        details: String,
    },
    /// Slices that describe the same points differ in length.
    #[error("{slice} holds {got} numbers, and needs {want}")]
    SliceLength {
        /// Which slice.
        slice: &'static str,
        /// How many numbers it needs.
        want: usize,
        /// How many it holds.
        got: usize,
    },
}

struct Range(f64, f64);

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match *self {
            Self(min, max) if min >= f64::MIN_POSITIVE && max.is_infinite() => {
                write!(f, "above 0")
            }
            Self(min, max) => write!(f, "from {min} to {max}"),
        }
    }
}

impl CameraError {
    pub(super) fn not_finite(param: &Param, value: f64) -> Self {
        match param.class {
            ParamClass::Focal => Self::FocalLengthNotFinite,
            ParamClass::PrincipalPoint => Self::PrincipalPointNotFinite,
            ParamClass::Extra | ParamClass::Metadata => {
                Self::DistortionNotFinite { name: param.name, value }
            }
        }
    }
}

/// How a file named a model that does not exist.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ModelName {
    /// By name, in text.
    Text(String),
    /// By number, in binary.
    Id(i32),
}

impl fmt::Display for ModelName {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Id(id) => write!(f, "no camera model has the id {id}"),
            Self::Text(name) => {
                write!(f, "no camera model is called `{}`", name.escape_debug())?;
                match nearest(name) {
                    Some(known) => write!(f, ": did you mean {known}?"),
                    None => Ok(()),
                }
            }
        }
    }
}

/// The known name nearest to this one, when it is near enough to be a slip of the keyboard.
fn nearest(name: &str) -> Option<&'static str> {
    /// Below this similarity the guess would be noise: `banana` reaches 0.3 with some model.
    const NEAR: f64 = 0.75;
    let upper = name.to_uppercase();
    let similarity = |known: &str| strsim::normalized_damerau_levenshtein(&upper, known);
    MODELS
        .iter()
        .map(|model| (similarity(model.name), model.name))
        .filter(|(near, _)| *near >= NEAR)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, known)| known)
}
