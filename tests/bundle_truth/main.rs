//! Bundle adjustment against scenes of known truth, through the library's public face.

// Helpers of tests, which the allowance for tests in clippy.toml does not reach.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod hard;
mod limits;
mod models;
mod noise;
mod numbering;
mod robust;

use calibstab::bundle::{self, Adjusted, Covariance, FreeParam, Options, Refine, Which};
use calibstab::camera::ParamClass;
use calibstab::scene::Scene;

/// All intrinsics free.
fn all_free() -> Options {
    let classes = [ParamClass::Focal, ParamClass::PrincipalPoint, ParamClass::Extra];
    let others = classes.map(Which::Class).to_vec();
    Options { refine: Refine { others, ..Refine::default() }, ..Options::default() }
}

fn adjust(start: &Scene, options: &Options) -> Adjusted {
    bundle::adjust(start.clone(), options, &mut |_| {}).unwrap()
}

/// The value of a free parameter.
fn value(scene: &Scene, param: &FreeParam) -> f64 {
    scene.cameras[&param.camera].intrinsics.params()[param.place]
}

/// By how much the free parameters of a scene exceed those of another.
fn excess(of: &Scene, over: &Scene, covariance: &Covariance) -> Vec<f64> {
    covariance.params.iter().map(|param| value(of, param) - value(over, param)).collect()
}

/// The largest of these.
fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    // A comparison with what is not a number would pass it over.
    values.into_iter().fold(0.0, |largest: f64, value| {
        assert!(value.is_finite());
        largest.max(value.abs())
    })
}
