//! The problem as Levenberg-Marquardt's loop sees it: cost, system, step.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::chunk::Chunk;
use super::eliminate::{Sums, View, eliminate};
use super::follow::{Followed, PointStep, Room, follow};
use super::limits::Resting;
use super::linearize::{Params, Row};
use super::options::Options;
use super::problem::{Problem, State};
use super::schur::{Information, System};
use super::{BundleError, Loss};
use crate::least_squares::{self, Step};

/// What the last step of an adjustment leaves, if it is undamped and not taken.
#[derive(Debug, Clone)]
pub(super) struct Known {
    pub information: Information,
    /// In how many directions poses and points are not determined.
    pub nullity: usize,
    /// With its factor.
    pub system: System,
}

/// The problem with room to work in.
pub(super) struct Solver<'a> {
    problem: &'a Problem,
    options: &'a Options,
    /// Where it was linearised.
    at: State,
    /// For as many chunks as are worked on at a time.
    sums: Vec<Sums>,
    /// Where the points go.
    point_steps: Vec<Vector3<f64>>,
    system: System,
    pose_steps: Vec<[f64; 6]>,
    param_steps: Vec<Params>,
    costs: Vec<Option<f64>>,
    /// Parameters that stay on their bounds, and the share of the step at which the next bound is met.
    resting: Vec<Resting>,
    share: f64,
    freedom: f64,
    /// Whether the loss's curvature counts as it is: near the end that makes steps few; far from it they would lead astray.
    bends: bool,
    /// The fall of the cost that the last step promised.
    predicted: f64,
    /// In how many directions points were not determined.
    open_points: usize,
    watch: &'a mut dyn FnMut(&least_squares::Trial),
}

impl<'a> Solver<'a> {
    pub(super) fn new(
        problem: &'a Problem,
        options: &'a Options,
        watch: &'a mut dyn FnMut(&least_squares::Trial),
    ) -> Self {
        let unknowns = problem.unknowns(options);
        Self {
            at: problem.start.clone(),
            sums: vec![Sums::default(); at_a_time(problem.chunks.len())],
            point_steps: vec![Vector3::zeros(); problem.points.len()],
            system: System::new(problem.layout.clone(), &problem.shape),
            pose_steps: vec![[0.0; 6]; problem.images.len()],
            param_steps: vec![[0.0; super::linearize::MOST_PARAMS]; problem.cameras.len()],
            costs: vec![None; problem.chunks.len()],
            resting: Vec::new(),
            share: 1.0,
            freedom: (2 * problem.observations) as f64 - unknowns as f64,
            bends: false,
            predicted: f64::INFINITY,
            open_points: 0,
            problem,
            options,
            watch,
        }
    }

    /// Adds all points to the system at the last state; tells what points alone predict, doubled, their largest gradient, and in
    /// how many directions they are not determined.
    fn eliminate(&mut self, damping: f64) -> (f64, f64, usize) {
        let Self { problem, options, at, sums, system, resting, bends, .. } = self;
        let view = view(problem, options, at, *bends);
        system.clear();
        let mut total = (0.0, 0.0, 0);
        for chunks in problem.chunks.chunks(sums.len()) {
            let each = chunks.par_iter().zip(sums.par_iter_mut());
            each.for_each(|(chunk, sums)| eliminate(chunk, &view, damping, sums));
            for (chunk, sums) in chunks.iter().zip(&*sums) {
                system.add(chunk, sums);
                let (by_points, most, nullity) = total;
                let most = sums.point_gradient.max(most);
                total = (by_points + sums.by_points, most, nullity + sums.nullity);
            }
        }
        problem.limits.add(at, &problem.layout, system);
        let resting = resting.iter().map(|resting| resting.unknown(&problem.layout));
        system.hold(&problem.layout.held, resting);
        total
    }

    /// The information on the intrinsics at this state, and how many directions of poses and points are not determined. That of a
    /// robust loss is its own curvature.
    pub(super) fn information(&mut self, state: &State) -> (Information, usize) {
        self.at.clone_from(state);
        self.resting = self.problem.limits.resting(state);
        self.bends = self.options.loss.bends_down();
        let (.., points) = self.eliminate(0.0);
        let (information, poses) = self.system.information();
        (information, points + poses)
    }

