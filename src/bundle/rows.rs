//! The rows of one point's sightings: linearised, and weighed by the loss.

use nalgebra::Vector3;

use super::Loss;
use super::chunk::Chunk;
use super::eliminate::View;
use super::linearize::{Row, Run, Sighting};
use super::point::PointBlock;

/// Fills the rows of a point's track and sums its block. Where the loss bends down so far that the point's block is not
/// positive, its curvature is made so, for this point.
#[inline(always)]
pub(super) fn block_of<const W: usize, const FUSED: bool>(
    chunk: &Chunk,
    view: &View<'_>,
    (point, track): (&Vector3<f64>, &[Sighting]),
    rows: &mut [Row],
) -> PointBlock {
    let rows = &mut rows[..track.len()];
    let is_seen = weighed_rows::<W>(chunk, view, point, track, rows, view.bends);
    debug_assert!(is_seen, "a state without a cost is linearised");
    let block = PointBlock::of::<FUSED>(rows);
    if !view.bends || block.is_positive() {
        return block;
    }
    weighed_rows::<W>(chunk, view, point, track, rows, false);
    PointBlock::of::<FUSED>(rows)
}

/// Fills the rows of a point's track, of which the first W parameters count, weighed by the loss; false if a sighting cannot be projected.
#[inline(always)]
fn weighed_rows<const W: usize>(
    chunk: &Chunk,
    view: &View<'_>,
    point: &Vector3<f64>,
    track: &[Sighting],
    rows: &mut [Row],
    bends: bool,
) -> bool {
    let mut start = 0;
    while start < track.len() {
        let camera = chunk.camera_of[track[start].image as usize];
        let is_other = |seen: &Sighting| chunk.camera_of[seen.image as usize] != camera;
        let end = track[start..].iter().position(is_other).map_or(track.len(), |at| start + at);
        let camera = chunk.cameras[camera as usize] as usize;
        let sightings = &track[start..end];
        let run = Run { point: *point, sightings, images: &chunk.images, poses: view.poses };
        let lens = &view.lenses[camera];
        if !(lens.kernel.linearize)(lens, &view.params[camera], &run, &mut rows[start..end]) {
            return false;
        }
        start = end;
    }
    if view.loss != Loss::Squared {
        rows[..track.len()].iter_mut().for_each(|row| weigh::<W>(row, view.loss, bends));
    }
    true
}

/// Turns the rows so that the first is along the residual, and weighs them so that J^T r becomes the gradient of 1/2 rho and
/// J^T J its curvature, but for that of the projection: Triggs' correction.
#[inline(always)]
fn weigh<const W: usize>(row: &mut Row, loss: Loss, bends: bool) {
    let [x, y] = row.residual;
    let square = x * x + y * y;
    let rho = loss.at(square);
    let share = curvature_along(loss, 1.0 + 2.0 * square * rho.curvature / rho.slope, bends);
    let length = square.sqrt();
    let (cosine, sine) = if length > 0.0 { (x / length, y / length) } else { (1.0, 0.0) };
    let across = rho.slope.sqrt();
    let along = across * share.abs().sqrt();
    let [first, second] = &mut row.wrt_point;
    turn(first, second, [along * cosine, along * sine, across * cosine, across * sine]);
    let [first, second] = &mut row.wrt_params;
    let (first, second) = (&mut first[..W], &mut second[..W]);
    turn(first, second, [along * cosine, along * sine, across * cosine, across * sine]);
    row.residual = [length * across * across / along, 0.0];
    row.sign = share.signum();
}

/// (first, second) become (c first + s second, C second - S first)
#[inline(always)]
fn turn(first: &mut [f64], second: &mut [f64], [c, s, across_c, across_s]: [f64; 4]) {
    for (first, second) in first.iter_mut().zip(second) {
        (*first, *second) = (c * *first + s * *second, across_c * *second - across_s * *first);
    }
}

/// The share of the first-order weight that is kept along the residual: what the loss's own curvature is of it, or made positive.
#[inline]
fn curvature_along(loss: Loss, share: f64, bends: bool) -> f64 {
    /// Where a convex loss is straight the system must not become singular; ten times as much, and hundreds of steps are needed.
    const STRAIGHT: f64 = 1e-3;
    /// A loss that bends down drives steps too far where little is left of the weight; of the values tried this needs the fewest.
    const BENT: f64 = 0.3;
    match loss {
        Loss::Squared | Loss::Huber(_) | Loss::SoftL1(_) => share.max(STRAIGHT),
        Loss::Cauchy(_) if bends && share.abs() > STRAIGHT => share,
        Loss::Cauchy(_) if bends => STRAIGHT,
        Loss::Cauchy(_) => share.abs().max(BENT),
    }
}
