//! Conversions that lose nothing.

use nalgebra::Vector2;

use super::EXACT_PX;
use crate::camera::{Intrinsics, Model, Param, ParamClass};

/// The target with all parameters that it shares with the source, the others without effect; none when it sees otherwise in
/// some of these pixels. What the target lacks is left behind: whether that mattered, the pixels tell.
pub(super) fn carried(
    source: &Intrinsics,
    target: &'static Model,
    pixels: impl Iterator<Item = Vector2<f64>>,
) -> Option<Intrinsics> {
    let has = || source.model().params.iter().zip(source.params().iter().copied());
    let focals: Vec<f64> = has()
        .filter(|(param, _)| param.class == ParamClass::Focal)
        .map(|(_, focal)| focal)
        .collect();
    let mut next_focal = focals.iter().chain(focals.last().into_iter().cycle());
    let value = |param: &Param| match param.class {
        ParamClass::Focal => next_focal.next().copied(),
        class => {
            let is_same =
                |other: &Param| other.class == class && other.shared_name == param.shared_name;
            let shared = has().find(|(other, _)| is_same(other));
            Some(shared.map_or(param.neutral, |(_, value)| value))
        }
    };
    let params: Vec<f64> = target.params.iter().map(value).collect::<Option<_>>()?;
    let carried = target.with_params(&params).ok()?;
    is_exact(source, &carried, pixels).then_some(carried)
}

/// Whether both see the same in each of these pixels, or both see nothing there.
pub(super) fn is_exact(
    source: &Intrinsics,
    target: &Intrinsics,
    mut pixels: impl Iterator<Item = Vector2<f64>>,
) -> bool {
    pixels.all(|pixel| match source.unproject(&pixel) {
        Ok(ray) => target.project(&ray).is_ok_and(|there| (there - pixel).norm() <= EXACT_PX),
        Err(_) => target.unproject(&pixel).is_err(),
    })
}
