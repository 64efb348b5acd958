//! The consensus of several lenses: the rays that, seen by each of them after it was turned (and moved) onto the others, come
//! out nearest to the pixels where they should. Reference-free: no lens is better than another.
//!
//! Minimised is sum |project_r(R_r m_g + t_r / z) - q_g|^2 over unit rays m_g, rotations R_r and translations t_r. The rays
//! are eliminated cell by cell (Schur complement); what remains, a few unknowns a lens, is solved by conjugate gradients.

use nalgebra::{
    Matrix2, Matrix2x3, Matrix3, Matrix3x2, Rotation3, SMatrix, SVector, Vector2, Vector3,
};
use rayon::prelude::*;

use crate::camera::Intrinsics;
use crate::least_squares::{self, Options, Problem, Step, Stop};

/// Cells that are worked on at once: few enough for the cache, enough that asking for the model costs nothing. Fixed, so that
/// sums run in one order for any number of threads.
pub(super) const BLOCK: usize = 64;

/// What is compared: lenses, pixels, and at which depths.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lenses<'a> {
    pub cameras: &'a [&'a Intrinsics],
    pub pixels: &'a [Vector2<f64>],
    /// 1 / distance of the points that are compared: zero is infinity, where a translation has no effect.
    pub inverse_depths: &'a [f64],
}

/// A lens turned and moved onto the consensus: camera coordinates are `rotation` * ray + `translation` / depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    pub rotation: Rotation3<f64>,
    pub translation: Vector3<f64>,
}

/// Where a search is: a ray for each pixel, a placement for each lens.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Consensus {
    pub rays: Vec<Vector3<f64>>,
    pub placements: Vec<Placement>,
}

impl Placement {
    /// As the lens is.
    pub(super) fn unmoved() -> Self {
        Self { rotation: Rotation3::identity(), translation: Vector3::zeros() }
    }
}

/// The consensus from this start. D unknowns a lens: 0 as they are, 3 turned, 6 turned and moved. None where a ray of the
/// start is not seen by some lens.
pub(super) fn consensus<const D: usize>(lenses: Lenses, start: Consensus) -> Option<Consensus> {
    /// The spread is flat about its minimum: a decrement of this share changes no digit that is shown.
    const ENOUGH: f64 = 1e-8;
    let mut problem = Alignment::<D>::new(lenses);
    let options = Options { stop: Stop::Decrement(ENOUGH), ..Options::default() };
    let found = least_squares::minimize(&mut problem, start, &options)?.state;
    Some(if D == 0 { found } else { centred(found) })
}

/// Turned as a whole so that the rotations average to none: alignment leaves that free, and the consensus then looks where the
/// lenses do.
fn centred(mut consensus: Consensus) -> Consensus {
    let sum: Matrix3<f64> = consensus.placements.iter().map(|p| *p.rotation.matrix()).sum();
    let Some(mean) = nearest_rotation(&sum) else { return consensus };
    consensus.rays.iter_mut().for_each(|ray| *ray = mean * *ray);
    for placement in &mut consensus.placements {
        placement.rotation *= mean.inverse();
    }
    consensus
}

/// The rotation R that is nearest to a matrix: it maximises tr(R^T M), which is Wahba's problem too.
pub(super) fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<Rotation3<f64>> {
    let svd = matrix.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let handedness = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
    Some(Rotation3::from_matrix_unchecked(u * Matrix3::from_diagonal(&handedness) * v_t))
}

/// A rotation as a vector along its axis, as long as its angle in rad. From the sine as well as the cosine, since near no
/// rotation the cosine alone has half of the digits, and rounding lifts it above 1.
pub(super) fn rotation_vector(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let matrix = rotation.matrix();
    let twist = (matrix - matrix.transpose()) / 2.0;
    let axis = Vector3::new(twist[(2, 1)], twist[(0, 2)], twist[(1, 0)]);
    let sine = axis.norm();
    let angle = sine.atan2((matrix.trace() - 1.0) / 2.0);
    if sine > 0.0 { axis * (angle / sine) } else { Vector3::zeros() }
}

/// Two unit vectors across a unit ray.
pub(super) fn across(ray: &Vector3<f64>) -> Matrix3x2<f64> {
    let mut axis = Vector3::zeros();
    axis[ray.iamin()] = 1.0;
    let one = ray.cross(&axis).normalize();
    Matrix3x2::from_columns(&[one, ray.cross(&one)])
}

struct Alignment<'a, const D: usize> {
    lenses: Lenses<'a>,
    /// Of the state that was looked at last.
    blocks: Vec<Block<D>>,
    /// The state that the search stands at, when `blocks` are of another one.
    left: Option<Consensus>,
    here: Option<Consensus>,
    runs: Vec<RunEquations<D>>,
    run_step: Vec<SVector<f64, D>>,
    ray_step: Vec<Vector3<f64>>,
}

