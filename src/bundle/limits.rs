//! What a user knows of intrinsics beforehand: Gaussian priors, which add to the cost, and bounds, on which parameters come to rest.
//!
//! A prior counts as one more residual of 1 px for each std that the parameter is off. A bound that a step would cross first ends
//! the step there; from then on the parameter is held while steps lead beyond: Nocedal and Wright, Numerical Optimization, 16.5.

use super::linearize::Lens;
use super::options::Options;
use super::problem::State;
use super::schur::{Layout, System};
use crate::scene::{CameraId, Scene};

/// A step that a bound cuts to less than this share is taken without the parameter, which is put on its bound.
const LEAST_SHARE: f64 = 0.01;

/// A free parameter: its camera, its place among the camera's parameters, and among those that move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Free {
    camera: usize,
    place: usize,
    index: usize,
}

/// Priors and bounds of the parameters that move.
#[derive(Debug, Clone, Default)]
pub(super) struct Limits {
    priors: Vec<(Free, [f64; 2])>,
    bounds: Vec<(Free, [f64; 2])>,
}

/// A parameter that rests on its bound.
#[derive(Debug, Clone, Copy)]
pub(super) struct Resting {
    free: Free,
    bound: f64,
}

impl Free {
    fn value(self, state: &State) -> f64 {
        state.params[self.camera][self.place]
    }

    fn unknown(self, layout: &Layout) -> usize {
        layout.cameras[self.camera] + self.index
    }
}

impl Resting {
    pub(super) fn is(&self, camera: usize, place: usize) -> bool {
        (self.free.camera, self.free.place) == (camera, place)
    }

    pub(super) fn unknown(&self, layout: &Layout) -> usize {
        self.free.unknown(layout)
    }
}

impl Limits {
    pub(super) fn new(
        scene: &Scene,
        cameras: &[CameraId],
        lenses: &[Lens],
        options: &Options,
    ) -> Self {
        let mut limits = Self::default();
        for (camera, (id, lens)) in cameras.iter().zip(lenses).enumerate() {
            let names = scene.cameras[id].intrinsics.model().params;
            for (index, &place) in lens.free.iter().enumerate() {
                let (free, name) = (Free { camera, place, index }, names[place].name);
                let prior = options.priors.iter().filter(|prior| prior.of.is(*id, name));
                // What is said of one camera goes before what is said of all.
                if let Some(prior) = prior.max_by_key(|prior| prior.of.camera) {
                    limits.priors.push((free, [prior.mean, prior.std]));
                }
                let bound = options.bounds.iter().filter(|bound| bound.of.is(*id, name));
                if let Some(bound) = bound.max_by_key(|bound| bound.of.camera) {
                    limits.bounds.push((free, [bound.least, bound.most]));
                }
            }
        }
        limits
    }

    /// Puts parameters that are out of their bounds on them, and those that rest there.
    pub(super) fn put_inside(&self, state: &mut State, resting: &[Resting]) {
        for Resting { free, bound } in resting {
            state.params[free.camera][free.place] = *bound;
        }
        for (free, [least, most]) in &self.bounds {
            let value = &mut state.params[free.camera][free.place];
            *value = value.max(*least).min(*most);
        }
    }

    /// Half the squares of what parameters are off their priors, in stds.
    pub(super) fn cost(&self, state: &State) -> f64 {
        let off = |&(free, [mean, std]): &(Free, [f64; 2])| (free.value(state) - mean) / std;
        self.priors.iter().map(off).map(|off| 0.5 * off * off).sum()
    }

    /// Adds the priors to the system.
    pub(super) fn add(&self, state: &State, layout: &Layout, system: &mut System) {
        for &(free, [mean, std]) in &self.priors {
            let weight = 1.0 / (std * std);
            system.add_prior(free.unknown(layout), weight, weight * (free.value(state) - mean));
        }
    }

    /// What its prior weighs, for the parameter of this camera and place; zero without one.
    pub(super) fn weight(&self, camera: usize, place: usize) -> f64 {
        let mut own = self.priors.iter().filter(|(f, _)| (f.camera, f.place) == (camera, place));
        own.next().map_or(0.0, |(_, [_, std])| 1.0 / (std * std))
    }

    /// Which share of a step stays within the bounds, or which parameter has to rest for it.
    pub(super) fn share(
        &self,
        state: &State,
        layout: &Layout,
        step: &[f64],
    ) -> Result<f64, Resting> {
        let mut share: f64 = 1.0;
        let mut first = None;
        for &(free, [least, most]) in &self.bounds {
            let (value, step) = (free.value(state), step[free.unknown(layout)]);
            let bound = if step > 0.0 { most } else { least };
            let own = (bound - value) / step;
            if step.abs() > 0.0 && own < share {
                (share, first) = (own, Some(Resting { free, bound }));
            }
        }
        first.filter(|_| share < LEAST_SHARE).map_or(Ok(share), Err)
    }

    /// The parameters that are on a bound.
    pub(super) fn resting(&self, state: &State) -> Vec<Resting> {
        let mut resting = Vec::new();
        for &(free, range) in &self.bounds {
            let value = free.value(state);
            // They were put there: to the bit.
            let bound = range.into_iter().find(|bound| bound.to_bits() == value.to_bits());
            resting.extend(bound.map(|bound| Resting { free, bound }));
        }
        resting
    }
}
