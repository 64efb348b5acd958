//! The difference from one calibration to another: where the other sees, in px, what the one sees at a pixel.

use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

use super::consensus::{Placement, Seen, Sight, nearest_rotation, rotation_vector};
use super::rays;
use super::summary::rms;
use super::{Calibration, default_region};
use super::{Region, SpreadError, one_size};
use crate::camera::{Grid, Intrinsics};
use crate::least_squares::{NormalEquations, Options, Problem, Step, minimize};
use crate::stats::Sorted;

/// project_b(R unproject_a(q)) - q in every cell q: it has a direction, from a to b.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Difference {
    /// What is compared.
    pub from: String,
    /// To what.
    pub to: String,
    /// Cells in a row of the image.
    pub columns: usize,
    /// Cells in a column of the image.
    pub rows: usize,
    /// The cells that were compared, counted row by row from the top left: those of the region whose rays both have.
    pub cells: Vec<usize>,
    /// Their share of the image.
    pub cell_share: f64,
    /// As they are: R = 1.
    pub raw: DifferenceMeasure,
    /// R turned so that the sum of squares is least.
    pub rotated: DifferenceMeasure,
    /// R, as a rotation vector in degrees about x (right), y (down) and z (ahead).
    pub rotation_deg: [f64; 3],
    /// Its angle.
    pub rotation_angle_deg: f64,
}

/// A difference in numbers.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DifferenceMeasure {
    /// Root of the mean square over the cells.
    pub rms_px: f64,
    /// 95th percentile over the cells (type 7).
    pub p95_px: f64,
    /// The greatest.
    pub max_px: f64,
    /// The pixel where it is greatest.
    pub max_at: [f64; 2],
    /// The difference in each cell, in px.
    pub px: Vec<[f64; 2]>,
}

/// The difference from one calibration to another.
pub fn difference(
    from: &Calibration,
    to: &Calibration,
    region: Option<Region>,
) -> Result<Difference, SpreadError> {
    let both = [from.clone(), to.clone()];
    let [width, height] = one_size(&both)?;
    let grid = Grid::new(width, height);
    let observed: Vec<&[bool]> =
        both.iter().filter_map(|one| Some(one.view.as_ref()?.observed_cells.as_slice())).collect();
    let cells = region.unwrap_or_else(|| default_region(&both)).cells(&grid, &observed);
    let pixels: Vec<Vector2<f64>> = cells.iter().map(|&cell| grid.pixel(cell)).collect();
    let found = rays::rays(&from.camera.intrinsics, &pixels);
    let rays: Vec<(usize, Vector3<f64>)> =
        cells.into_iter().zip(found).filter_map(|(cell, ray)| Some((cell, ray?))).collect();
    difference_of_rays(&grid, &rays, &to.camera.intrinsics, [from.run, to.run])
}

/// The difference from rays, each seen in the middle of its cell, to a lens.
pub(in crate::stability) fn difference_of_rays(
    grid: &Grid,
    rays: &[(usize, Vector3<f64>)],
    lens: &Intrinsics,
    [from, to]: [&str; 2],
) -> Result<Difference, SpreadError> {
    let common: Vec<Common> = {
        let pixels: Vec<Vector2<f64>> = rays.iter().map(|(cell, _)| grid.pixel(*cell)).collect();
        let own = rays::rays(lens, &pixels);
        let both = rays.iter().zip(pixels).zip(own);
        both.filter(|((ray, _), _)| lens.project(&ray.1).is_ok())
            .filter_map(|((&(cell, ray), pixel), own)| Some(Common { cell, pixel, ray, own: own? }))
            .collect()
    };
    let pixels: Vec<Vector2<f64>> = common.iter().map(|one| one.pixel).collect();
    let mut turn = Turn {
        pixels: &pixels,
        rays: &common.iter().map(|one| one.ray).collect::<Vec<_>>(),
        lens,
        normal: NormalEquations::new(3),
    };
    let raw = turn.look(&Rotation3::identity()).ok_or(SpreadError::NothingInCommon)?;
    let matrix: Matrix3<f64> = common.iter().map(|one| one.own * one.ray.transpose()).sum();
    let starts = [nearest_rotation(&matrix), Some(Rotation3::identity())];
    let ends = starts.into_iter().flatten().filter_map(|start| {
        minimize(&mut turn, start, &Options::default()).map(|end| (end.cost, end.state))
    });
    // The closed form minimises angles; in px it may lead astray.
    let (_, rotation) =
        ends.min_by(|a, b| a.0.total_cmp(&b.0)).ok_or(SpreadError::NothingInCommon)?;
    let rotated = turn.look(&rotation).ok_or(SpreadError::NothingInCommon)?;
    let measure = |residuals: &[Residual]| {
        let px: Vec<Vector2<f64>> = residuals.iter().map(|residual| residual.px).collect();
        difference_measure(&px, &pixels).ok_or(SpreadError::NothingInCommon)
    };
    Ok(Difference {
        from: from.to_owned(),
        to: to.to_owned(),
        columns: grid.columns(),
        rows: grid.rows(),
        cells: common.iter().map(|one| one.cell).collect(),
        cell_share: common.len() as f64 / grid.cell_count() as f64,
        raw: measure(&raw)?,
        rotated: measure(&rotated)?,
        rotation_deg: rotation_vector(&rotation).map(f64::to_degrees).into(),
        rotation_angle_deg: rotation_vector(&rotation).norm().to_degrees(),
    })
}

