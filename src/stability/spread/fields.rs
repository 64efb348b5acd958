//! The deviations of lenses from their consensus, for other statistics than their spread.

use nalgebra::{Vector2, Vector3};

use super::rays::{all_rays, unturned_start};
use super::{Chosen, Found};
use crate::camera::Intrinsics;

/// The rotation-aligned deviations in px, lens by lens and pixel by pixel. The lenses must come in the order of their content;
/// none unless all of them see all pixels.
pub(in super::super) fn aligned_deviations(
    cameras: &[&Intrinsics],
    pixels: &[Vector2<f64>],
) -> Option<Vec<Vec<Vector2<f64>>>> {
    let rays = all_rays(cameras, pixels);
    let of_lenses: Vec<&[Option<Vector3<f64>>]> = rays.iter().map(Vec::as_slice).collect();
    let start = unturned_start(cameras, pixels, &of_lenses);
    let chosen = Chosen {
        order: (0..cameras.len()).collect(),
        cameras: cameras.to_vec(),
        cells: (0..pixels.len()).collect(),
        masked_cells: Vec::new(),
        pixels: pixels.to_vec(),
        start: start.into_iter().collect::<Option<_>>()?,
        rays: rays.into_iter().map(|rays| rays.into_iter().collect()).collect::<Option<_>>()?,
    };
    let px = Found::new(&chosen, None)?.rotated.px;
    let count = cameras.len();
    Some((0..count).map(|lens| px.iter().skip(lens).step_by(count).copied().collect()).collect())
}
