//! What the observations determine at the end of an adjustment: the rank, the noise, the covariance of the intrinsics.
//!
//! psi = rho' r is a residual as the loss counts it. With Lambda the intrinsics' Schur complement after poses and points of J^T J,
//! and Lambda_W that of J^T W J, W = d psi / d r, the curvature of the loss:
//! Sigma = |psi|^2 / (2N - rank J) Lambda_W^-1 Lambda Lambda_W^-1,
//! which for the squared loss is sigma^2 Lambda^-1. Huber, Robust Statistics, 1981, section 7.6, third form; poses and points are
//! eliminated from both matrices, so that Huber's correction for many unknowns per residual is in them already: psi is
//! orthogonal to J's columns of poses and points, of which Lambda is what is left, and W - W J (J^T W J)^-1 J^T W counts what an
//! observation still tells when poses and points have followed it (Bellec and Shen, COLT 2022).

#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};

use super::Loss;
use super::chunk::Chunk;
use super::clustered::{self, Fit};
use super::covariance::{Covariance, FreeParam, Lambda, OpenDirection, open_or_inverse};
use super::options::Options;
use super::problem::{Problem, State};
use super::schur::Layout;
use super::solver::{Known, Solver, sum_of};
use crate::least_squares::Trial;

/// What is determined, and how well.
pub(super) struct Determined {
    pub unknowns: usize,
    pub rank: usize,
    pub sigma_px: Option<f64>,
    pub covariance: Option<Covariance>,
}

/// At a state of this cost; `free` are the parameters that moved and are on no bound.
pub(super) fn determined(
    problem: &Problem,
    options: &Options,
    (state, cost, known): (&State, f64, Option<Known>),
    free: Vec<FreeParam>,
) -> Determined {
    let resting = problem.limits.resting(state);
    let unknowns = problem.unknowns(options).saturating_sub(resting.len());
    let layout = layout_with_resting(problem, state);
    let residuals = 2 * problem.observations;
    let squared = Options { loss: Loss::Squared, ..options.clone() };
    let (lambda, nullity) = information(problem, &squared, (state, known.as_ref()), &layout);
    let values = of_params(problem, &free, |camera, place| state.params[camera][place]);
    let weights = of_params(problem, &free, |camera, place| problem.limits.weight(camera, place));
    let found = open_or_inverse(&lambda, &values, residuals);
    let open = found.as_ref().err().map_or(0, Vec::len);
    let rank = unknowns.saturating_sub(nullity + open);
    // What priors determine takes up no residual: the trace of Lambda^-1 P.
    let by_priors = found.as_ref().map_or(0.0, |inverse| {
        inverse.diagonal().iter().zip(&weights).map(|(variance, weight)| variance * weight).sum()
    });
    let freedom = residuals as f64 - rank as f64 + by_priors;
    let is_over = residuals > rank;
    let left = 2.0 * (cost - problem.limits.cost(state));
    let sigma_px = is_over.then_some((left / freedom).sqrt());
    if free.is_empty() {
        return Determined { unknowns, rank, sigma_px, covariance: None };
    }
    let mut covariance = Covariance { params: free, matrix: None, clustered: vec![], open: vec![] };
    match found {
        Err(open) => covariance.open = open,
        Ok(inverse) if is_over => {
            let at = Found { problem, options, state, layout: &layout, weights: &weights };
            let psi = if options.loss == Loss::Squared { left } else { at.square_of_psi() };
            let fit = at.fit((&lambda, nullity), inverse, (psi, freedom));
            covariance.matrix = fit.as_ref().map(|fit| rows(&fit.covariance()));
            covariance.clustered = fit.map_or(vec![], |fit| {
                clustered::of_cameras(problem, &squared, (state, known), &covariance.params, &fit)
            });
        }
        Ok(_) => {}
    }
    Determined { unknowns, rank, sigma_px, covariance: Some(covariance) }
}

/// The directions that the observations leave open at a state: all of what is determined that takes no covariance.
pub(super) fn open(
    problem: &Problem,
    options: &Options,
    (state, known): (&State, Option<&Known>),
    free: &[FreeParam],
) -> Vec<OpenDirection> {
    let squared = Options { loss: Loss::Squared, ..options.clone() };
    let layout = layout_with_resting(problem, state);
    let (lambda, _) = information(problem, &squared, (state, known), &layout);
    let values = of_params(problem, free, |camera, place| state.params[camera][place]);
    open_or_inverse(&lambda, &values, 2 * problem.observations).err().unwrap_or_default()
}

/// The layout in which parameters on a bound stay.
fn layout_with_resting(problem: &Problem, state: &State) -> Layout {
    let mut layout = problem.layout.clone();
    for resting in problem.limits.resting(state) {
        layout.held[resting.unknown(&problem.layout)] = true;
    }
    layout
}

/// Something of each free parameter, by the number of its camera and its place there.
fn of_params(problem: &Problem, free: &[FreeParam], of: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let number = |id| problem.cameras.binary_search(&id).unwrap_or_default();
    free.iter().map(|param| of(number(param.camera), param.place)).collect()
}

/// Lambda at this state, and how many directions of poses and points are not determined.
fn information(
    problem: &Problem,
    options: &Options,
    (state, known): (&State, Option<&Known>),
    layout: &Layout,
) -> (Lambda, usize) {
    if let Some(Known { information, nullity, .. }) = known {
        return (Lambda::new(layout, information), *nullity);
    }
    let mut watch = |_: &Trial| ();
    let (information, nullity) = Solver::new(problem, options, &mut watch).information(state);
    (Lambda::new(layout, &information), nullity)
}

/// Where an adjustment ended.
struct Found<'a> {
    problem: &'a Problem,
    options: &'a Options,
    state: &'a State,
    layout: &'a Layout,
    weights: &'a [f64],
}

impl Found<'_> {
    /// With Lambda, its inverse, |psi|^2 and 2N - rank J; none where a robust loss has no minimum.
    fn fit(
        &self,
        (lambda, nullity): (&Lambda, usize),
        inverse: DMatrix<f64>,
        (psi, freedom): (f64, f64),
    ) -> Option<Fit> {
        let Self { problem, options, state, layout, weights } = self;
        let (variance, loss) = (psi / freedom, options.loss);
        let priors = DMatrix::from_diagonal(&DVector::from_column_slice(weights));
        if options.loss == Loss::Squared {
            let by_priors = &inverse * priors * &inverse;
            let by_noise = &inverse - &by_priors;
            let rights = DMatrix::identity(inverse.nrows(), inverse.ncols());
            return Some(Fit { variance, freedom, by_noise, by_priors, rights, loss });
        }
        let (bent, bent_nullity) = information(problem, options, (state, None), layout);
        let bread = bent.inverse().filter(|_| bent_nullity == nullity)?;
        let lambda = lambda.matrix();
        let by_priors = &bread * &priors * &bread;
        let by_noise = &bread * (&lambda - priors) * &bread;
        let rights = lambda * bread;
        Some(Fit { variance, freedom, by_noise, by_priors, rights, loss })
    }

    /// |psi|^2
    fn square_of_psi(&self) -> f64 {
        let Self { problem, options, state, .. } = self;
        let square_of_psi = |square: f64| options.loss.at(square).slope.powi(2) * square;
        let of_chunk = |chunk: &Chunk| sum_of(chunk, problem, state, square_of_psi);
        // What cannot be projected has no cost, and no adjustment ends there.
        problem.chunks.iter().map(of_chunk).sum::<Option<f64>>().unwrap_or(f64::NAN)
    }
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}
