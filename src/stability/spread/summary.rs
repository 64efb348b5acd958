//! Deviations in every cell to the numbers and maps that are shown.

use nalgebra::Vector2;

use super::rays::Deviations;
use super::shape::{Ring, Spread, SpreadMeasure};
use crate::camera::Grid;
use crate::stats::Sorted;

/// Rings of the radial profile, from the image's centre to its corner.
const RINGS: usize = 20;

/// What deviations from a consensus of `count` lenses amount to; none without a cell.
pub(super) fn spread_measure(
    deviations: &Deviations,
    count: usize,
    pixels: &[Vector2<f64>],
) -> Option<SpreadMeasure> {
    let freedom = (count - 1) as f64;
    let stride = deviations.px.len() / pixels.len().max(1);
    let depth_count = (stride / count) as f64;
    let map_px = deviations.px.chunks(stride).map(|px| {
        let sum: f64 = px.iter().map(Vector2::norm_squared).sum();
        (sum / depth_count / freedom).sqrt()
    });
    let map_px: Vec<f64> = map_px.collect();
    let map_deg: Vec<f64> =
        deviations.rad2.iter().map(|rad2| (rad2 / freedom).sqrt().to_degrees()).collect();
    let robust: Vec<f64> = deviations.px.chunks(stride).map(median_based).collect();
    let (px, deg) = (Sorted::new(map_px.clone())?, Sorted::new(map_deg.clone())?);
    let worst = (0..map_px.len()).max_by(|&a, &b| map_px[a].total_cmp(&map_px[b]))?;
    Some(SpreadMeasure {
        rms_px: rms(&map_px),
        p95_px: px.quantile(0.95),
        max_px: px.max(),
        max_at: pixels[worst].into(),
        rms_deg: rms(&map_deg),
        p95_deg: deg.quantile(0.95),
        max_deg: deg.max(),
        median_based_px: rms(&robust),
        map_px,
    })
}

pub(in crate::stability) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

/// The median distance from the median, times 1 / sqrt(ln 2): of normal deviations in the plane, the root of their mean square.
fn median_based(deviations: &[Vector2<f64>]) -> f64 {
    let middle = Vector2::new(
        median(deviations.iter().map(|deviation| deviation.x).collect()),
        median(deviations.iter().map(|deviation| deviation.y).collect()),
    );
    let distance = median(deviations.iter().map(|deviation| (deviation - middle).norm()).collect());
    distance / std::f64::consts::LN_2.sqrt()
}

/// The median of one number or more, without sorting them all.
fn median(mut values: Vec<f64>) -> f64 {
    let half = values.len() / 2;
    let is_odd = values.len() % 2 == 1;
    let (below, middle, _) = values.select_nth_unstable_by(half, f64::total_cmp);
    let middle = *middle;
    match below.iter().copied().max_by(f64::total_cmp) {
        Some(below) if !is_odd => 0.5 * (below + middle),
        _ => middle,
    }
}

/// Maps, raw and rotation-aligned, by distance from the image's centre; rings without a cell are left out.
pub(super) fn radial_profile(
    grid: &Grid,
    size: [u64; 2],
    cells: &[usize],
    [raw_px, rotated_px]: [&[f64]; 2],
) -> Vec<Ring> {
    let ring = |(radius_px, of_ring): (f64, Vec<usize>)| Ring {
        radius_px,
        cell_count: of_ring.len(),
        raw_rms_px: rms_of(raw_px, &of_ring),
        rms_px: rms_of(rotated_px, &of_ring),
    };
    rings(grid, size, cells).map(ring).collect()
}

/// The same of another map over the cells of a spread: RMS of each ring.
pub(in crate::stability) fn radial_rms(
    spread: &Spread,
    [width, height]: [u64; 2],
    map_px: &[f64],
) -> Vec<f64> {
    let grid = Grid::new(width, height);
    rings(&grid, [width, height], &spread.cells).map(|(_, cells)| rms_of(map_px, &cells)).collect()
}

