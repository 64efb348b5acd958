//! What an adjustment would gain by further parameters, without adjusting again: their efficient score and information.
//!
//! A column z has the derivatives of all residuals by one such parameter. With J what moved and H = J (J^T J)^-1 J^T, its score is
//! z^T (1 - H) r and its information z^T (1 - H) z: Rao 1948. A column may be any pattern in the residuals.

#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector, Vector3};

use super::chunk::Chunk;
use super::eliminate::{View, lift};
use super::linearize::{MOST_PARAMS, Row, Sighting};
use super::optimum::{Observation, Optimum};
use super::point::InverseFactor;
use super::rows::block_of;
use super::schur::Layout;
use super::solver::{Solver, view};

/// A column's number, and what it has for one observation's x and y.
pub type Entry = (usize, [f64; 2]);

/// What further parameters would gain.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// z^T (1 - H) r of each column. Newton's step is minus information^-1 score.
    pub score: DVector<f64>,
    /// z^T (1 - H) z of each two columns: for unit noise the covariance of the scores.
    pub information: DMatrix<f64>,
    /// z^T z of each column: how much of it what moved does not imitate, the information tells.
    pub own: DVector<f64>,
    /// How far each free intrinsic, in the order of `Optimum::free`, moves for one unit of each column's parameter.
    pub following: DMatrix<f64>,
}

impl Optimum {
    /// Probes so many columns; `entries` tells which of them an observation takes part in, each at most once. Squared loss
    /// only: a robust one weighs observations, and `entries` would have to be weighed too.
    pub fn probe(&self, columns: usize, entries: &dyn Fn(&Observation, &mut Vec<Entry>)) -> Probe {
        let Self { problem, state, options, .. } = self;
        let view = view(problem, options, state, false);
        let mut sums = Sums::new(columns, problem.layout.size);
        for chunk in &problem.chunks {
            let mut rows = vec![Row::ZERO; chunk.longest];
            let mut start = 0;
            for (&end, number) in chunk.ends.iter().zip(chunk.points.clone()) {
                let point = &state.points[number];
                let track = &chunk.sightings[start..end as usize];
                start = end as usize;
                let rows = &mut rows[..track.len()];
                let seen = (point, track);
                let block = block_of::<MOST_PARAMS, false>(chunk, &view, seen, rows);
                let mut own = Vec::with_capacity(track.len());
                for sighting in track {
                    let mut of_one = Vec::new();
                    let image = chunk.images[sighting.image as usize] as usize;
                    if let Some(seen) = self.observation(image, (number, point), sighting) {
                        entries(&seen, &mut of_one);
                    }
                    own.push(of_one);
                }
                let inverse =
                    if view.moves_points { block.factor(0.0) } else { InverseFactor::ZERO };
                let reduced = inverse.times(&block.gradient);
                let point = AtPoint { chunk, point, track, rows, own: &own, inverse, reduced };
                sums.add(&point, &view, &problem.layout);
            }
        }
        self.solved(sums)
    }

    /// Eliminates poses and intrinsics too.
    fn solved(&self, sums: Sums) -> Probe {
        let Sums { mut score, mut information, own, right, .. } = sums;
        let layout = &self.problem.layout;
        let columns = score.len();
        let mut watch = |_: &crate::least_squares::Trial| ();
        let mut solver = Solver::new(&self.problem, &self.options, &mut watch);
        let mut answers = right.clone();
        let gradient = solver.answers(&self.state, &mut answers);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (row, right) in right.iter().enumerate() {
            score[row] -= dot(&answers[row], &gradient);
            for column in 0..=row {
                information[(row, column)] -= dot(right, &answers[column]);
                information[(column, row)] = information[(row, column)];
            }
        }
        let unknown = |at: usize| {
            let param = &self.free[at];
            let camera = self.problem.cameras.binary_search(&param.camera).unwrap_or_default();
            let free = &self.problem.lenses[camera].free;
            let index = free.binary_search(&param.place).unwrap_or_default();
            layout.cameras[camera] + index
        };
        let places: Vec<usize> = (0..self.free.len()).map(unknown).collect();
        let following =
            DMatrix::from_fn(places.len(), columns, |at, column| -answers[column][places[at]]);
        Probe { score, information, own, following }
    }
}

/// One point with the columns that its observations take part in.
struct AtPoint<'a> {
    chunk: &'a Chunk,
    point: &'a Vector3<f64>,
    track: &'a [Sighting],
    rows: &'a [Row],
    own: &'a [Vec<Entry>],
    inverse: InverseFactor,
    /// L^-1 g
    reduced: [f64; 3],
}

