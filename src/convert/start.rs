//! Where a fit starts.

use nalgebra::Vector2;

use super::fit::mean_square;
use crate::camera::{Intrinsics, Model, Pair, Param, ParamClass};

/// Focal lengths to start from are those that the source has on its axis, times 2^(n / 2) for n up to this, either way: lenses
/// that bend strongly there, as FOV does, call another length so.
const HALF_OCTAVES: i32 = 4;
/// So many of the starts are followed: the best may lead to a side valley.
const FOLLOWED: usize = 3;
/// A linear first estimate needs no more pairs than this.
const MOST_PAIRS: usize = 400;

/// The starts that see all of the rays, best first.
pub(super) fn starts(
    source: &Intrinsics,
    target: &'static Model,
    pairs: &[Pair],
) -> Vec<Intrinsics> {
    let Some((centre, focals)) = on_axis(source) else {
        return Vec::new();
    };
    let some: Vec<Pair> = pairs.iter().step_by(1 + pairs.len() / MOST_PAIRS).copied().collect();
    let mut found: Vec<(f64, Intrinsics)> = Vec::new();
    for octaves in (-HALF_OCTAVES..=HALF_OCTAVES).map(|n| 0.5 * f64::from(n)) {
        let plain = undistorted(target, centre, focals * octaves.exp2());
        let estimated = plain.and_then(|plain| plain.estimate_distortion(&some).ok());
        let starts = [plain, estimated].into_iter().flatten();
        found.extend(starts.filter_map(|start| Some((mean_square(&start, pairs)?, start))));
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(FOLLOWED);
    found.into_iter().map(|(_, start)| start).collect()
}

/// The target with this principal point and these focal lengths, and no distortion.
pub(super) fn undistorted(
    target: &'static Model,
    centre: Vector2<f64>,
    focals: Vector2<f64>,
) -> Option<Intrinsics> {
    let count = target.params.iter().filter(|param| param.class == ParamClass::Focal).count();
    let one = (focals.x * focals.y).sqrt();
    let mut focals = if count > 1 { vec![focals.x, focals.y] } else { vec![one] }.into_iter();
    let mut centre = centre.iter().copied();
    let value = |param: &Param| match param.class {
        ParamClass::Focal => focals.next(),
        ParamClass::PrincipalPoint => centre.next(),
        ParamClass::Extra | ParamClass::Metadata => Some(param.neutral),
    };
    target.with_params(&target.params.iter().map(value).collect::<Option<Vec<f64>>>()?).ok()
}

/// The principal point, and the focal lengths there: px per radian along x and y.
fn on_axis(camera: &Intrinsics) -> Option<(Vector2<f64>, Vector2<f64>)> {
    let at = camera.linearize(&camera.optical_axis())?;
    Some((at.pixel, Vector2::new(at.wrt_point[(0, 0)].abs(), at.wrt_point[(1, 1)].abs())))
}
