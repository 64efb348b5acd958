//! scratch
use calibstab::{bundle, colmap};
use calibstab::bundle::*;
use calibstab::camera::ParamClass;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let scene = colmap::read(std::path::Path::new(&args[1])).unwrap();
    let mut options = Options::default();
    if args.len() > 2 { options.refine.others.push(Which::Class(ParamClass::PrincipalPoint)); }
    let t = std::time::Instant::now();
    let adjusted = bundle::adjust(scene, &options, &mut |t| {
        println!("{} cost {:.9e} fall {:?} predicted {:.3e} grad {:.3e} len {:.3e} damping {:.1e} gain {:.3}", t.iteration, t.cost, t.fall, t.step.map_or(0.0, |s| s.predicted), t.step.map_or(0.0, |s| s.gradient),t.step.map_or(0.0, |s| s.length), t.damping, t.fall.unwrap_or(f64::NAN)/t.step.map_or(0.0, |s| s.predicted));
    }).unwrap();
    println!("{:?} {:?}", t.elapsed(), (adjusted.outcome.reason, adjusted.outcome.iterations, adjusted.outcome.cost, adjusted.outcome.unknowns, adjusted.outcome.rank, adjusted.outcome.sigma_px, adjusted.outcome.dropped));
    println!("{:?}", adjusted.outcome.covariance.as_ref().map(|c| (c.stds(), c.open.clone())));
    for c in adjusted.scene.cameras.values() { println!("{:?}", c.intrinsics); }
}
