//! Times bundle adjustment alone, without files: reads a model, adjusts all intrinsics, and prints JSON. `against_pycolmap.py` says
//! what the numbers are compared with.
//!
//! bench-bundle adjust MODEL THREADS STEPS: at most so many steps.
//!   `whole`: CPU seconds of `adjust`, from scene to refined scene with covariance. `solve`: the same less `adjust` without steps,
//!   which builds the problem, eliminates once for the covariance and writes back: what the steps alone take.
//! bench-bundle covariance MODEL THREADS: `solve` is what `adjust` at the optimum takes more than the adjustment by `Subsets` of all
//!   images, which has the same steps and neither covariance nor writing back: the mean of some.
//! bench-bundle subsets MODEL THREADS FILE: `solve` is the adjustment of the images of each line, by id, from the optimum of the
//!   whole; building the problem, once, included. `costs`: those of the first ones.

use std::collections::BTreeSet;

use calibstab::bundle::{self, Options, Refine, Subsets, Which};
use calibstab::camera::ParamClass::{Extra, Focal, PrincipalPoint};
use calibstab::colmap;
use calibstab::scene::{ImageId, Scene};
use rayon::prelude::*;
use rustix::time::{ClockId, clock_gettime};

/// One alone is lost in what both sides have in common.
const COVARIANCES: u32 = 20;

const USAGE: &str =
    "bench-bundle adjust|covariance|subsets MODEL THREADS [STEPS or FILE OF SUBSETS]";

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [what, model, threads, more @ ..] = arguments.as_slice() else { panic!("{USAGE}") };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.parse().expect(USAGE))
        .build_global()
        .expect("no pool was built before");
    let model: &std::path::Path = model.as_ref();
    let scene = colmap::find_one(model).expect("a model").read().expect("a sound model");
    let others = [Focal, PrincipalPoint, Extra].map(Which::Class).to_vec();
    let options = Options { refine: Refine { others, ..Refine::default() }, ..Options::default() };
    match (what.as_str(), more) {
        ("adjust", [steps]) => adjust(&scene, &options, steps.parse().expect(USAGE)),
        ("covariance", []) => covariance(scene, &options),
        ("subsets", [file]) => subsets(scene, &options, file),
        _ => panic!("{USAGE}"),
    }
}

fn without_steps(options: &Options) -> Options {
    let mut without = options.clone();
    without.stop.max_iterations = 0;
    without
}

fn adjust(scene: &Scene, options: &Options, steps: usize) {
    let read = peak_kb();
    let mut options = options.clone();
    options.stop.max_iterations = options.stop.max_iterations.min(steps);
    let (around, around_wall, _) = timed(scene, &without_steps(&options));
    let (whole, wall, outcome) = timed(scene, &options);
    println!(
        "{{\"whole\": {whole}, \"solve\": {}, \"wall\": {}, \"steps\": {}, \"cost\": {:e}, \"read_kb\": {read}, \"peak_kb\": {}}}",
        whole - around,
        wall - around_wall,
        outcome.iterations,
        outcome.cost,
        peak_kb()
    );
}

fn covariance(scene: Scene, options: &Options) {
    let refined = bundle::adjust(scene, options, &mut |_| {}).expect("an adjustment").scene;
    let all: BTreeSet<ImageId> =
        refined.geometry.as_ref().expect("images").images.keys().copied().collect();
    let (mut whole, mut without) = (0.0, 0.0);
    for _ in 0..COVARIANCES {
        whole += timed(&refined, options).0;
        let start = seconds(ClockId::ProcessCPUTime);
        let subsets = Subsets::new(&refined, options).expect("a problem");
        subsets.adjust(&all).expect("an adjustment");
        without += seconds(ClockId::ProcessCPUTime) - start;
    }
    println!("{{\"solve\": {}}}", (whole - without) / f64::from(COVARIANCES));
}

fn subsets(scene: Scene, options: &Options, file: &str) {
    let ids = |line: &str| -> BTreeSet<ImageId> {
        line.split(' ').map(|id| ImageId(id.parse().expect("an id"))).collect()
    };
    let chosen: Vec<BTreeSet<ImageId>> =
        std::fs::read_to_string(file).expect("a file").lines().map(ids).collect();
    let refined = bundle::adjust(scene, options, &mut |_| {}).expect("an adjustment").scene;
    let (cpu, wall) = (seconds(ClockId::ProcessCPUTime), seconds(ClockId::Monotonic));
    let subsets = Subsets::new(&refined, options).expect("a problem");
    let one = |images| subsets.adjust(images).map(|refit| (refit.cost, refit.iterations));
    let refits: Vec<(f64, usize)> =
        chosen.par_iter().map(one).collect::<Result<_, _>>().expect("adjustments");
    let (cpu, wall) = (seconds(ClockId::ProcessCPUTime) - cpu, seconds(ClockId::Monotonic) - wall);
    let costs: Vec<f64> = refits.iter().map(|(cost, _)| *cost).take(5).collect();
    let steps: usize = refits.iter().map(|(_, steps)| steps).sum();
    println!("{{\"solve\": {cpu}, \"wall\": {wall}, \"steps\": {steps}, \"costs\": {costs:?}}}");
}

/// CPU seconds, wall seconds, outcome.
fn timed(scene: &Scene, options: &Options) -> (f64, f64, bundle::Outcome) {
    let scene = scene.clone();
    let (cpu, wall) = (seconds(ClockId::ProcessCPUTime), seconds(ClockId::Monotonic));
    let adjusted = bundle::adjust(scene, options, &mut |_| {}).expect("an adjustment");
    (seconds(ClockId::ProcessCPUTime) - cpu, seconds(ClockId::Monotonic) - wall, adjusted.outcome)
}

fn seconds(clock: ClockId) -> f64 {
    let time = clock_gettime(clock);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// The most memory that this process ever held.
fn peak_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("a line on the peak");
    line.trim().trim_end_matches(" kB").parse().expect("a number of kB")
}