/// Sums over points, points eliminated.
struct Sums {
    score: DVector<f64>,
    /// Its lower triangle.
    information: DMatrix<f64>,
    own: DVector<f64>,
    /// By column: the products with poses and intrinsics, as the system lays them out.
    right: Vec<Vec<f64>>,
    /// The columns that the point takes part in, with J_point^T z.
    touched: Vec<(usize, [f64; 3])>,
    /// Where a column stands among them.
    slots: Vec<usize>,
}

const NO_SLOT: usize = usize::MAX;

impl Sums {
    fn new(columns: usize, size: usize) -> Self {
        Self {
            score: DVector::zeros(columns),
            information: DMatrix::zeros(columns, columns),
            own: DVector::zeros(columns),
            right: vec![vec![0.0; size]; columns],
            touched: Vec::new(),
            slots: vec![NO_SLOT; columns],
        }
    }

    fn add(&mut self, at: &AtPoint<'_>, view: &View<'_>, layout: &Layout) {
        self.add_own(at, view, layout);
        if view.moves_points {
            self.take_through_point(at, view, layout);
        }
        for (column, _) in self.touched.drain(..) {
            self.slots[column] = NO_SLOT;
        }
    }

    /// What each observation gives by itself.
    fn add_own(&mut self, at: &AtPoint<'_>, view: &View<'_>, layout: &Layout) {
        for ((sighting, row), entries) in at.track.iter().zip(at.rows).zip(at.own) {
            let image = sighting.image as usize;
            let camera = at.chunk.cameras[at.chunk.camera_of[image] as usize] as usize;
            let (pose, start) = (6 * at.chunk.images[image] as usize, layout.cameras[camera]);
            for &(column, [x, y]) in entries {
                let product = by_both(&row.wrt_point, [x, y]);
                if self.slots[column] == NO_SLOT {
                    self.slots[column] = self.touched.len();
                    self.touched.push((column, [0.0; 3]));
                }
                let sum = &mut self.touched[self.slots[column]].1;
                sum.iter_mut().zip(product).for_each(|(sum, value)| *sum += value);
                self.score[column] += row.residual[0] * x + row.residual[1] * y;
                self.own[column] += x * x + y * y;
                for &(other, [u, v]) in entries.iter().filter(|(other, _)| *other <= column) {
                    self.information[(column, other)] += x * u + y * v;
                }
                let right = &mut self.right[column];
                if view.moves_poses {
                    let lifted = lift(at.point, &product);
                    right[pose..pose + 6].iter_mut().zip(lifted).for_each(|(sum, v)| *sum += v);
                }
                let params = by_both(&row.wrt_params, [x, y]);
                let own = &mut right[start..start + layout.width];
                own.iter_mut().zip(params).for_each(|(sum, value)| *sum += value);
            }
        }
    }

    /// What goes through the point is taken away.
    fn take_through_point(&mut self, at: &AtPoint<'_>, view: &View<'_>, layout: &Layout) {
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let reduced: Vec<[f64; 3]> =
            self.touched.iter().map(|(_, product)| at.inverse.times(product)).collect();
        for (one, (column, _)) in reduced.iter().zip(&self.touched) {
            self.score[*column] -= dot(one, &at.reduced);
            for (other, (second, _)) in reduced.iter().zip(&self.touched) {
                if second <= column {
                    self.information[(*column, *second)] -= dot(one, other);
                }
            }
            let solved = at.inverse.transpose_times(one);
            let right = &mut self.right[*column];
            for (sighting, row) in at.track.iter().zip(at.rows) {
                let image = sighting.image as usize;
                let camera = at.chunk.cameras[at.chunk.camera_of[image] as usize] as usize;
                let moved = [dot(&row.wrt_point[0], &solved), dot(&row.wrt_point[1], &solved)];
                if view.moves_poses {
                    let lifted = lift(at.point, &by_both(&row.wrt_point, moved));
                    let pose = 6 * at.chunk.images[image] as usize;
                    right[pose..pose + 6].iter_mut().zip(lifted).for_each(|(sum, v)| *sum -= v);
                }
                let start = layout.cameras[camera];
                let params = by_both(&row.wrt_params, moved);
                let own = &mut right[start..start + layout.width];
                own.iter_mut().zip(params).for_each(|(sum, value)| *sum -= value);
            }
        }
    }
}

/// Of two rows, the first times x plus the second times y.
fn by_both<const N: usize>([first, second]: &[[f64; N]; 2], [x, y]: [f64; 2]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (lane, sum) in sum.iter_mut().enumerate() {
        *sum = first[lane] * x + second[lane] * y;
    }
    sum
}
