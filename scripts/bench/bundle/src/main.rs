//! Times bundle adjustment alone: `bench-bundle MODEL [THREADS]` reads the model, adjusts all intrinsics, and prints JSON.
//!
//! `whole`: CPU seconds of `adjust`, from scene to refined scene with covariance. `solve`: the same less `adjust` without steps,
//! which builds the problem, eliminates once for the covariance and writes back: what the steps alone take.

use calibstab::bundle::{self, Options, Refine, Which};
use calibstab::camera::ParamClass::{Extra, Focal, PrincipalPoint};
use calibstab::colmap;
use calibstab::scene::Scene;
use rustix::time::{ClockId, clock_gettime};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let model = arguments.next().expect("bench-bundle MODEL [THREADS]");
    let threads =
        arguments.next().map_or(1, |threads| threads.parse().expect("THREADS is a number"));
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .expect("no pool was built before");
    let scene = colmap::find_one(model.as_ref()).expect("a model").read().expect("a sound model");
    let others = [Focal, PrincipalPoint, Extra].map(Which::Class).to_vec();
    let options = Options { refine: Refine { others, ..Refine::default() }, ..Options::default() };
    let mut without_steps = options.clone();
    without_steps.stop.max_iterations = 0;
    let read = peak_kb();
    let (around, around_wall, _) = timed(&scene, &without_steps);
    let (whole, wall, outcome) = timed(&scene, &options);
    println!(
        "{{\"whole\": {whole}, \"solve\": {}, \"wall\": {}, \"steps\": {}, \"cost\": {:e}, \"read_kb\": {read}, \"peak_kb\": {}}}",
        whole - around,
        wall - around_wall,
        outcome.iterations,
        outcome.cost,
        peak_kb()
    );
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