/// Normal equations of the cells of one block.
struct Block<const D: usize> {
    cost: Option<f64>,
    cells: Vec<CellEquations>,
    /// d ray with d lens: for each cell, for each lens.
    coupling: Vec<SMatrix<f64, 2, D>>,
    runs: Vec<RunEquations<D>>,
}

/// Of one ray, in the plane across it.
#[derive(Clone, Copy)]
struct CellEquations {
    across: Matrix3x2<f64>,
    hessian: Matrix2<f64>,
    inverse: Matrix2<f64>,
    gradient: Vector2<f64>,
}

/// Of one lens.
#[derive(Clone, Copy)]
struct RunEquations<const D: usize> {
    hessian: SMatrix<f64, D, D>,
    gradient: SVector<f64, D>,
}

impl<const D: usize> RunEquations<D> {
    fn zeros() -> Self {
        Self { hessian: SMatrix::zeros(), gradient: SVector::zeros() }
    }

    fn damped(&self, damping: f64) -> SMatrix<f64, D, D> {
        let mut damped = self.hessian;
        for index in 0..D {
            damped[(index, index)] *= 1.0 + damping;
        }
        damped
    }
}

impl<'a, const D: usize> Alignment<'a, D> {
    fn new(lenses: Lenses<'a>) -> Self {
        let block = |pixels: &[Vector2<f64>]| Block {
            cost: None,
            cells: Vec::with_capacity(pixels.len()),
            coupling: vec![SMatrix::zeros(); pixels.len() * lenses.cameras.len()],
            runs: Vec::new(),
        };
        Self {
            lenses,
            blocks: lenses.pixels.chunks(BLOCK).map(block).collect(),
            left: None,
            here: None,
            runs: Vec::new(),
            run_step: Vec::new(),
            ray_step: Vec::new(),
        }
    }

    /// Looks at a state: all normal equations, and the cost.
    fn look(&mut self, state: &Consensus) -> Option<f64> {
        let lenses = self.lenses;
        self.blocks
            .par_iter_mut()
            .zip(lenses.pixels.par_chunks(BLOCK).zip(state.rays.par_chunks(BLOCK)))
            .for_each(|(block, (pixels, rays))| {
                block.fill(&Lenses { pixels, ..lenses }, rays, &state.placements);
            });
        let costs: Option<Vec<f64>> = self.blocks.iter().map(|block| block.cost).collect();
        Some(costs?.iter().sum())
    }

    /// The Schur complement times lens steps, or with gradients what it has on its right-hand side.
    fn reduced(
        &self,
        cell: impl Fn(&CellEquations, Vector2<f64>) -> Vector2<f64> + Sync,
        steps: Option<&[SVector<f64, D>]>,
    ) -> Vec<SVector<f64, D>> {
        let count = self.lenses.cameras.len();
        let of_block = |block: &Block<D>| {
            let mut sums = vec![SVector::<f64, D>::zeros(); count];
            for (equations, coupling) in block.cells.iter().zip(block.coupling.chunks(count)) {
                let moved = steps.map_or(Vector2::zeros(), |steps| {
                    coupling.iter().zip(steps).map(|(coupling, step)| coupling * step).sum()
                });
                let back = cell(equations, moved);
                for (sum, coupling) in sums.iter_mut().zip(coupling) {
                    *sum += coupling.tr_mul(&back);
                }
            }
            sums
        };
        let blocks: Vec<Vec<SVector<f64, D>>> = self.blocks.par_iter().map(of_block).collect();
        let mut sums = vec![SVector::zeros(); count];
        for block in blocks {
            sums.iter_mut().zip(block).for_each(|(sum, part)| *sum += part);
        }
        sums
    }

    /// The lens steps that solve the reduced system, by conjugate gradients. Lenses that are alike couple by their mean only,
    /// which alignment leaves free: so a few rounds suffice.
    fn lens_steps(&self, damping: f64) -> Option<Vec<SVector<f64, D>>> {
        /// Relative to the right-hand side; Newton's next step makes up for what is left.
        const ENOUGH: f64 = 1e-6;
        const MOST_ROUNDS: usize = 200;
        let damped: Vec<_> = self.runs.iter().map(|run| run.damped(damping)).collect();
        let factors: Vec<_> =
            damped.iter().map(|hessian| hessian.cholesky()).collect::<Option<_>>()?;
        let solve = |right: &[SVector<f64, D>]| -> Vec<SVector<f64, D>> {
            factors.iter().zip(right).map(|(factor, right)| factor.solve(right)).collect()
        };
        let eliminated = self.reduced(|cell, _| cell.inverse * cell.gradient, None);
        let mut rest: Vec<_> =
            self.runs.iter().zip(eliminated).map(|(run, part)| part - run.gradient).collect();
        let mut steps = vec![SVector::zeros(); rest.len()];
        let mut direction = solve(&rest);
        let mut size = dot(&rest, &direction);
        let enough = ENOUGH * ENOUGH * size;
        for _ in 0..MOST_ROUNDS {
            if size <= enough {
                break;
            }
            let eliminated = self.reduced(|cell, moved| cell.inverse * moved, Some(&direction));
            let image: Vec<_> = damped
                .iter()
                .zip(&direction)
                .zip(eliminated)
                .map(|((hessian, direction), part)| hessian * direction - part)
                .collect();
            let curvature = dot(&direction, &image);
            if curvature <= 0.0 {
                break;
            }
            add(&mut steps, size / curvature, &direction);
            add(&mut rest, -size / curvature, &image);
            let solved = solve(&rest);
            let next = dot(&rest, &solved);
            let turned = next / size;
            direction =
                solved.iter().zip(&direction).map(|(new, old)| new + old * turned).collect();
            size = next;
        }
        Some(steps)
    }
}

