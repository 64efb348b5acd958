//! The rows of one point's sightings: linearised, and weighed by the loss.

use nalgebra::Vector3;

use super::Loss;
use super::chunk::Chunk;
use super::eliminate::View;
use super::linearize::{Row, Run, Sighting};

/// Fills the rows of a point's track, of which the first W parameters count, weighed by the loss; false if a sighting cannot be projected.
#[inline(always)]
pub(super) fn weighed_rows<const W: usize>(
    chunk: &Chunk,
    view: &View<'_>,
    point: &Vector3<f64>,
    track: &[Sighting],
    rows: &mut [Row],
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
        rows[..track.len()].iter_mut().for_each(|row| weigh::<W>(row, view.loss));
    }
    true
}

/// Triggs' correction: J^T r becomes the gradient of 1/2 rho, J^T J its curvature where that is positive enough.
#[inline(always)]
fn weigh<const W: usize>(row: &mut Row, loss: Loss) {
    let [x, y] = row.residual;
    let square = x * x + y * y;
    let rho = loss.at(square);
    let along = curvature_along(loss, 1.0 + 2.0 * square * rho.curvature / rho.slope);
    let (root, share) = (rho.slope.sqrt(), along.sqrt());
    // J - (1 - share) r r^T J / |r|^2
    let bend = if square > 0.0 { (1.0 - share) / square } else { 0.0 };
    let correct = |[first, second]: [f64; 2]| {
        let shift = bend * (x * first + y * second);
        [root * (first - shift * x), root * (second - shift * y)]
    };
    for axis in 0..3 {
        let column = correct([row.wrt_point[0][axis], row.wrt_point[1][axis]]);
        [row.wrt_point[0][axis], row.wrt_point[1][axis]] = column;
    }
    for param in 0..W {
        let column = correct([row.wrt_params[0][param], row.wrt_params[1][param]]);
        [row.wrt_params[0][param], row.wrt_params[1][param]] = column;
    }
    row.residual = [x, y].map(|value| value * root / share);
}

/// The share of the first-order weight that is kept along the residual: what the loss's own curvature is of it, kept positive.
#[inline]
fn curvature_along(loss: Loss, share: f64) -> f64 {
    /// Where a convex loss is straight the system must not become singular; ten times as much, and hundreds of steps are needed.
    const STRAIGHT: f64 = 1e-3;
    /// A loss that bends down drives steps too far where little is left of the weight; of the values tried this needs the fewest.
    const BENT: f64 = 0.3;
    match loss {
        Loss::Squared | Loss::Huber(_) | Loss::SoftL1(_) => share.max(STRAIGHT),
        Loss::Cauchy(_) => share.abs().max(BENT),
    }
}
