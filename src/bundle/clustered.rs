//! The covariance if the errors of one image depend on each other, and how far it may lie from the plain one if none do.
//!
//! J~ are the intrinsics' columns of J after poses and points are projected out, s_g = J~_g^T psi_g the score of image g. In the
//! middle of the sandwich stands a multiple of sum s_g s_g^T, where the plain covariance has sigma^2 J~^T J~: Liang and Zeger 1986.
//!
//! Residuals are shorter than the noise, and the multiple makes up for it. Of independent noise points leave M_i sigma^2 in
//! observation i, M_i = 1 - J_point V^-1 J_point^T; poses take their average share of that; the intrinsics take what image g has of
//! all information, A_g = J~_g^T M_g J~_g / m in units of J~^T J~, m such that they add up to 1. So
//! multiple = 1 / m  sum tr M / (2N - rank J)  1 / (1 - 1/G), 1/G = sum tr(A_g^2) / p.
//! Were all observations and images alike this would be 2N / (2N - rank J) G / (G - 1) for G images. But those of long tracks tell
//! most, and of their noise least is absorbed: the plainer multiple is a tenth too large in small scenes.

use nalgebra::{Cholesky, DMatrix, DVector, Vector3};
use rayon::prelude::*;

use super::Loss;
use super::chunk::Chunk;
use super::covariance::FreeParam;
use super::eliminate::View;
use super::linearize::{MOST_PARAMS, Row};
use super::options::Options;
use super::point::InverseFactor;
use super::problem::{Problem, State};
use super::rows::block_of;
use super::solver::{Known, Solver, view};
use crate::least_squares::Trial;
use crate::scene::CameraId;

/// With fewer images the ratio to the plain covariance is chance.
const FEWEST_IMAGES: usize = 30;

/// The covariance of one camera's intrinsics if the errors of one image depend on each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Clustered {
    /// Which camera.
    pub camera: CameraId,
    /// How many of its images took part: the clusters.
    pub images: usize,
    /// The covariance, in the order of the camera's free parameters.
    pub matrix: Vec<Vec<f64>>,
    /// tr(Sigma_plain^-1 Sigma_clustered) / p for p parameters: the mean ratio of variances, however parameters are combined.
    pub ratio: f64,
    /// If errors do not depend on each other, the ratio times this is about chi-square with so many degrees.
    pub degrees: f64,
}

/// What the covariance is made of.
pub(super) struct Fit {
    /// |psi|^2 / (2N - rank J)
    pub variance: f64,
    /// 2N - rank J
    pub freedom: f64,
    /// Lambda_W^-1 (Lambda - P) Lambda_W^-1, P the weights of the priors.
    pub by_noise: DMatrix<f64>,
    /// Lambda_W^-1 P Lambda_W^-1
    pub by_priors: DMatrix<f64>,
    /// Lambda Lambda_W^-1
    pub rights: DMatrix<f64>,
    pub loss: Loss,
}

impl Fit {
    pub(super) fn covariance(&self) -> DMatrix<f64> {
        &self.by_noise * self.variance + &self.by_priors
    }
}

/// A camera with images enough.
struct Wanted {
    /// Its number in the problem.
    camera: usize,
    images: usize,
    /// Its rows among all parameters.
    rows: Vec<usize>,
    /// Of its share of `by_noise`.
    root: Cholesky<f64, nalgebra::Dyn>,
}

