//! One camera model to another: exact where the other one can say the same, else fitted, with its error in pixels.
//!
//! Models are told apart by nothing but what they state of themselves.

mod error;
mod exact;
mod fit;
mod start;
#[cfg(test)]
mod tests;

use nalgebra::Vector2;

pub use error::ConvertError;

use crate::camera::{Grid, Intrinsics, Model, Pair, ParamClass};

/// A camera in another model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converted {
    /// The other model, with its parameters.
    pub intrinsics: Intrinsics,
    /// How well they say the same.
    pub how: How,
}

/// How well two cameras agree over an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum How {
    /// No pixel moves by more than [`EXACT_PX`], and none has a ray in one of them only.
    Exact,
    /// As well as least squares can do.
    Fitted(Fit),
}

/// What a fit leaves, over the cells of a [`Grid`] that have a ray: the target's pixel of a cell's ray less the cell's centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Root of the mean of |difference|^2, in px.
    pub rms_px: f64,
    /// The largest |difference|, in px.
    pub max_px: f64,
    /// The share of the image's cells that have a ray.
    pub seen_share: f64,
    /// The largest angle of these rays from the optical axis, in radians.
    pub largest_angle: f64,
}

/// What to do with a lens that folds inside its image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Folds {
    /// Refuse to fit it, or to fit to it.
    Refused,
    /// Fit what has a ray, and leave out the rest of the image.
    LeftOut,
}

/// A camera in a model that contains its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Contained {
    /// The same lens.
    pub intrinsics: Intrinsics,
    /// For each of its parameters the place of the one that it is in the camera's own model; a single focal length stands at two
    /// places. None where a parameter is at its neutral value.
    pub origins: Vec<Option<usize>>,
}

/// What rounding may do to a pixel, in px.
pub const EXACT_PX: f64 = 1e-9;

/// The camera of an image of this size in px, as a `target`.
///
/// Parameters that both models share are carried over, and that is all when it is exact. Otherwise all of the target's are
/// fitted, the principal point included, from several starts, and validated.
///
/// ```
/// use calibstab::camera::Model;
/// use calibstab::convert::{Folds, How, convert};
///
/// let camera = Model::named("SIMPLE_RADIAL")?.with_params(&[500.0, 320.0, 240.0, -0.1])?;
/// let to = |name| convert(&camera, [640, 480], Model::named(name)?, Folds::Refused);
/// assert_eq!(to("OPENCV")?.how, How::Exact);
/// assert!(matches!(to("OPENCV_FISHEYE")?.how, How::Fitted(fit) if fit.rms_px < 0.01));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn convert(
    source: &Intrinsics,
    [width, height]: [u32; 2],
    target: &'static Model,
    folds: Folds,
) -> Result<Converted, ConvertError> {
    let grid = Grid::new(width.into(), height.into());
    let pixels = || grid.pixels().chain(corners(width, height));
    if let Some(intrinsics) = exact::carried(source, target, pixels()) {
        return Ok(Converted { intrinsics, how: How::Exact });
    }
    check_models(source, target)?;
    source.validate()?;
    let from = source.model().name;
    if folds == Folds::Refused && source.folds_inside(width, height) {
        let unseen_share = source.share_without_ray(width, height);
        return Err(ConvertError::SourceFolds { model: from, unseen_share });
    }
    let pairs: Vec<Pair> =
        grid.pixels().filter_map(|pixel| Some((source.unproject(&pixel).ok()?, pixel))).collect();
    let largest_angle =
        pairs.iter().map(|(ray, _)| source.angle_from_axis(ray)).fold(0.0, f64::max);
    if pairs.len() < target.params.len() {
        return Err(ConvertError::NothingSeen { model: from });
    }
    if largest_angle >= target.widest_angle {
        let widest_angle = target.widest_angle;
        return Err(ConvertError::TooWide { model: target.name, largest_angle, widest_angle });
    }
    let no_fit = ConvertError::NoFit { model: target.name, largest_angle };
    let starts = start::starts(source, target, &pairs);
    let fitted = starts.iter().filter_map(|start| fit::fit(start, &pairs));
    let intrinsics =
        fitted.reduce(|a, b| if b.cost < a.cost { b } else { a }).ok_or(no_fit)?.camera;
    if folds == Folds::Refused && intrinsics.folds_inside(width, height) {
        return Err(ConvertError::TargetFolds { model: target.name });
    }
    if exact::is_exact(source, &intrinsics, pixels()) {
        return Ok(Converted { intrinsics, how: How::Exact });
    }
    let seen_share = pairs.len() as f64 / grid.cell_count() as f64;
    let [rms_px, max_px] = fit::errors_px(&intrinsics, &pairs);
    let fit = Fit { rms_px, max_px, seen_share, largest_angle };
    Ok(Converted { intrinsics, how: How::Fitted(fit) })
}

/// The camera of an image of this size in px, in a model that contains its own; none in any other. Nothing is fitted.
pub fn contained(
    source: &Intrinsics,
    [width, height]: [u32; 2],
    target: &'static Model,
) -> Option<Contained> {
    let origins = exact::origins(source.model(), target)?;
    if !(0..source.params().len()).all(|at| origins.contains(&Some(at))) {
        return None;
    }
    let grid = Grid::new(width.into(), height.into());
    let pixels = grid.pixels().chain(corners(width, height));
    let intrinsics = exact::carried(source, target, pixels)?;
    Some(Contained { intrinsics, origins })
}

/// Whether one of these models can ever come near the other.
fn check_models(source: &Intrinsics, target: &'static Model) -> Result<(), ConvertError> {
    let from = source.model();
    let is_map = |model: &&Model| model.params.iter().any(|p| p.class == ParamClass::Metadata);
    if let Some(map) = [from, target].into_iter().find(is_map) {
        return Err(ConvertError::NotALens { model: map.name });
    }
    let plain = start::undistorted(target, Vector2::zeros(), Vector2::repeat(1.0));
    if plain.is_some_and(|plain| plain.optical_axis().dot(&source.optical_axis()) < 0.0) {
        return Err(ConvertError::LooksAway { from: from.name, to: target.name });
    }
    Ok(())
}

/// The corners of the image, which no cell's centre reaches.
fn corners(width: u32, height: u32) -> impl Iterator<Item = Vector2<f64>> {
    let (right, bottom) = (f64::from(width), f64::from(height));
    [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)]
        .into_iter()
        .map(|(x, y)| Vector2::new(x, y))
}
