//! Levenberg-Marquardt: the loop alone, over whatever can linearise itself and solve its damped normal equations.
//!
//! Knows nothing of cameras. Levenberg 1944, Marquardt 1963; damping after Nielsen, IMM-REP-1999-05.

mod dense;

pub use dense::NormalEquations;

/// A sum of squares to be made small: cost(x) = 1/2 |r(x)|^2, or its robust kin.
pub trait Problem {
    /// The unknowns.
    type State: Clone;

    /// The cost; none where it cannot be evaluated, so that no step may lead there.
    fn cost(&mut self, state: &Self::State) -> Option<f64>;

    /// Builds the normal equations at a state that has a cost.
    fn linearize(&mut self, state: &Self::State);

    /// Solves (H + damping diag(H)) step = -g of the last `linearize`, and keeps the step; none when that is singular.
    fn solve(&mut self, damping: f64) -> Option<Step>;

    /// Where the last step leads from `state`.
    fn step(&self, state: &Self::State, moved: &mut Self::State);

    /// The length of the unknowns.
    fn length(&self, state: &Self::State) -> f64;

    /// How many residuals there are beyond those that the unknowns take up: cost / (freedom / 2) is the variance of one.
    fn freedom(&self) -> f64;

    /// Told of every step that was tried, for whoever watches.
    fn tried(&mut self, _: &Trial) {}
}

/// A step that was tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Counted from 1.
    pub iteration: usize,
    /// The cost before it.
    pub cost: f64,
    /// What was known of it; none when the damped equations were singular.
    pub step: Option<Step>,
    /// By how much the cost fell; none when the step was taken back.
    pub fall: Option<f64>,
    /// The damping by which it was found.
    pub damping: f64,
}

/// What is known of a step before it is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// By how much the cost falls if the linearisation holds; undamped it is 1/2 g^T H^-1 g.
    pub predicted: f64,
    /// The largest component of the gradient, as a size.
    pub gradient: f64,
    /// Its length.
    pub length: f64,
}

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// When g^T H^-1 g, undamped, is at most this share of the variance of one residual: at 1e-12 no unknown would move by
    /// more than 1e-6 of its standard deviation, in whatever unit.
    Decrement(f64),
    /// Ceres' three tolerances; the first that is met stops.
    Tolerances {
        /// On the relative fall of the cost.
        function: f64,
        /// On the largest component of the gradient.
        gradient: f64,
        /// On the length of the step relative to that of the unknowns.
        parameter: f64,
    },
}

/// How to minimise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// When to stop.
    pub stop: Stop,
    /// Steps to try at most, those that are taken back included.
    pub max_iterations: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { stop: Stop::Decrement(1e-12), max_iterations: 100 }
    }
}

/// Why the minimisation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    /// The stopping rule was met.
    Converged,
    /// Rounding hides any further fall of the cost.
    Rounding,
    /// The iterations ran out.
    IterationLimit,
    /// No step leads downhill, however short.
    Stuck,
}

/// The end of a minimisation.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome<S> {
    /// The unknowns at the end.
    pub state: S,
    /// The cost before.
    pub initial_cost: f64,
    /// The cost after.
    pub cost: f64,
    /// Steps that were tried.
    pub iterations: usize,
    /// Why it ended.
    pub reason: Reason,
}

/// Damping at the start, a tenth of Ceres': reconstructions start so near their end that more of it costs a step.
const FIRST_DAMPING: f64 = 1e-5;
/// Damping within which a Gauss-Newton step is indistinguishable from a damped one.
const LEAST_DAMPING: f64 = 1e-15;
/// Beyond this damping a step is too short to matter.
const MOST_DAMPING: f64 = 1e32;
/// Below this share of the cost its fall is made of rounding: the model is then a better judge of a step than the cost is.
const COST_ROUNDING: f64 = 1e-13;

/// Minimises from a start; none when the start has no cost.
pub fn minimize<P: Problem>(
    problem: &mut P,
    start: P::State,
    options: &Options,
) -> Option<Outcome<P::State>> {
    let cost = problem.cost(&start)?;
    problem.linearize(&start);
    let moved = start.clone();
    let search = Search {
        problem,
        state: start,
        moved,
        cost,
        damping: FIRST_DAMPING,
        growth: 2.0,
        is_near: false,
        is_damped: true,
    };
    Some(search.run(cost, options))
}

struct Search<'a, P: Problem> {
    problem: &'a mut P,
    state: P::State,
    moved: P::State,
    cost: f64,
    damping: f64,
    /// What the next rejection multiplies the damping by.
    growth: f64,
    /// Whether the last step was good, and moved no unknown by more than about its standard deviation.
    is_near: bool,
    /// Whether the step at hand was found with damping.
    is_damped: bool,
}

