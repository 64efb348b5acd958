//! Dense normal equations, for problems of few unknowns.

use nalgebra::{DMatrix, DVector};

use super::Step;

/// H and g of a linearisation, summed row by row, and the step that they give.
#[derive(Debug, Clone)]
pub struct NormalEquations {
    /// J^T J; only the lower triangle is kept.
    hessian: DMatrix<f64>,
    gradient: DVector<f64>,
    step: DVector<f64>,
}

impl NormalEquations {
    /// For so many unknowns.
    pub fn new(unknowns: usize) -> Self {
        let zeros = DVector::zeros(unknowns);
        Self { hessian: DMatrix::zeros(unknowns, unknowns), gradient: zeros.clone(), step: zeros }
    }

    /// Forgets what was added.
    pub fn clear(&mut self) {
        self.hessian.fill(0.0);
        self.gradient.fill(0.0);
    }

    /// Adds one residual and its derivatives.
    pub fn add(&mut self, residual: f64, row: &[f64]) {
        for (column, right) in row.iter().enumerate() {
            self.gradient[column] += right * residual;
            for (index, left) in row.iter().enumerate().skip(column) {
                self.hessian[(index, column)] += left * right;
            }
        }
    }

    /// The step that was solved for last.
    pub fn last_step(&self) -> &DVector<f64> {
        &self.step
    }

    /// Solves (H + damping diag(H)) step = -g by Cholesky, columns scaled to a diagonal of ones; an unknown without effect stays.
    pub fn solve(&mut self, damping: f64) -> Option<Step> {
        let scales = self.hessian.diagonal().map(|h| if h > 0.0 { 1.0 / h.sqrt() } else { 0.0 });
        let mut scaled = self.hessian.clone();
        for column in 0..scales.len() {
            for row in column..scales.len() {
                scaled[(row, column)] *= scales[row] * scales[column];
            }
            scaled[(column, column)] = 1.0 + damping;
        }
        let right = -self.gradient.component_mul(&scales);
        let scaled_step = scaled.cholesky()?.solve(&right);
        self.step = scaled_step.component_mul(&scales);
        let predicted = 0.5 * (damping * scaled_step.norm_squared() + right.dot(&scaled_step));
        let is_finite = self.step.iter().all(|value| value.is_finite());
        is_finite.then(|| Step {
            predicted,
            gradient: self.gradient.amax(),
            length: self.step.norm(),
        })
    }
}
