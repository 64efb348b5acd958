//! The parameters of a camera model: names and classes, and how a model states its own.

/// One parameter of a camera model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Param {
    /// Its name, unique within the model.
    pub name: &'static str,
    /// What it does: COLMAP's three classes, by which it frees or holds parameters.
    pub class: ParamClass,
    /// The unit of its values; empty where they have none.
    pub unit: &'static str,
    /// A dimensionless polynomial coefficient, which a real lens keeps within -1 and 1.
    pub is_small: bool,
    /// The name that most models have for what this parameter does; its own, unless it goes by another here.
    pub shared_name: &'static str,
    /// The value at which it does nothing.
    pub neutral: f64,
    /// The least and the greatest value for which the formula is a lens; files may hold others.
    pub range: [f64; 2],
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

impl Param {
    const fn new(name: &'static str, class: ParamClass, unit: &'static str) -> Self {
        let range = [f64::NEG_INFINITY, f64::INFINITY];
        Self { name, class, unit, is_small: false, shared_name: name, neutral: 0.0, range }
    }

    /// The same in another unit than its kind has.
    pub const fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// The same, which most models call otherwise.
    pub const fn known_as(self, shared_name: &'static str) -> Self {
        Self { shared_name, ..self }
    }

    /// The same, without effect at this value instead of at zero.
    pub const fn neutral_at(self, neutral: f64) -> Self {
        Self { neutral, ..self }
    }

    /// The same, a lens only for values from `min` to `max`.
    pub const fn within(self, min: f64, max: f64) -> Self {
        Self { range: [min, max], ..self }
    }

    /// The same, a lens only for values above zero.
    pub const fn positive(self) -> Self {
        self.within(f64::MIN_POSITIVE, f64::INFINITY)
    }
}

/// A focal length in px.
pub const fn focal(name: &'static str) -> Param {
    Param::new(name, ParamClass::Focal, "px")
}

/// A coordinate of the principal point.
pub const fn principal_point(name: &'static str) -> Param {
    Param::new(name, ParamClass::PrincipalPoint, "px")
}

/// A dimensionless polynomial coefficient, which a real lens keeps within -1 and 1.
pub const fn polynomial(name: &'static str) -> Param {
    Param { is_small: true, ..extra(name) }
}

/// Distortion of another kind, or what else is estimated.
pub const fn extra(name: &'static str) -> Param {
    Param::new(name, ParamClass::Extra, "")
}

/// Part of the description of the camera, in px.
pub const fn metadata(name: &'static str) -> Param {
    Param::new(name, ParamClass::Metadata, "px")
}
