//! Reads one model again and again, and prints what a read costs: `read_model MODEL READS`.
//!
//! Linux only: seconds and memory come from /proc. `RAYON_NUM_THREADS` says how many threads read.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::Instant;

#[allow(clippy::print_stdout)] // its only purpose
fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, reads] = &arguments[..] else { return Err("usage: read_model MODEL READS".into()) };
    let reads: u32 = reads.parse()?;
    let files = calibstab::colmap::find_one(Path::new(model))?;
    // The threads that will read exist before anything is measured.
    rayon::broadcast(|_| ());

    let kib_before = kib("VmRSS:")?;
    let scene = files.read()?;
    let kib_added = kib("VmHWM:")?.saturating_sub(kib_before);
    drop(scene);

    let (cpu_before, clock) = (cpu_seconds()?, Instant::now());
    for _ in 0..reads {
        files.read()?;
    }
    let cpu = (cpu_seconds()? - cpu_before) / f64::from(reads);
    let wall = clock.elapsed().as_secs_f64() / f64::from(reads);
    println!("cpu_s {cpu:.5} wall_s {wall:.5} added_kib {kib_added}");
    Ok(())
}

/// A line of /proc/self/status.
fn kib(name: &str) -> Result<u64, Box<dyn Error>> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix(name)).ok_or("no such line")?;
    Ok(line.trim().trim_end_matches(" kB").parse()?)
}

/// What all threads of this process have run so far.
fn cpu_seconds() -> Result<f64, Box<dyn Error>> {
    let mut nanoseconds = 0.0;
    for task in fs::read_dir("/proc/self/task")? {
        let stat = fs::read_to_string(task?.path().join("schedstat"))?;
        let first = stat.split_whitespace().next().ok_or("an empty schedstat")?;
        nanoseconds += first.parse::<f64>()?;
    }
    Ok(nanoseconds * 1e-9)
}
