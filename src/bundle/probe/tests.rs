//! The probe beside adjustments in which what it asks about is free.

use super::super::testing::{World, camera};
use super::super::{Options, Refine, Which, Widened, adjust, adjust_to_optimum};
use super::*;
use crate::camera::ParamClass::{self, Extra, Focal, PrincipalPoint};
use crate::scene::CameraId;

fn freeing(classes: &[ParamClass]) -> Options {
    let others = classes.iter().map(|class| Which::Class(*class)).collect();
    Options { refine: Refine { others, ..Refine::default() }, ..Options::default() }
}

fn assert_near(found: f64, expected: f64, scale: f64) {
    assert!((found - expected).abs() < 1e-3 * scale, "{found} {expected} {scale}");
}

/// Where cx and cy stand in OPENCV.
const CENTRE: [usize; 2] = [2, 3];

#[test]
fn a_probe_foretells_the_adjustment_in_which_its_columns_are_free() {
    let lens = camera("OPENCV", &[1000.0, 1010.0, 645.0, 472.0, -0.1, 0.03, 0.001, -0.0005]);
    // So little noise that one step of Newton's is as good as all.
    let scene = World::ring(vec![lens], 8, 60).with_noise(1e-4).scene();
    let held = adjust_to_optimum(scene.clone(), &freeing(&[Focal, Extra]), &mut |_| ());
    let (held, optimum) = held.unwrap();
    let of_centre = |_: &Observation, entries: &mut Vec<Entry>| {
        entries.extend([(0, [1.0, 0.0]), (1, [0.0, 1.0])]);
    };
    let probe = optimum.probe(2, &of_centre);
    let freed = adjust(scene, &freeing(&[Focal, PrincipalPoint, Extra]), &mut |_| ()).unwrap();
    let (before, after) = (held.outcome.cameras[0].after, freed.outcome.cameras[0].after);
    let moved = |at: usize| after.intrinsics.params()[at] - before.intrinsics.params()[at];
    let covariance = freed.outcome.covariance.unwrap();
    let variance = freed.outcome.sigma_px.unwrap().powi(2);
    let row = |place: usize| covariance.params.iter().position(|p| p.place == place).unwrap();
    let matrix = covariance.matrix.as_ref().unwrap();
    let std = |place: usize| matrix[row(place)][row(place)].sqrt();

    let inverse = probe.information.clone().try_inverse().unwrap();
    let step = -&inverse * &probe.score;
    for (one, place) in CENTRE.into_iter().enumerate() {
        assert_near(step[one], moved(place), std(place));
        for (other, second) in CENTRE.into_iter().enumerate() {
            let expected = matrix[row(place)][row(second)];
            assert_near(variance * inverse[(one, other)], expected, std(place) * std(second));
        }
    }
    let following = &probe.following * &step;
    for (at, param) in optimum.free().iter().enumerate() {
        assert_near(following[at], moved(param.place), std(param.place));
    }
    let gain = held.outcome.cost - freed.outcome.cost;
    assert_near(-0.5 * step.dot(&probe.score), gain, gain);
    // Nothing else imitates a share of what the columns do.
    assert!((0..2).all(|at| probe.information[(at, at)] < probe.own[at]));

    let widened =
        Widened { camera: CameraId(1), intrinsics: before.intrinsics, free: (0..8).collect() };
    let lenses = optimum.readjusted(&[widened]).unwrap().unwrap();
    for (place, value) in lenses[0].1.params().iter().enumerate() {
        assert!((value - after.intrinsics.params()[place]).abs() < 0.05 * std(place), "{place}");
    }
}
