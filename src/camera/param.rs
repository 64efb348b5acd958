//! The parameters of a camera model: names and classes.

/// One parameter of a camera model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Param {
    /// Its name, unique within the model.
    pub name: &'static str,
    /// What it does: COLMAP's three classes, by which it frees or holds parameters.
    pub class: ParamClass,
    /// A dimensionless polynomial coefficient, which a real lens keeps within [-1, 1].
    pub is_small: bool,
}

/// What a parameter does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParamClass {
    /// A focal length, in px (F-Theta: px/rad).
    Focal,
    /// A coordinate of the principal point, in px.
    PrincipalPoint,
    /// Distortion and all else that is estimated.
    Extra,
    /// Part of the camera's description, never estimated.
    Metadata,
}

pub(super) const fn focal(name: &'static str) -> Param {
    Param { name, class: ParamClass::Focal, is_small: false }
}

pub(super) const fn principal_point(name: &'static str) -> Param {
    Param { name, class: ParamClass::PrincipalPoint, is_small: false }
}

pub(super) const fn polynomial(name: &'static str) -> Param {
    Param { name, class: ParamClass::Extra, is_small: true }
}

pub(super) const fn extra(name: &'static str) -> Param {
    Param { name, class: ParamClass::Extra, is_small: false }
}

pub(super) const fn metadata(name: &'static str) -> Param {
    Param { name, class: ParamClass::Metadata, is_small: false }
}