impl<P: Problem> Search<'_, P> {
    fn run(mut self, initial_cost: f64, options: &Options) -> Outcome<P::State> {
        let mut reason = Reason::IterationLimit;
        let mut iterations = 0;
        let mut last_fall = f64::INFINITY;
        while iterations < options.max_iterations {
            if self.damping > MOST_DAMPING {
                reason = Reason::Stuck;
                break;
            }
            let Some(mut step) = self.next_step(options.stop) else {
                iterations += 1;
                let (cost, damping) = (self.cost, self.damping);
                let trial = Trial { iteration: iterations, cost, step: None, fall: None, damping };
                self.problem.tried(&trial);
                self.damp();
                continue;
            };
            if self.is_small(&step, options.stop) {
                step = self.undamped(step, options.stop);
            }
            if self.is_small(&step, options.stop) {
                reason = Reason::Converged;
                break;
            }
            iterations += 1;
            let is_hidden = step.predicted <= COST_ROUNDING * self.cost;
            if is_hidden && step.predicted > 0.5 * last_fall {
                reason = Reason::Rounding;
                break;
            }
            let trial = Trial {
                iteration: iterations,
                cost: self.cost,
                step: Some(step),
                fall: None,
                damping: if self.is_damped { self.damping } else { 0.0 },
            };
            let fall = self.try_step(&step, is_hidden);
            self.is_near = fall.is_some() && step.predicted <= self.variance();
            self.problem.tried(&Trial { fall, ..trial });
            match fall {
                Some(fall) => {
                    last_fall = step.predicted;
                    if is_flat(fall, self.cost, options.stop) {
                        reason = Reason::Converged;
                        break;
                    }
                    self.problem.linearize(&self.state);
                }
                None if self.is_damped => self.damp(),
                None => {}
            }
        }
        let Self { state, cost, .. } = self;
        Outcome { state, initial_cost, cost, iterations, reason }
    }

    /// Without damping near the end, which damping would only put off.
    fn next_step(&mut self, stop: Stop) -> Option<Step> {
        let is_wanted = self.is_near && matches!(stop, Stop::Decrement(_));
        let step = is_wanted.then(|| self.problem.solve(0.0)).flatten();
        self.is_damped = step.is_none();
        step.or_else(|| self.problem.solve(self.damping))
    }

    /// The same step without damping, which shortens steps, most of all along weak directions: only the undamped one shows how
    /// far the end is.
    fn undamped(&mut self, damped: Step, stop: Stop) -> Step {
        if !self.is_damped || !matches!(stop, Stop::Decrement(_)) {
            return damped;
        }
        let step = self.problem.solve(0.0);
        self.is_damped = step.is_none();
        step.or_else(|| self.problem.solve(self.damping)).unwrap_or(damped)
    }

    /// Of one residual.
    fn variance(&self) -> f64 {
        self.cost / self.problem.freedom().max(1.0)
    }

    /// Whether nothing is to be gained by this step.
    fn is_small(&self, step: &Step, stop: Stop) -> bool {
        match stop {
            Stop::Decrement(share) => step.predicted <= share * self.variance(),
            Stop::Tolerances { gradient, parameter, .. } => {
                let length = self.problem.length(&self.state);
                step.gradient <= gradient || step.length <= parameter * (length + parameter)
            }
        }
    }

    /// Takes the step if the cost falls, and tells by how much.
    fn try_step(&mut self, step: &Step, is_hidden: bool) -> Option<f64> {
        /// Ceres' least ratio between true and predicted fall.
        const LEAST_GAIN: f64 = 1e-3;
        self.problem.step(&self.state, &mut self.moved);
        let cost = self.problem.cost(&self.moved)?;
        let fall = self.cost - cost;
        let gain = fall / step.predicted;
        let is_good = gain > LEAST_GAIN || is_hidden && fall >= -COST_ROUNDING * self.cost;
        if !is_good {
            return None;
        }
        if !is_hidden {
            let shrink = 1.0 - (2.0 * gain - 1.0).powi(3);
            // A model that foretells the fall so well has earned a step as good as undamped.
            let least = if (gain - 1.0).abs() < 0.1 { 0.01 } else { 1.0 / 3.0 };
            self.damping = (self.damping * shrink.max(least)).max(LEAST_DAMPING);
        }
        self.growth = 2.0;
        self.cost = cost;
        std::mem::swap(&mut self.state, &mut self.moved);
        Some(fall)
    }

    fn damp(&mut self) {
        self.damping *= self.growth;
        self.growth *= 2.0;
    }
}