fn dot<const D: usize>(one: &[SVector<f64, D>], other: &[SVector<f64, D>]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one.dot(other)).sum()
}

fn add<const D: usize>(sum: &mut [SVector<f64, D>], factor: f64, part: &[SVector<f64, D>]) {
    sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part * factor);
}

impl<const D: usize> Problem for Alignment<'_, D> {
    type State = Consensus;

    fn cost(&mut self, state: &Consensus) -> Option<f64> {
        self.left = self.left.take().or(self.here.take());
        self.look(state)
    }

    /// The search stands where it looked last: `cost` has left the equations of that state.
    fn linearize(&mut self, state: &Consensus) {
        self.left = None;
        self.here = Some(state.clone());
    }

    fn solve(&mut self, damping: f64) -> Option<Step> {
        if let Some(state) = self.left.take() {
            self.look(&state)?;
            self.here = Some(state);
        }
        for cell in self.blocks.iter_mut().flat_map(|block| &mut block.cells) {
            let damped =
                cell.hessian + Matrix2::from_diagonal(&(cell.hessian.diagonal() * damping));
            cell.inverse = damped.try_inverse()?;
        }
        self.runs = vec![RunEquations::zeros(); self.lenses.cameras.len()];
        for block in &self.blocks {
            for (run, part) in self.runs.iter_mut().zip(&block.runs) {
                run.hessian += part.hessian;
                run.gradient += part.gradient;
            }
        }
        self.run_step = if D == 0 { Vec::new() } else { self.lens_steps(damping)? };
        let (mut fall, mut damped, mut largest, mut length) = (0.0, 0.0, 0.0_f64, 0.0);
        let mut tell = |gradient: f64, hessian: f64, step: f64| {
            fall -= gradient * step;
            damped += damping * hessian * step * step;
            largest = largest.max(gradient.abs());
            length += step * step;
        };
        for (run, step) in self.runs.iter().zip(&self.run_step) {
            for index in 0..D {
                tell(run.gradient[index], run.hessian[(index, index)], step[index]);
            }
        }
        self.ray_step.clear();
        for block in &self.blocks {
            let count = self.lenses.cameras.len();
            for (cell, coupling) in block.cells.iter().zip(block.coupling.chunks(count)) {
                let moved: Vector2<f64> =
                    coupling.iter().zip(&self.run_step).map(|(w, step)| w * step).sum();
                let step = -(cell.inverse * (cell.gradient + moved));
                for index in 0..2 {
                    tell(cell.gradient[index], cell.hessian[(index, index)], step[index]);
                }
                self.ray_step.push(cell.across * step);
            }
        }
        let predicted = 0.5 * (fall + damped);
        let is_finite = predicted.is_finite() && length.is_finite();
        is_finite.then(|| Step { predicted, gradient: largest, length: length.sqrt() })
    }

    fn step(&self, state: &Consensus, moved: &mut Consensus) {
        moved.rays.clear();
        moved.rays.extend(
            state.rays.iter().zip(&self.ray_step).map(|(ray, step)| (ray + step).normalize()),
        );
        moved.placements.clone_from(&state.placements);
        for (placement, step) in moved.placements.iter_mut().zip(&self.run_step) {
            if D >= 3 {
                let turn = Vector3::new(step[0], step[1], step[2]);
                placement.rotation *= Rotation3::from_scaled_axis(-turn);
            }
            if D >= 6 {
                placement.translation += Vector3::new(step[3], step[4], step[5]);
            }
        }
    }

    fn length(&self, state: &Consensus) -> f64 {
        (state.rays.len() as f64).sqrt()
    }

    fn freedom(&self) -> f64 {
        let Lenses { cameras, pixels, inverse_depths } = self.lenses;
        let residuals = 2 * cameras.len() * pixels.len() * inverse_depths.len();
        residuals.saturating_sub(2 * pixels.len() + D * cameras.len()) as f64
    }
}

