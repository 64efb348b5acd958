//! The second pass over a chunk's points: each follows the poses and the intrinsics.

use multiversion::multiversion;
use nalgebra::Vector3;

use super::chunk::Chunk;
use super::eliminate::View;
use super::linearize::{MOST_PARAMS, Params, Row};
use super::products::fused;
use super::rows::block_of;

/// What points follow.
pub(super) struct Followed<'a> {
    pub poses: &'a [[f64; 6]],
    pub params: &'a [Params],
    /// That of the step.
    pub damping: f64,
}

/// Room for the rows of the chunk's longest track, and where its points' steps go.
pub(super) struct Room<'a> {
    pub rows: &'a mut [Row],
    pub steps: &'a mut [Vector3<f64>],
}

/// What the pass tells of the points' steps.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PointStep {
    /// The square, weighed by the diagonal of J^T J.
    pub weighed_square: f64,
    /// The square of the length.
    pub square: f64,
}

/// Steps of a chunk's points: V step = -J^T (r + J_pose motion + J_params step).
pub(super) fn follow(
    chunk: &Chunk,
    view: &View<'_>,
    followed: &Followed<'_>,
    room: &mut Room<'_>,
) -> PointStep {
    match view.width {
        0 => of_width::<0>(chunk, view, followed, room),
        1..=4 => of_width::<4>(chunk, view, followed, room),
        5..=8 => of_width::<8>(chunk, view, followed, room),
        _ => of_width::<MOST_PARAMS>(chunk, view, followed, room),
    }
}

#[multiversion(targets("x86_64+avx2+fma"))]
fn of_width<const W: usize>(
    chunk: &Chunk,
    view: &View<'_>,
    followed: &Followed<'_>,
    room: &mut Room<'_>,
) -> PointStep {
    if multiversion::target::target_cfg_f!(target_feature = "fma") {
        step_points::<W, true>(chunk, view, followed, room)
    } else {
        step_points::<W, false>(chunk, view, followed, room)
    }
}

#[inline(always)]
fn step_points<const W: usize, const FUSED: bool>(
    chunk: &Chunk,
    view: &View<'_>,
    followed: &Followed<'_>,
    room: &mut Room<'_>,
) -> PointStep {
    let mut total = PointStep::default();
    let mut start = 0;
    let points = &view.points[chunk.points.clone()];
    let Room { rows, steps } = room;
    for ((&end, point), step) in chunk.ends.iter().zip(points).zip(&mut **steps) {
        let track = &chunk.sightings[start..end as usize];
        start = end as usize;
        let rows = &mut rows[..track.len()];
        let block = block_of::<W, FUSED>(chunk, view, (point, track), rows);
        let mut gradient = block.gradient;
        for (sighting, row) in track.iter().zip(&*rows) {
            let image = sighting.image as usize;
            let camera = chunk.cameras[chunk.camera_of[image] as usize] as usize;
            let [a, b, c, x, y, z] = followed.poses[chunk.images[image] as usize];
            let moved = Vector3::new(a, b, c).cross(point) + Vector3::new(x, y, z);
            for (axis, sign) in [row.sign, 1.0].into_iter().enumerate() {
                let mut change = 0.0;
                for (j, step) in row.wrt_point[axis].iter().zip(&moved) {
                    change = fused::<FUSED>(*j, *step, change);
                }
                for (j, step) in row.wrt_params[axis].iter().zip(&followed.params[camera]).take(W) {
                    change = fused::<FUSED>(*j, *step, change);
                }
                for (sum, j) in gradient.iter_mut().zip(row.wrt_point[axis]) {
                    *sum = fused::<FUSED>(sign * j, change, *sum);
                }
            }
        }
        let inverse = block.factor(followed.damping);
        *step = -Vector3::from(inverse.transpose_times(&inverse.times(&gradient)));
        let [xx, yy, zz] = block.diagonal;
        total.weighed_square += xx * step.x * step.x + yy * step.y * step.y + zz * step.z * step.z;
        total.square += step.norm_squared();
    }
    total
}