    /// What the last solution knows of this state: nothing if that was damped, at another state, or of a robust loss, whose own
    /// curvature tells less than the observations.
    pub(super) fn into_known(mut self, state: &State) -> Option<Known> {
        let is_free = self.resting.is_empty() && self.problem.limits.resting(state).is_empty();
        let is_squared = self.options.loss == Loss::Squared;
        let (information, poses) = self.system.left.take().filter(|_| is_free && is_squared)?;
        Some(Known { information, nullity: poses + self.open_points, system: self.system })
    }

    /// Solves the undamped system at this state for each right side; gives its gradient, points eliminated.
    pub(super) fn answers(&mut self, state: &State, rights: &mut [Vec<f64>]) -> Vec<f64> {
        self.at.clone_from(state);
        self.resting = self.problem.limits.resting(state);
        self.bends = false;
        self.eliminate(0.0);
        self.system.answers(rights)
    }

    /// Lets every point follow the poses and the intrinsics.
    fn follow(&mut self, damping: f64) -> PointStep {
        for (image, step) in self.pose_steps.iter_mut().enumerate() {
            *step = self.system.pose_step(image).unwrap_or_default();
        }
        for (camera, step) in self.param_steps.iter_mut().enumerate() {
            *step = self.system.camera_step(camera);
        }
        if !self.options.mode.moves_points() {
            return PointStep::default();
        }
        let view = view(self.problem, self.options, &self.at, self.bends);
        let followed = Followed { poses: &self.pose_steps, params: &self.param_steps, damping };
        let mut rest = self.point_steps.as_mut_slice();
        let of_chunks: Vec<&mut [Vector3<f64>]> = (self.problem.chunks.iter())
            .map_while(|chunk| rest.split_off_mut(..chunk.points.len()))
            .collect();
        let chunks = self.problem.chunks.par_iter().zip(of_chunks);
        let steps = chunks.map_init(Vec::new, |rows, (chunk, steps)| {
            rows.resize(chunk.longest.max(rows.len()), Row::ZERO);
            follow(chunk, &view, &followed, &mut Room { rows, steps })
        });
        let mut total = PointStep::default();
        for step in steps.collect::<Vec<_>>() {
            total.weighed_square += step.weighed_square;
            total.square += step.square;
        }
        total
    }
}

/// Adjusts a problem from its start; with what its last step leaves.
pub(super) fn minimize(
    problem: &Problem,
    options: &Options,
    watch: &mut dyn FnMut(&least_squares::Trial),
) -> Result<(least_squares::Outcome<State>, Option<Known>), BundleError> {
    let mut solver = Solver::new(problem, options, watch);
    let end = least_squares::minimize(&mut solver, problem.start.clone(), &options.stop);
    let end = end.ok_or(BundleError::NoCost)?;
    let known = solver.into_known(&end.state);
    Ok((end, known))
}

/// How many chunks are worked on before their sums are added: enough to keep all threads busy, few enough to be forgotten.
pub(super) fn at_a_time(chunks: usize) -> usize {
    (4 * rayon::current_num_threads()).min(chunks).max(1)
}

pub(super) fn view<'a>(
    problem: &'a Problem,
    options: &Options,
    state: &'a State,
    bends: bool,
) -> View<'a> {
    View {
        lenses: &problem.lenses,
        params: &state.params,
        poses: &state.poses,
        points: &state.points,
        width: problem.layout.width,
        loss: options.loss,
        bends,
        moves_poses: options.mode.moves_poses(),
        moves_points: options.mode.moves_points(),
    }
}

/// The cost of a chunk's points; none where one cannot be projected.
fn cost(chunk: &Chunk, problem: &Problem, loss: Loss, state: &State) -> Option<f64> {
    Some(0.5 * sum_of(chunk, problem, state, |square| loss.at(square).value)?)
}