/// Of the cameras with images enough; `squared` are the options with the squared loss.
pub(super) fn of_cameras(
    problem: &Problem,
    squared: &Options,
    (state, known): (&State, Option<Known>),
    params: &[FreeParam],
    fit: &Fit,
) -> Vec<Clustered> {
    let wanted: Vec<Wanted> = (0..problem.cameras.len())
        .filter_map(|camera| wanted(problem, camera, params, fit))
        .collect();
    if wanted.is_empty() {
        return Vec::new();
    }
    let places: Vec<usize> = params.iter().map(|param| unknown(problem, param)).collect();
    let mut directions = Vec::new();
    for Wanted { rows, root, .. } in &wanted {
        // In units in which the plain covariance is one: L^-1 times the rows of Lambda_W^-1 J~^T.
        let Some(whitening) = root.l().try_inverse() else { return Vec::new() };
        for whitened in (fit.rights.select_columns(rows) * whitening.transpose()).column_iter() {
            let mut right = vec![0.0; problem.layout.size];
            places.iter().zip(whitened.iter()).for_each(|(&place, value)| right[place] = *value);
            directions.push(right);
        }
    }
    match known {
        Some(mut known) => known.system.more_answers(&mut directions),
        None => {
            let mut watch = |_: &Trial| ();
            Solver::new(problem, squared, &mut watch).answers(state, &mut directions);
        }
    }
    let pass = Pass {
        problem,
        view: view(problem, squared, state, false),
        loss: fit.loss,
        directions: &directions,
        sizes: wanted.iter().map(|one| one.rows.len()).collect(),
    };
    let sums = pass.whole();
    let mut start = 0;
    let of_camera = |(at, one): (usize, &Wanted)| {
        start += one.rows.len();
        clustered(problem, fit, one, &sums, (at, start - one.rows.len()))
    };
    wanted.iter().enumerate().filter_map(of_camera).collect()
}

fn wanted(problem: &Problem, camera: usize, params: &[FreeParam], fit: &Fit) -> Option<Wanted> {
    let took = |&image: &usize| {
        problem.camera_of[image] as usize == camera && problem.sightings[image] > 0
    };
    let images = (0..problem.images.len()).filter(took).count();
    let is_own = |&row: &usize| params[row].camera == problem.cameras[camera];
    let rows: Vec<usize> = (0..params.len()).filter(is_own).collect();
    if images < FEWEST_IMAGES || rows.is_empty() {
        return None;
    }
    let root = fit.by_noise.select_rows(&rows).select_columns(&rows).cholesky()?;
    Some(Wanted { camera, images, rows, root })
}

/// Where a parameter stands in the system.
fn unknown(problem: &Problem, param: &FreeParam) -> usize {
    let camera = problem.cameras.binary_search(&param.camera).unwrap_or_default();
    let index = problem.lenses[camera].free.binary_search(&param.place).unwrap_or_default();
    problem.layout.cameras[camera] + index
}

/// One camera's, by its place among the wanted ones and that of its first direction; none where one image tells everything.
fn clustered(
    problem: &Problem,
    fit: &Fit,
    one: &Wanted,
    sums: &Sums,
    (at, start): (usize, usize),
) -> Option<Clustered> {
    let count = one.rows.len();
    let size = count as f64;
    let shares: Vec<DMatrix<f64>> =
        sums.shares[at].iter().map(|of| DMatrix::from_column_slice(count, count, of)).collect();
    let kept = shares.iter().map(DMatrix::trace).sum::<f64>() / size;
    let squares = shares.iter().map(DMatrix::norm_squared).sum::<f64>() / (kept * kept);
    let factor = sums.left / fit.freedom / (kept * (1.0 - squares / size));
    if !(factor.is_finite() && factor > 0.0) {
        return None;
    }
    let mut middle = DMatrix::zeros(count, count);
    for scores in &sums.scores {
        let score = DVector::from_column_slice(&scores[start..start + count]);
        middle.ger(factor, &score, &score, 1.0);
    }
    let ratio = middle.trace() / (size * fit.variance);
    let root = one.root.l();
    let own = fit.by_priors.select_rows(&one.rows).select_columns(&one.rows);
    let matrix = &root * middle * root.transpose() + own;
    // The variance of a sum of squares of sums of independent errors, of any excess.
    let spread = 2.0 * squares + sums.excess() * sums.fourths[at] / (kept * kept);
    Some(Clustered {
        camera: problem.cameras[one.camera],
        images: one.images,
        matrix: matrix.row_iter().map(|row| row.iter().copied().collect()).collect(),
        ratio,
        degrees: 2.0 * size * size / spread,
    })
}