impl<const D: usize> Block<D> {
    fn fill(&mut self, lenses: &Lenses, rays: &[Vector3<f64>], placements: &[Placement]) {
        let count = lenses.cameras.len();
        self.coupling.fill(SMatrix::zeros());
        self.runs.clear();
        self.cells.clear();
        self.cells.extend(rays.iter().map(|ray| CellEquations {
            across: across(ray),
            hessian: Matrix2::zeros(),
            inverse: Matrix2::zeros(),
            gradient: Vector2::zeros(),
        }));
        let mut sight = Sight::default();
        let mut cost = 0.0;
        self.cost = None;
        for (index, (camera, placement)) in lenses.cameras.iter().zip(placements).enumerate() {
            let mut run = RunEquations::zeros();
            for &inverse_depth in lenses.inverse_depths {
                if !sight.look(camera, placement, inverse_depth, rays) {
                    return;
                }
                let couplings = self.coupling.iter_mut().skip(index).step_by(count);
                let cells =
                    self.cells.iter_mut().zip(couplings).zip(rays.iter().zip(lenses.pixels));
                for (((cell, coupling), (ray, pixel)), seen) in cells.zip(&sight.seen) {
                    let residual = seen.pixel - pixel;
                    cost += 0.5 * residual.norm_squared();
                    let wrt_turned = seen.wrt_point * placement.rotation.matrix();
                    let wrt_ray = wrt_turned * cell.across;
                    cell.hessian += wrt_ray.tr_mul(&wrt_ray);
                    cell.gradient += wrt_ray.tr_mul(&residual);
                    if D > 0 {
                        let wrt_lens = wrt_lens(ray, &wrt_turned, &seen.wrt_point, inverse_depth);
                        *coupling += wrt_ray.tr_mul(&wrt_lens);
                        run.hessian += wrt_lens.tr_mul(&wrt_lens);
                        run.gradient += wrt_lens.tr_mul(&residual);
                    }
                }
            }
            self.runs.push(run);
        }
        self.cost = Some(cost);
    }
}

/// Derivatives of a pixel by the turn and the move of its lens.
#[inline]
fn wrt_lens<const D: usize>(
    ray: &Vector3<f64>,
    wrt_turned: &Matrix2x3<f64>,
    wrt_point: &Matrix2x3<f64>,
    inverse_depth: f64,
) -> SMatrix<f64, 2, D> {
    let mut wrt_lens = SMatrix::zeros();
    for row in 0..2 {
        // Turning the consensus by w before the lens looks moves a ray m by m x w, and row . (m x w) = (row x m) . w.
        let turn = wrt_turned.row(row).transpose().cross(ray);
        for axis in 0..3.min(D) {
            wrt_lens[(row, axis)] = turn[axis];
        }
        for axis in 3..D {
            wrt_lens[(row, axis)] = wrt_point[(row, axis - 3)] * inverse_depth;
        }
    }
    wrt_lens
}

/// Where a lens sees some rays.
#[derive(Debug, Default)]
pub(super) struct Sight {
    points: [Vec<f64>; 3],
    pixels: [Vec<f64>; 2],
    wrt_point: [Vec<f64>; 6],
    pub seen: Vec<Seen>,
}

/// Where a lens sees a point, and how that changes with the point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub pixel: Vector2<f64>,
    pub wrt_point: Matrix2x3<f64>,
}

impl Sight {
    /// Looks at points on these rays; false when one of them is not seen.
    pub(super) fn look(
        &mut self,
        camera: &Intrinsics,
        placement: &Placement,
        inverse_depth: f64,
        rays: &[Vector3<f64>],
    ) -> bool {
        let offset = placement.translation * inverse_depth;
        self.points.iter_mut().for_each(Vec::clear);
        for point in rays.iter().map(|ray| placement.rotation * ray + offset) {
            self.points.iter_mut().zip(point.iter()).for_each(|(axis, value)| axis.push(*value));
        }
        self.pixels.iter_mut().for_each(|axis| axis.resize(rays.len(), 0.0));
        self.wrt_point.iter_mut().for_each(|place| place.resize(rays.len(), 0.0));
        let points = self.points.each_ref().map(Vec::as_slice);
        let pixels = self.pixels.each_mut().map(Vec::as_mut_slice);
        let wrt_point = self.wrt_point.each_mut().map(Vec::as_mut_slice);
        let count = camera.look_all(points, pixels, wrt_point);
        let [px, py] = &self.pixels;
        self.seen.clear();
        self.seen.extend((0..rays.len()).map(|at| Seen {
            pixel: Vector2::new(px[at], py[at]),
            wrt_point: Matrix2x3::from_fn(|row, column| self.wrt_point[3 * row + column][at]),
        }));
        count == Ok(rays.len())
    }
}
