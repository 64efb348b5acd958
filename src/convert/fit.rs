//! The camera whose pixels are nearest to those that see some rays.

use crate::camera::{Intrinsics, MOST_PARAMS, Model, Pair};
use crate::least_squares::{NormalEquations, Options, Problem, Reason, Step, minimize};

/// The end of a fit.
pub(super) struct Fitted {
    /// The camera.
    pub camera: Intrinsics,
    /// Half the sum of its squared errors, in px^2.
    pub cost: f64,
}

/// Steps to try at most: where numerator and denominator of a rational lens trade, hundreds are needed.
const MAX_ITERATIONS: usize = 1000;

/// The nearest camera down from a start; none when the way ends where the model stops seeing one of the rays.
pub(super) fn fit(start: &Intrinsics, pairs: &[Pair]) -> Option<Fitted> {
    let options = Options { max_iterations: MAX_ITERATIONS, ..Options::default() };
    let count = start.params().len();
    let (held, normal) = (vec![false; count], NormalEquations::new(count));
    let mut lens = Lens { model: start.model(), pairs, held, normal };
    let mut state = start.params().to_vec();
    loop {
        let end = minimize(&mut lens, state, &options)?;
        state = end.state;
        // What was pushed to the end of its range is held there, so that the others find their best.
        match (0..count).find(|&index| !lens.held[index] && lens.is_at_end(index, &state)) {
            Some(pushed) => lens.held[pushed] = true,
            None if end.reason == Reason::Stuck => return None,
            None => return Some(Fitted { camera: lens.camera(&state)?, cost: end.cost }),
        }
    }
}

/// The mean of the squared errors, in px^2; none where a ray is not seen.
pub(super) fn mean_square(camera: &Intrinsics, pairs: &[Pair]) -> Option<f64> {
    let sum = 2.0 * half_squares(camera, pairs)?;
    Some(sum / pairs.len() as f64).filter(|mean| mean.is_finite())
}

/// RMS and largest error, in px.
pub(super) fn errors_px(camera: &Intrinsics, pairs: &[Pair]) -> [f64; 2] {
    let error = |(ray, pixel): &Pair| {
        camera.project(ray).map_or(f64::INFINITY, |there| (there - pixel).norm())
    };
    let errors: Vec<f64> = pairs.iter().map(error).collect();
    let sum: f64 = errors.iter().map(|error| error * error).sum();
    [(sum / errors.len() as f64).sqrt(), errors.iter().copied().fold(0.0, f64::max)]
}

/// A model's parameters as unknowns.
struct Lens<'a> {
    model: &'static Model,
    pairs: &'a [Pair],
    /// Parameters that stay.
    held: Vec<bool>,
    normal: NormalEquations,
}

impl Lens<'_> {
    fn camera(&self, state: &[f64]) -> Option<Intrinsics> {
        self.model.with_params(state).ok()
    }

    /// Whether a parameter stands at an end of its range.
    fn is_at_end(&self, index: usize, state: &[f64]) -> bool {
        let [least, most] = self.model.params[index].range;
        state[index] <= least || state[index] >= most
    }
}

impl Problem for Lens<'_> {
    type State = Vec<f64>;

    fn cost(&mut self, state: &Vec<f64>) -> Option<f64> {
        let cost = half_squares(&self.camera(state)?, self.pairs)?;
        Some(cost).filter(|cost| cost.is_finite())
    }

    fn linearize(&mut self, state: &Vec<f64>) {
        self.normal.clear();
        let Some(camera) = self.camera(state) else { return };
        // A state without a cost is never linearised: every ray is seen.
        for (ray, pixel) in self.pairs {
            let Some(at) = camera.linearize(ray) else { continue };
            let error = at.pixel - pixel;
            for axis in 0..2 {
                let effect = |index: usize| at.wrt_params[(axis, index)];
                let row: [f64; MOST_PARAMS] = std::array::from_fn(|index| {
                    let is_held = self.held.get(index).is_none_or(|held| *held);
                    if is_held { 0.0 } else { effect(index) }
                });
                self.normal.add(error[axis], &row[..self.held.len()]);
            }
        }
    }

    fn solve(&mut self, damping: f64) -> Option<Step> {
        self.normal.solve(damping)
    }

    fn step(&self, state: &Vec<f64>, moved: &mut Vec<f64>) {
        for (index, step) in self.normal.last_step().iter().enumerate() {
            let [least, most] = self.model.params[index].range;
            moved[index] = (state[index] + step).clamp(least, most);
        }
    }

    fn length(&self, state: &Vec<f64>) -> f64 {
        state.iter().map(|value| value * value).sum::<f64>().sqrt()
    }

    fn freedom(&self) -> f64 {
        2.0 * self.pairs.len() as f64 - self.held.len() as f64
    }
}

/// Half the sum of the squared errors; none where a ray is not seen.
fn half_squares(camera: &Intrinsics, pairs: &[Pair]) -> Option<f64> {
    let half = |(ray, pixel): &Pair| Some(0.5 * (camera.project(ray).ok()? - pixel).norm_squared());
    pairs.iter().map(half).sum()
}