/// The pass over the observations.
struct Pass<'a> {
    problem: &'a Problem,
    /// Of the squared loss.
    view: View<'a>,
    loss: Loss,
    /// Where poses and intrinsics go in each direction.
    directions: &'a [Vec<f64>],
    /// How many directions each camera has.
    sizes: Vec<usize>,
}

/// Sums over observations.
#[derive(Debug, Clone)]
struct Sums {
    /// By image, a number for each direction.
    scores: Vec<Vec<f64>>,
    /// By camera and image, J~^T M J~ in the camera's directions.
    shares: Vec<Vec<Vec<f64>>>,
    /// By camera, the sum of the squares of what each residual has of that.
    fourths: Vec<f64>,
    /// The sum of tr M.
    left: f64,
    /// Of psi, its second and fourth powers, and how many.
    powers: [f64; 3],
}

impl Sums {
    fn new(images: usize, sizes: &[usize]) -> Self {
        Self {
            scores: vec![vec![0.0; sizes.iter().sum()]; images],
            shares: sizes.iter().map(|size| vec![vec![0.0; size * size]; images]).collect(),
            fourths: vec![0.0; sizes.len()],
            left: 0.0,
            powers: [0.0; 3],
        }
    }

    /// Kurtosis of psi beyond that of normal noise.
    fn excess(&self) -> f64 {
        let [second, fourth, count] = self.powers;
        count * fourth / (second * second) - 3.0
    }

    /// Adds those of a chunk.
    fn add(&mut self, chunk: &Chunk, other: &Self) {
        let add = |sum: &mut Vec<f64>, values: &Vec<f64>| {
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        };
        for (local, &image) in chunk.images.iter().enumerate() {
            add(&mut self.scores[image as usize], &other.scores[local]);
            for (sum, shares) in self.shares.iter_mut().zip(&other.shares) {
                add(&mut sum[image as usize], &shares[local]);
            }
        }
        add(&mut self.fourths, &other.fourths);
        self.left += other.left;
        self.powers.iter_mut().zip(other.powers).for_each(|(sum, value)| *sum += value);
    }

    /// Adds one observation: how far each direction moves its two residuals.
    fn add_observation(&mut self, seen: &Seen, moved: [&[f64]; 2], sizes: &[usize]) {
        let &Seen { image, psi, left: [[xx, xy], [_, yy]] } = seen;
        for (psi, moved) in psi.into_iter().zip(moved) {
            self.powers[0] += psi * psi;
            self.powers[1] += psi * psi * psi * psi;
            self.powers[2] += 1.0;
            let scores = self.scores[image].iter_mut().zip(moved);
            scores.for_each(|(sum, value)| *sum += psi * value);
        }
        self.left += xx + yy;
        let mut start = 0;
        for (at, &size) in sizes.iter().enumerate() {
            let [x, y] = moved.map(|moved| &moved[start..start + size]);
            start += size;
            let rows = self.shares[at][image].chunks_exact_mut(size);
            for (row, (a, b)) in rows.zip(x.iter().zip(y)) {
                let (by_x, by_y) = (xx * a + xy * b, xy * a + yy * b);
                for (sum, (x, y)) in row.iter_mut().zip(x.iter().zip(y)) {
                    *sum += by_x * x + by_y * y;
                }
            }
            let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
            self.fourths[at] += (xx * square(x)).powi(2) + (yy * square(y)).powi(2);
        }
    }
}

/// An observation: its image as the chunk numbers it, psi, and M, what its point leaves of its noise.
struct Seen {
    image: usize,
    psi: [f64; 2],
    left: [[f64; 2]; 2],
}