fn rms_of(map: &[f64], cells: &[usize]) -> f64 {
    rms(&cells.iter().map(|&at| map[at]).collect::<Vec<f64>>())
}

/// The rings that have a cell: the middle of each, and the places of its cells among all.
fn rings(
    grid: &Grid,
    [width, height]: [u64; 2],
    cells: &[usize],
) -> impl Iterator<Item = (f64, Vec<usize>)> {
    let centre = Vector2::new(width as f64, height as f64) / 2.0;
    let step = centre.norm() / RINGS as f64;
    (0..RINGS).filter_map(move |index| {
        let radii = index as f64 * step..(index + 1) as f64 * step;
        let is_in = |at: &usize| radii.contains(&(grid.pixel(cells[*at]) - centre).norm());
        let of_ring: Vec<usize> = (0..cells.len()).filter(is_in).collect();
        let middle = (index as f64 + 0.5) * step;
        (!of_ring.is_empty()).then_some((middle, of_ring))
    })
}

/// RMS distance between the deviations of any two lenses. For many of them, over so many cells evenly as do for it.
pub(super) fn distances(px: &[Vector2<f64>], count: usize) -> Vec<Vec<f64>> {
    /// A hundred lenses in all cells, a thousand in 40: a hundredth of a second.
    const MOST_DIFFERENCES: usize = 40_000_000;
    let cell_count = px.len() / count;
    let every = (count * count * cell_count).div_ceil(MOST_DIFFERENCES).max(1);
    let cells: Vec<&[Vector2<f64>]> = px.chunks(count).step_by(every).collect();
    let mut squares = vec![vec![0.0; count]; count];
    for cell in &cells {
        for (index, (one, row)) in cell.iter().zip(&mut squares).enumerate() {
            for (other, sum) in cell[..index].iter().zip(row) {
                *sum += (one - other).norm_squared();
            }
        }
    }
    let distance = |one: usize, other: usize| {
        (squares[one.max(other)][one.min(other)] / cells.len() as f64).sqrt()
    };
    (0..count).map(|one| (0..count).map(|other| distance(one, other)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_based_spread_is_that_of_normal_deviations_and_ignores_a_wild_one() {
        // Quantiles of a Rayleigh distribution on a spiral: deviations of std 1 along x and along y, spread sqrt(2).
        let mut deviations: Vec<Vector2<f64>> = (0..1000)
            .map(|index| {
                let share = (f64::from(index) + 0.5) / 1000.0;
                let (sin, cos) = (2.399_963 * f64::from(index)).sin_cos();
                Vector2::new(cos, sin) * (-2.0 * (1.0 - share).ln()).sqrt()
            })
            .collect();
        let plain = median_based(&deviations);
        assert!((plain / 2.0_f64.sqrt() - 1.0).abs() < 0.02, "{plain}");
        deviations.push(Vector2::new(1e6, -1e6));
        assert!((median_based(&deviations) / plain - 1.0).abs() < 0.02);
    }

    #[test]
    fn the_median_is_that_of_the_sorted() {
        for values in [vec![3.0], vec![4.0, 1.0], vec![5.0, 1.0, 2.0], vec![9.0, 1.0, 2.0, 4.0]] {
            let want = Sorted::new(values.clone()).unwrap().median();
            assert_eq!(median(values).to_bits(), want.to_bits());
        }
    }

    #[test]
    fn distances_are_those_of_all_pairs() {
        let [a, b, c] = [[0.0, 0.0], [3.0, 4.0], [0.0, 1.0]].map(Vector2::from);
        let found = distances(&[a, b, c, a, b, c], 3);
        assert!((found[0][1] - 5.0).abs() < 1e-15 && (found[2][0] - 1.0).abs() < 1e-15);
        assert!((found[1][2] - 18.0_f64.sqrt()).abs() < 1e-14 && found[1][1].abs() < 1e-15);
    }
}
