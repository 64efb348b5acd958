//! Conversions that lose nothing.

use nalgebra::Vector2;

use super::EXACT_PX;
use crate::camera::{Intrinsics, Model, Param, ParamClass};

/// For each parameter of the target the place of the source's that it shares, none where it has no effect at its neutral value;
/// none when the source has no focal length for the target's.
pub(super) fn origins(source: &Model, target: &Model) -> Option<Vec<Option<usize>>> {
    let has = || source.params.iter().enumerate();
    let focals: Vec<usize> =
        has().filter(|(_, param)| param.class == ParamClass::Focal).map(|(at, _)| at).collect();
    let mut next_focal = focals.iter().chain(focals.last().into_iter().cycle());
    let origin = |param: &Param| match param.class {
        ParamClass::Focal => next_focal.next().copied().map(Some),
        class => {
            let is_same =
                |other: &Param| other.class == class && other.shared_name == param.shared_name;
            Some(has().find(|(_, other)| is_same(other)).map(|(at, _)| at))
        }
    };
    target.params.iter().map(origin).collect()
}

/// The target with all parameters that it shares with the source, the others without effect; none when it sees otherwise in
/// some of these pixels. What the target lacks is left behind: whether that mattered, the pixels tell.
pub(super) fn carried(
    source: &Intrinsics,
    target: &'static Model,
    pixels: impl Iterator<Item = Vector2<f64>>,
) -> Option<Intrinsics> {
    let origins = origins(source.model(), target)?;
    let value = |(param, origin): (&Param, &Option<usize>)| {
        origin.map_or(param.neutral, |at| source.params()[at])
    };
    let params: Vec<f64> = target.params.iter().zip(&origins).map(value).collect();
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