impl Seen {
    fn new(row: &Row, image: usize, inverse: &InverseFactor, loss: Loss) -> Self {
        let [x, y] = row.residual;
        let slope = loss.at(x * x + y * y).slope;
        let [a, b] = row.wrt_point.map(|along| Vector3::from(inverse.times(&along)));
        let both = -a.dot(&b);
        Self {
            image,
            psi: row.residual.map(|residual| slope * residual),
            left: [[1.0 - a.dot(&a), both], [both, 1.0 - b.dot(&b)]],
        }
    }
}

impl Pass<'_> {
    fn whole(&self) -> Sums {
        let of_chunks: Vec<Sums> =
            self.problem.chunks.par_iter().map(|chunk| self.of_chunk(chunk)).collect();
        let mut sums = Sums::new(self.problem.images.len(), &self.sizes);
        self.problem.chunks.iter().zip(&of_chunks).for_each(|(chunk, own)| sums.add(chunk, own));
        sums
    }

    fn of_chunk(&self, chunk: &Chunk) -> Sums {
        let view = &self.view;
        let mut sums = Sums::new(chunk.images.len(), &self.sizes);
        let mut rows = vec![Row::ZERO; chunk.longest];
        let mut moved = vec![vec![0.0; self.directions.len()]; 2 * chunk.longest];
        let mut start = 0;
        for (&end, point) in chunk.ends.iter().zip(&view.points[chunk.points.clone()]) {
            let track = &chunk.sightings[start..end as usize];
            start = end as usize;
            let rows = &mut rows[..track.len()];
            let block = block_of::<MOST_PARAMS, false>(chunk, view, (point, track), rows);
            let inverse = if view.moves_points { block.factor(0.0) } else { InverseFactor::ZERO };
            let seen = rows.iter().zip(track.iter().map(|seen| seen.image as usize));
            let seen: Vec<(&Row, usize)> = seen.collect();
            for (at, direction) in self.directions.iter().enumerate() {
                self.follow(chunk, (point, &inverse), direction, &seen, |residual, value| {
                    moved[residual][at] = value;
                });
            }
            for (at, (row, image)) in seen.into_iter().enumerate() {
                let seen = Seen::new(row, image, &inverse, self.loss);
                sums.add_observation(&seen, [&moved[2 * at], &moved[2 * at + 1]], &self.sizes);
            }
        }
        sums
    }

    /// How far a direction moves each residual of a point, the point following.
    fn follow(
        &self,
        chunk: &Chunk,
        (point, inverse): (&Vector3<f64>, &InverseFactor),
        direction: &[f64],
        seen: &[(&Row, usize)],
        mut give: impl FnMut(usize, f64),
    ) {
        let layout = &self.problem.layout;
        let of_observation = |&(row, image): &(&Row, usize)| {
            let mut moved = Vector3::zeros();
            if self.view.moves_poses {
                let start = 6 * chunk.images[image] as usize;
                if let [a, b, c, x, y, z] = direction[start..start + 6] {
                    moved = Vector3::new(a, b, c).cross(point) + Vector3::new(x, y, z);
                }
            }
            let camera = chunk.cameras[chunk.camera_of[image] as usize] as usize;
            let params = &direction[layout.cameras[camera]..][..layout.width];
            [0, 1].map(|axis| {
                let by_params = row.wrt_params[axis].iter().zip(params).map(|(j, step)| j * step);
                Vector3::from(row.wrt_point[axis]).dot(&moved) + by_params.sum::<f64>()
            })
        };
        let before: Vec<[f64; 2]> = seen.iter().map(of_observation).collect();
        let mut product = Vector3::zeros();
        for ((row, _), change) in seen.iter().zip(&before) {
            for (along, change) in row.wrt_point.into_iter().zip(change) {
                product += Vector3::from(along) * *change;
            }
        }
        let step = -Vector3::from(inverse.transpose_times(&inverse.times(&product.into())));
        for (at, ((row, _), change)) in seen.iter().zip(before).enumerate() {
            for (axis, (along, change)) in row.wrt_point.into_iter().zip(change).enumerate() {
                give(2 * at + axis, change + Vector3::from(along).dot(&step));
            }
        }
    }
}