fn difference_measure(px: &[Vector2<f64>], pixels: &[Vector2<f64>]) -> Option<DifferenceMeasure> {
    let sizes: Vec<f64> = px.iter().map(Vector2::norm).collect();
    let at = (0..sizes.len()).max_by(|&a, &b| sizes[a].total_cmp(&sizes[b]))?;
    Some(DifferenceMeasure {
        rms_px: rms(&sizes),
        p95_px: Sorted::new(sizes.clone())?.quantile(0.95),
        max_px: sizes[at],
        max_at: pixels[at].into(),
        px: px.iter().map(|px| (*px).into()).collect(),
    })
}

/// A cell that both have a ray of.
struct Common {
    cell: usize,
    pixel: Vector2<f64>,
    ray: Vector3<f64>,
    /// The other's.
    own: Vector3<f64>,
}

/// How far a ray is off its pixel, and how that changes with a turn of the rays.
struct Residual {
    px: Vector2<f64>,
    wrt_turn: [Vector3<f64>; 2],
}

/// The search for R.
struct Turn<'a> {
    pixels: &'a [Vector2<f64>],
    rays: &'a [Vector3<f64>],
    lens: &'a Intrinsics,
    normal: NormalEquations,
}

impl Turn<'_> {
    /// Every residual with its derivatives by a turn of the rays; none when one is not seen.
    fn look(&self, rotation: &Rotation3<f64>) -> Option<Vec<Residual>> {
        let placement = Placement { rotation: *rotation, ..Placement::unmoved() };
        let mut sight = Sight::default();
        if !sight.look(self.lens, &placement, 0.0, self.rays) {
            return None;
        }
        let residual = |((seen, ray), pixel): ((&Seen, &Vector3<f64>), &Vector2<f64>)| {
            let turned = rotation * ray;
            // exp(w) turned = turned + w x turned, and row . (w x turned) = (turned x row) . w
            let row = |index: usize| turned.cross(&seen.wrt_point.row(index).transpose());
            Residual { px: seen.pixel - pixel, wrt_turn: [row(0), row(1)] }
        };
        Some(sight.seen.iter().zip(self.rays).zip(self.pixels).map(residual).collect())
    }
}

impl Problem for Turn<'_> {
    type State = Rotation3<f64>;

    fn cost(&mut self, state: &Rotation3<f64>) -> Option<f64> {
        Some(self.look(state)?.iter().map(|residual| 0.5 * residual.px.norm_squared()).sum())
    }

    fn linearize(&mut self, state: &Rotation3<f64>) {
        self.normal.clear();
        for Residual { px, wrt_turn } in self.look(state).unwrap_or_default() {
            for (px, row) in px.iter().zip(&wrt_turn) {
                self.normal.add(*px, row.as_slice());
            }
        }
    }

    fn solve(&mut self, damping: f64) -> Option<Step> {
        self.normal.solve(damping)
    }

    fn step(&self, state: &Rotation3<f64>, moved: &mut Rotation3<f64>) {
        let step = self.normal.last_step();
        *moved = Rotation3::from_scaled_axis(Vector3::new(step[0], step[1], step[2])) * state;
    }

    fn length(&self, _: &Rotation3<f64>) -> f64 {
        1.0
    }

    fn freedom(&self) -> f64 {
        (2 * self.pixels.len()).saturating_sub(3) as f64
    }
}
