//! The rays of the pixels of a grid in several lenses: which there are, and where a consensus starts from them.

use nalgebra::{Matrix2x3, Matrix3, Vector2, Vector3};
use rayon::prelude::*;

use super::consensus::{BLOCK, Consensus, Lenses, Placement, Sight, nearest_rotation};
use crate::camera::Intrinsics;

/// What the pixels see through a lens, as unit rays; none where the lens has no ray.
pub(super) fn rays(camera: &Intrinsics, pixels: &[Vector2<f64>]) -> Vec<Option<Vector3<f64>>> {
    let [px, py] = [0, 1].map(|axis| pixels.iter().map(|pixel| pixel[axis]).collect::<Vec<f64>>());
    let mut found: [Vec<f64>; 3] = std::array::from_fn(|_| vec![f64::NAN; pixels.len()]);
    let counted = camera.unproject_all([&px, &py], found.each_mut().map(Vec::as_mut_slice));
    debug_assert!(counted.is_ok(), "slices of one length");
    let ray = |at: usize| Vector3::from(found.each_ref().map(|axis| axis[at]));
    (0..pixels.len()).map(|at| Some(ray(at)).filter(|ray| !ray.x.is_nan())).collect()
}

/// The rays of all cells in all lenses, lens by lens.
pub(super) fn all_rays(
    cameras: &[&Intrinsics],
    pixels: &[Vector2<f64>],
) -> Vec<Vec<Option<Vector3<f64>>>> {
    cameras.par_iter().map(|camera| rays(camera, pixels)).collect()
}

/// The mean of the rays of each pixel, and all lenses as they are; none for a pixel that no single ray reaches in all of them.
pub(super) fn unturned_start(
    cameras: &[&Intrinsics],
    pixels: &[Vector2<f64>],
    rays: &[&[Option<Vector3<f64>>]],
) -> Vec<Option<Vector3<f64>>> {
    let mean = |cell: usize| {
        let all: Option<Vec<Vector3<f64>>> = rays.iter().map(|rays| rays[cell]).collect();
        all?.iter().sum::<Vector3<f64>>().try_normalize(0.0)
    };
    let mut means: Vec<Option<Vector3<f64>>> =
        (0..pixels.len()).into_par_iter().map(mean).collect();
    let all: Vec<Vector3<f64>> = means.iter().flatten().copied().collect();
    let sees_all =
        |camera: &&Intrinsics| Sight::default().look(camera, &Placement::unmoved(), 0.0, &all);
    if !cameras.par_iter().all(sees_all) {
        // Beyond the fold of one lens the ray of another may still be within all.
        let is_common = |ray: &Vector3<f64>| cameras.iter().all(|c| c.project(ray).is_ok());
        means.par_iter_mut().enumerate().for_each(|(cell, mean)| {
            if !mean.as_ref().is_some_and(is_common) {
                *mean = rays.iter().filter_map(|rays| rays[cell]).find(is_common);
            }
        });
    }
    means
}

/// Each lens turned by the rotation that carries its own rays nearest to the consensus (Wahba's problem, solved in closed form).
pub(super) fn turned_start(consensus: &Consensus, rays: &[Vec<Vector3<f64>>]) -> Option<Consensus> {
    let placement = |rays: &Vec<Vector3<f64>>| {
        let blocks = rays.chunks(BLOCK).zip(consensus.rays.chunks(BLOCK));
        let pairs = blocks.flat_map(|(own, common)| own.iter().zip(common));
        let matrix: Matrix3<f64> = pairs.map(|(own, common)| own * common.transpose()).sum();
        let rotation = nearest_rotation(&matrix)?;
        Some(Placement { rotation, ..Placement::unmoved() })
    };
    let placements = rays.par_iter().map(placement).collect::<Option<Vec<_>>>()?;
    Some(Consensus { rays: consensus.rays.clone(), placements })
}

/// How far each lens is off the consensus.
pub(super) struct Deviations {
    /// In px: for each cell, for each lens (and for each depth, the innermost).
    pub px: Vec<Vector2<f64>>,
    /// Sum over the lenses of the squared angles in rad, for each cell, as a mean over the depths.
    pub rad2: Vec<f64>,
}

/// How far each lens is off a consensus that all of them see.
pub(super) fn deviations(lenses: Lenses, consensus: &Consensus) -> Option<Deviations> {
    let stride = lenses.cameras.len() * lenses.inverse_depths.len();
    let mut px = vec![Vector2::zeros(); lenses.pixels.len() * stride];
    let mut rad2 = vec![0.0; lenses.pixels.len()];
    let blocks = px.par_chunks_mut(BLOCK * stride).zip(rad2.par_chunks_mut(BLOCK));
    let cells = lenses.pixels.par_chunks(BLOCK).zip(consensus.rays.par_chunks(BLOCK));
    blocks
        .zip(cells)
        .map(|((px, rad2), (pixels, rays))| {
            let mut sight = Sight::default();
            let depth_count = lenses.inverse_depths.len();
            for (lens, (camera, placement)) in
                lenses.cameras.iter().zip(&consensus.placements).enumerate()
            {
                for (at, &inverse_depth) in lenses.inverse_depths.iter().enumerate() {
                    if !sight.look(camera, placement, inverse_depth, rays) {
                        return None;
                    }
                    let out = px.iter_mut().skip(lens * depth_count + at).step_by(stride);
                    let cells = out.zip(&mut *rad2).zip(rays.iter().zip(pixels));
                    for (((px, rad2), (ray, pixel)), seen) in cells.zip(&sight.seen) {
                        *px = seen.pixel - pixel;
                        let point =
                            placement.rotation * ray + placement.translation * inverse_depth;
                        *rad2 += angle2(px, &seen.wrt_point)?
                            / point.norm_squared()
                            / depth_count as f64;
                    }
                }
            }
            Some(())
        })
        .collect::<Option<Vec<()>>>()?;
    Some(Deviations { px, rad2 })
}

/// The square of the shortest step of the point that moves its pixel so far.
fn angle2(px: &Vector2<f64>, wrt_point: &Matrix2x3<f64>) -> Option<f64> {
    Some(px.dot(&((wrt_point * wrt_point.transpose()).try_inverse()? * px)))
}
