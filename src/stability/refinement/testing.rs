//! Refined runs for the tests of this room.

use super::super::spread::Region;
use super::super::testing::{run, with_images};
use super::super::{Analysis, Options, RefinementOptions, Run, analyze};
use crate::bundle::{CameraOutcome, Covariance, Dropped, FreeParam, OpenDirection, Outcome};
use crate::camera::Model;
use crate::least_squares::Reason;
use crate::scene::{Camera, CameraId};

/// A run, with an image that no other has, of one SIMPLE_RADIAL camera that COLMAP left at f = 1000, and its refinement to these values, f and k free.
pub(in crate::stability) fn refined(
    name: &str,
    [f, k]: [f64; 2],
    covariance: Option<Covariance>,
) -> Run {
    let left = [1000.0, 640.0, 480.0, 0.01];
    let run = with_images(run("g", name, &[(1, "SIMPLE_RADIAL", &left)]), &[(1, &["1.jpg", name])]);
    let before = run.scene.cameras[&CameraId(1)];
    let intrinsics = Model::named("SIMPLE_RADIAL").unwrap().with_params(&[f, 640.0, 480.0, k]);
    let after = Camera { intrinsics: intrinsics.unwrap(), ..before };
    let camera = CameraOutcome {
        at_bound: Vec::new(),
        id: CameraId(1),
        before,
        after,
        free: vec![0, 3],
        images: 1,
        implausible: None,
    };
    let outcome = Outcome {
        reason: Reason::Converged,
        initial_cost: 2.0,
        cost: 1.0,
        iterations: 3,
        images: 1,
        points: 9,
        observations: 9,
        dropped: Dropped::default(),
        components: 1,
        unknowns: 10,
        rank: 10,
        sigma_px: Some(0.5),
        cameras: vec![camera],
        covariance,
        rigs_dissolved: false,
    };
    Run { refinement: Some(Ok(outcome)), ..run }
}

/// The covariance of f and k.
pub(in crate::stability) fn covariance(
    matrix: Option<[[f64; 2]; 2]>,
    open: &[(usize, f64)],
) -> Option<Covariance> {
    let param = |place, name| FreeParam { camera: CameraId(1), place, name };
    let open = match open {
        [] => vec![],
        changes => vec![OpenDirection { changes: changes.to_vec() }],
    };
    let matrix = matrix.map(|rows| rows.map(|row| row.to_vec()).to_vec());
    Some(Covariance { params: vec![param(0, "f"), param(3, "k")], matrix, clustered: vec![], open })
}

/// What they amount to, over the whole image.
pub(in crate::stability) fn analysis(runs: Vec<Run>) -> Analysis {
    let refinement = RefinementOptions {
        mode: "self-calibration".to_owned(),
        refine: vec!["focal".to_owned(), "extra".to_owned()],
        priors: Vec::new(),
        bounds: Vec::new(),
        loss: "squared".to_owned(),
        stop: "decrement".to_owned(),
    };
    analyze(
        runs,
        vec![],
        Options { refinement: Some(refinement), region: Some(Region::All), ..Options::default() },
    )
    .unwrap()
}
