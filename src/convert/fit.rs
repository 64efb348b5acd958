//! The camera whose pixels are nearest to those that see some rays.

use std::marker::PhantomData;

use crate::camera::{CameraModel, Intrinsics, Job, Pair};
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
    let (params, cost) = start.visit(Fitting { pairs })?;
    Some(Fitted { camera: start.model().with_params(&params).ok()?, cost })
}

/// The mean of the squared errors, in px^2; none where a ray is not seen.
pub(super) fn mean_square(camera: &Intrinsics, pairs: &[Pair]) -> Option<f64> {
    let error = |(ray, pixel): &Pair| Some((camera.project(ray).ok()? - pixel).norm_squared());
    let sum = pairs.iter().map(error).sum::<Option<f64>>()?;
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

struct Fitting<'a> {
    pairs: &'a [Pair],
}

impl Job for Fitting<'_> {
    type Output = Option<(Vec<f64>, f64)>;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Self::Output {
        let options = Options { max_iterations: MAX_ITERATIONS, ..Options::default() };
        let mut lens = Lens::<M, N> {
            pairs: self.pairs,
            held: [false; N],
            normal: NormalEquations::new(N),
            model: PhantomData,
        };
        let mut state = *params;
        loop {
            let end = minimize(&mut lens, state, &options)?;
            state = end.state;
            // What was pushed to the end of its range is held there, so that the others find their best.
            match (0..N).find(|&index| !lens.held[index] && is_at_end::<M, N>(index, &state)) {
                Some(pushed) => lens.held[pushed] = true,
                None if end.reason == Reason::Stuck => return None,
                None => return Some((state.to_vec(), end.cost)),
            }
        }
    }
}

/// A model's parameters as unknowns.
struct Lens<'a, M, const N: usize> {
    pairs: &'a [Pair],
    /// Parameters that stay.
    held: [bool; N],
    normal: NormalEquations,
    model: PhantomData<M>,
}

impl<M: CameraModel<N>, const N: usize> Problem for Lens<'_, M, N> {
    type State = [f64; N];

    fn cost(&mut self, state: &[f64; N]) -> Option<f64> {
        let error =
            |(ray, pixel): &Pair| Some(0.5 * (M::project(state, ray)? - pixel).norm_squared());
        self.pairs.iter().map(error).sum::<Option<f64>>().filter(|cost| cost.is_finite())
    }

    fn linearize(&mut self, state: &[f64; N]) {
        self.normal.clear();
        for (ray, pixel) in self.pairs {
            let Some(at) = M::linearize(state, ray) else { continue };
            let error = at.pixel - pixel;
            for axis in 0..2 {
                let effect = |index: usize| at.wrt_params[(axis, index)];
                let row: [f64; N] =
                    std::array::from_fn(|index| if self.held[index] { 0.0 } else { effect(index) });
                self.normal.add(error[axis], &row);
            }
        }
    }

    fn solve(&mut self, damping: f64) -> Option<Step> {
        self.normal.solve(damping)
    }

    fn step(&self, state: &[f64; N], moved: &mut [f64; N]) {
        for (index, step) in self.normal.last_step().iter().enumerate() {
            let [least, most] = M::PARAMS[index].range;
            moved[index] = (state[index] + step).clamp(least, most);
        }
    }

    fn length(&self, state: &[f64; N]) -> f64 {
        state.iter().map(|value| value * value).sum::<f64>().sqrt()
    }

    fn freedom(&self) -> f64 {
        2.0 * self.pairs.len() as f64 - N as f64
    }
}

/// Whether a parameter stands at an end of its range.
fn is_at_end<M: CameraModel<N>, const N: usize>(index: usize, state: &[f64; N]) -> bool {
    let [least, most] = M::PARAMS[index].range;
    state[index] <= least || state[index] >= most
}