fn is_flat(fall: f64, cost: f64, stop: Stop) -> bool {
    match stop {
        Stop::Decrement(_) => false,
        Stop::Tolerances { function, .. } => fall <= function * (cost + fall),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals of plain functions, for tests: value and rows of the derivative.
    struct Fit<F> {
        residuals: F,
        normal: NormalEquations,
        freedom: f64,
    }

    impl<F: Fn(&[f64]) -> Option<Vec<(f64, Vec<f64>)>>> Problem for Fit<F> {
        type State = Vec<f64>;

        fn cost(&mut self, state: &Vec<f64>) -> Option<f64> {
            Some((self.residuals)(state)?.iter().map(|(value, _)| 0.5 * value * value).sum())
        }

        fn linearize(&mut self, state: &Vec<f64>) {
            self.normal.clear();
            for (value, row) in (self.residuals)(state).unwrap_or_default() {
                self.normal.add(value, &row);
            }
        }

        fn solve(&mut self, damping: f64) -> Option<Step> {
            self.normal.solve(damping)
        }

        fn step(&self, state: &Vec<f64>, moved: &mut Vec<f64>) {
            moved.clear();
            moved.extend(state.iter().zip(self.normal.last_step().iter()).map(|(x, d)| x + d));
        }

        fn length(&self, state: &Vec<f64>) -> f64 {
            state.iter().map(|value| value * value).sum::<f64>().sqrt()
        }

        fn freedom(&self) -> f64 {
            self.freedom
        }
    }

    fn fit(
        start: &[f64],
        residuals: impl Fn(&[f64]) -> Option<Vec<(f64, Vec<f64>)>>,
    ) -> Outcome<Vec<f64>> {
        let count = residuals(start).unwrap().len().saturating_sub(start.len());
        let normal = NormalEquations::new(start.len());
        let mut problem = Fit { residuals, normal, freedom: count as f64 };
        minimize(&mut problem, start.to_vec(), &Options::default()).unwrap()
    }

    #[test]
    fn the_valley_of_rosenbrock_is_walked_to_its_end() {
        let end = fit(&[-1.2, 1.0], |x| {
            Some(vec![
                (10.0 * (x[1] - x[0] * x[0]), vec![-20.0 * x[0], 10.0]),
                (1.0 - x[0], vec![-1.0, 0.0]),
            ])
        });
        assert!((end.state[0] - 1.0).abs() < 1e-9 && (end.state[1] - 1.0).abs() < 1e-9, "{end:?}");
        assert!(end.iterations < 50, "{end:?}");
    }

    #[test]
    fn a_decay_is_fitted_as_nist_certifies() {
        // NIST StRD Misra1a, y = b1 (1 - exp(-b2 x)); certified b1 2.3894212918E+02, b2 5.5015643181E-04
        let x = [
            77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1,
            689.1, 760.0,
        ];
        let y = [
            10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40,
            75.47, 81.78,
        ];
        let end = fit(&[500.0, 1e-4], |b| {
            let row = |(x, y): (&f64, &f64)| {
                let decay = (-b[1] * x).exp();
                (b[0] * (1.0 - decay) - y, vec![1.0 - decay, b[0] * x * decay])
            };
            Some(x.iter().zip(&y).map(row).collect())
        });
        // The rule promises a millionth of the certified standard deviations.
        assert!((end.state[0] - 238.942_129_18).abs() < 1e-6 * 2.707_007_524_1, "{end:?}");
        assert!((end.state[1] - 5.501_564_318_1e-4).abs() < 1e-6 * 7.266_868_843_6e-6, "{end:?}");
        assert!((2.0 * end.cost / 1.245_513_889_4e-1 - 1.0).abs() < 1e-9, "{end:?}");
    }

    #[test]
    fn no_step_leads_where_there_is_no_cost() {
        // The minimum of (x + 1)^2 lies where the logarithm is not defined: the search ends at the border.
        let end = fit(&[2.0], |x| (x[0] > 0.0).then(|| vec![(x[0] + 1.0, vec![1.0])]));
        assert!(end.state[0] > 0.0 && end.state[0] < 1e-3, "{end:?}");
        assert_ne!(end.reason, Reason::Converged, "{end:?}");
    }

    #[test]
    fn an_unknown_without_effect_stays() {
        let end = fit(&[5.0, 7.0], |x| Some(vec![(x[0] - 1.0, vec![1.0, 0.0])]));
        assert!((end.state[0] - 1.0).abs() < 1e-12 && end.state[1].to_bits() == 7.0_f64.to_bits());
    }
}