/// A sum over a chunk's observations of something of the square of the residual; none where one cannot be projected.
#[inline]
pub(super) fn sum_of(
    chunk: &Chunk,
    problem: &Problem,
    state: &State,
    of: impl Fn(f64) -> f64,
) -> Option<f64> {
    let mut sum = 0.0;
    let mut start = 0;
    for (&end, point) in chunk.ends.iter().zip(&state.points[chunk.points.clone()]) {
        for sighting in &chunk.sightings[start..end as usize] {
            let image = sighting.image as usize;
            let camera = chunk.cameras[chunk.camera_of[image] as usize] as usize;
            let pose = &state.poses[chunk.images[image] as usize];
            let residual = problem.lenses[camera].kernel.residual;
            let [x, y] = residual(&state.params[camera], pose, point, &sighting.xy)?;
            sum += of(x * x + y * y);
        }
        start = end as usize;
    }
    Some(sum)
}

impl least_squares::Problem for Solver<'_> {
    type State = State;

    fn cost(&mut self, state: &State) -> Option<f64> {
        let Self { problem, options, costs, .. } = self;
        let chunks = problem.chunks.par_iter().zip(costs.par_iter_mut());
        chunks.for_each(|(chunk, sum)| *sum = cost(chunk, problem, options.loss, state));
        let sum = costs.iter().copied().sum::<Option<f64>>()?;
        Some(sum + problem.limits.cost(state)).filter(|cost| cost.is_finite())
    }

    fn linearize(&mut self, state: &State) {
        self.at.clone_from(state);
        self.system.left = None;
        // Half the variance of one residual: no unknown is further than about its standard deviation from the end.
        let cost: f64 = self.costs.iter().flatten().sum();
        let is_near = self.predicted <= cost / self.freedom.max(1.0);
        self.bends = is_near && self.options.loss.bends_down();
    }

    fn solve(&mut self, damping: f64) -> Option<Step> {
        self.resting.clear();
        let (by_points, point_gradient, solved) = loop {
            let (by_points, point_gradient, open_points) = self.eliminate(damping);
            self.open_points = open_points;
            let Some(solved) = self.system.solve(damping) else {
                // The loss's own curvature may leave no minimum to step to; its weights always do.
                if !std::mem::take(&mut self.bends) {
                    return None;
                }
                continue;
            };
            let Problem { limits, layout, .. } = self.problem;
            match limits.share(&self.at, layout, &self.system.step) {
                Ok(share) => {
                    self.share = share;
                    break (by_points, point_gradient, solved);
                }
                Err(resting) => self.resting.push(resting),
            }
        };
        let points = self.follow(damping);
        let weighed = solved.weighed_square + points.weighed_square;
        self.predicted = 0.5 * (damping * weighed + solved.descent + by_points);
        Some(Step {
            predicted: self.predicted,
            gradient: solved.gradient.max(point_gradient * self.problem.frame.scale),
            length: (solved.square + points.square).sqrt(),
        })
    }

    fn step(&self, state: &State, moved: &mut State) {
        for ((to, from), step) in moved.poses.iter_mut().zip(&state.poses).zip(&self.pose_steps) {
            *to = from.moved(step.map(|part| self.share * part));
        }
        moved.params.clone_from(&state.params);
        for ((params, step), lens) in
            moved.params.iter_mut().zip(&self.param_steps).zip(&self.problem.lenses)
        {
            for (&place, step) in lens.free.iter().zip(step) {
                params[place] += self.share * step;
            }
        }
        self.problem.limits.put_inside(moved, &self.resting);
        if self.options.mode.moves_points() {
            let steps = moved.points.iter_mut().zip(&state.points).zip(&self.point_steps);
            for ((to, from), step) in steps {
                *to = from + step * self.share;
            }
        }
    }

    fn length(&self, state: &State) -> f64 {
        let points: f64 = state.points.iter().map(Vector3::norm_squared).sum();
        let poses: f64 = state.poses.iter().map(|pose| 1.0 + pose.translation.norm_squared()).sum();
        let params: f64 = state.params.iter().flatten().map(|value| value * value).sum();
        (points + poses + params).sqrt()
    }

    fn freedom(&self) -> f64 {
        self.freedom
    }

    fn tried(&mut self, trial: &least_squares::Trial) {
        (self.watch)(trial);
    }
}
