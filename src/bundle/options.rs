//! What moves, what a residual costs, and when to stop.

use std::collections::BTreeMap;
use std::fmt;

use super::Loss;
use crate::camera::{Param, ParamClass};
use crate::least_squares;
use crate::scene::CameraId;

/// How to adjust.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Which blocks move.
    pub mode: Mode,
    /// Which intrinsics move, where the mode lets intrinsics move.
    pub refine: Refine,
    /// What a residual costs.
    pub loss: Loss,
    /// What is known of intrinsics beforehand.
    pub priors: Vec<Prior>,
    /// Between which values intrinsics stay.
    pub bounds: Vec<Bound>,
    /// When to stop.
    pub stop: least_squares::Options,
    /// Memory that the adjustment may take, in bytes; any if none.
    pub memory: Option<usize>,
}

/// Which blocks move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Poses, points and intrinsics.
    #[default]
    SelfCalibration,
    /// Poses and points.
    BundleAdjustment,
    /// Poses alone.
    OnlyPose,
    /// Points alone.
    OnlyLandmarks,
    /// Intrinsics alone.
    OnlyIntrinsics,
}

impl Mode {
    /// Whether poses move.
    pub fn moves_poses(self) -> bool {
        matches!(self, Self::SelfCalibration | Self::BundleAdjustment | Self::OnlyPose)
    }

    /// Whether points move.
    pub fn moves_points(self) -> bool {
        matches!(self, Self::SelfCalibration | Self::BundleAdjustment | Self::OnlyLandmarks)
    }

    /// Whether intrinsics move.
    pub fn moves_intrinsics(self) -> bool {
        matches!(self, Self::SelfCalibration | Self::OnlyIntrinsics)
    }
}

/// A parameter of one camera, or of every one that has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Of {
    /// The camera; any if none.
    pub camera: Option<CameraId>,
    /// The parameter's name.
    pub name: String,
}

/// What is known of a parameter beforehand: it is near the mean, as a normal variable. For the adjustment it is one more residual of
/// 1 px for each std that the parameter is off; the covariance takes the std as it is, whatever the noise of the pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior {
    /// Of what; of a parameter that does not move it says nothing.
    pub of: Of,
    /// Where it is.
    pub mean: f64,
    /// How well that is known.
    pub std: f64,
}

/// Between which values a parameter stays. A start that is outside is put on the bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// Of what.
    pub of: Of,
    /// The least value; may be infinite.
    pub least: f64,
    /// The greatest value; may be infinite.
    pub most: f64,
}

impl fmt::Display for Of {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.camera {
            Some(id) => write!(f, "{}:{}", id.0, self.name),
            None => f.write_str(&self.name),
        }
    }
}

impl fmt::Display for Prior {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}={}+-{}", self.of, self.mean, self.std)
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}={}..{}", self.of, self.least, self.most)
    }
}

/// Some intrinsics of a camera.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Which {
    /// All of a class.
    Class(ParamClass),
    /// The one of this name.
    Named(String),
}

/// Which intrinsics move. What describes a camera and is never estimated never moves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refine {
    /// Of the cameras not named below.
    pub others: Vec<Which>,
    /// Of these cameras.
    pub cameras: BTreeMap<CameraId, Vec<Which>>,
}

impl Default for Refine {
    /// COLMAP's: focal length and distortion move, the principal point does not.
    fn default() -> Self {
        let others = vec![Which::Class(ParamClass::Focal), Which::Class(ParamClass::Extra)];
        Self { others, cameras: BTreeMap::new() }
    }
}

impl Refine {
    /// All that can move.
    pub fn all() -> Self {
        let classes = [ParamClass::Focal, ParamClass::PrincipalPoint, ParamClass::Extra];
        Self { others: classes.map(Which::Class).to_vec(), cameras: BTreeMap::new() }
    }

    /// What moves of this camera.
    pub fn of(&self, camera: CameraId) -> &[Which] {
        self.cameras.get(&camera).unwrap_or(&self.others)
    }
}

impl Of {
    /// Whether it is of this camera's parameter of this name.
    pub fn is(&self, camera: CameraId, name: &str) -> bool {
        self.name == name && self.camera.is_none_or(|own| own == camera)
    }
}

impl Which {
    /// Whether this parameter is among them.
    pub fn is(&self, param: &Param) -> bool {
        let is_chosen = match self {
            Self::Class(class) => *class == param.class,
            Self::Named(name) => name == param.name,
        };
        is_chosen && param.class != ParamClass::Metadata
    }
}
