//! What information must obey, and what every heuristic promises.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, Isometry3, Vector3};

use super::*;
use crate::bundle::testing::{World, camera};
use crate::bundle::{Options, Refine, adjust};
use crate::scene::{ImageId, Scene};
use crate::synth::{Purpose, Random};

const LENS: [f64; 4] = [1000.0, 640.0, 480.0, -0.05];

/// Images of one camera, or of cameras in turn, 0.5 px of noise.
pub(super) fn scene(cameras: usize, images: u32, points: usize) -> Scene {
    World::ring(vec![camera("SIMPLE_RADIAL", &LENS); cameras], images, points)
        .with_noise(0.5)
        .scene()
}

pub(super) fn candidates(scene: &Scene) -> Candidates {
    Candidates::new(scene, Refine::all(), 0.5).unwrap()
}

/// Every place once, in an order of chance.
fn some(count: usize, of: usize, seed: u64) -> Vec<usize> {
    let mut places = Random::new(seed, 0, Purpose::Selection).order(of);
    places.truncate(count);
    places.sort_unstable();
    places
}

/// The images alone with what they see.
fn alone(scene: &Scene, images: &[usize]) -> Scene {
    let ids: Vec<ImageId> = scene.geometry.as_ref().unwrap().images.keys().copied().collect();
    scene.with_images(&images.iter().map(|&place| ids[place]).collect())
}

fn off(found: &DMatrix<f64>, wanted: &DMatrix<f64>) -> f64 {
    let entry = |(row, column): (usize, usize)| {
        let scale = (wanted[(row, row)] * wanted[(column, column)]).sqrt();
        (found[(row, column)] - wanted[(row, column)]).abs() / scale
    };
    let size = wanted.nrows();
    (0..size * size).map(|at| entry((at / size, at % size))).fold(0.0, f64::max)
}

#[test]
fn a_subset_tells_what_its_own_adjustment_tells() {
    let mut count = 0;
    for (cameras, seed) in [(1, 1), (1, 2), (2, 3)] {
        let scene = scene(cameras, 14, 60);
        let subset = some(8, 14, seed);
        // At its optimum, so that both are linearised at one place.
        let adjusted = adjust(
            alone(&scene, &subset),
            &Options { refine: Refine::all(), ..Options::default() },
            &mut |_| {},
        )
        .unwrap();
        let covariance = adjusted.outcome.covariance.unwrap();
        let rows = covariance.matrix.unwrap();
        let size = rows.len();
        let wanted = DMatrix::from_fn(size, size, |row, column| rows[row][column]);
        let sigma_px = adjusted.outcome.sigma_px.unwrap();
        let candidates = Candidates::new(&adjusted.scene, Refine::all(), sigma_px).unwrap();
        let information = candidates.information(&(0..8).collect::<Vec<_>>());
        let found = information.covariance(&(0..size).collect::<Vec<_>>()).unwrap();
        assert!(off(&found, &wanted) < 1e-8, "{:e}", off(&found, &wanted));
        count += 1;
    }
    assert_eq!(count, 3);
}

#[test]
fn images_that_go_and_come_leave_the_sums_that_are_made_anew() {
    let candidates = candidates(&scene(1, 14, 60));
    let mut count = 0;
    for seed in 0..20 {
        let order = Random::new(seed, 0, Purpose::Selection).order(14);
        let (inside, outside) = order.split_at(8);
        let system = assembly::System::with_room(&candidates, inside, 1);
        for into in [&outside[..1], &[]] {
            let found = system.exchanged(&inside[..1], into).information().matrix;
            let wanted = candidates.information(&[&inside[1..], into].concat()).matrix;
            assert!(off(&found, &wanted) < 1e-9, "seed {seed}: {:e}", off(&found, &wanted));
            count += 1;
        }
    }
    assert_eq!(count, 40);
}

#[test]
fn one_image_tells_nothing_and_another_never_takes_away() {
    let candidates = candidates(&scene(1, 12, 60));
    for image in 0..12 {
        let marginal = candidates.information(&[image]).matrix;
        let held = candidates.own_information(image);
        assert!(marginal.norm() < 1e-10 * held.norm());
        assert!(held.symmetric_eigenvalues().min() > 0.0);
    }
    let mut count = 0;
    for seed in 0..30 {
        let order = Random::new(seed, 0, Purpose::Selection).order(12);
        let size = 2 + usize::try_from(seed).unwrap() % 9;
        let fewer = candidates.information(&order[..size]).matrix;
        let more = candidates.information(&order[..=size]).matrix;
        // In the scale of each parameter, so that units do not hide a loss.
        let scale = |at: usize| 1.0 / more[(at, at)].sqrt();
        let gain = DMatrix::from_fn(4, 4, |row, column| {
            (more[(row, column)] - fewer[(row, column)]) * scale(row) * scale(column)
        });
        let least = gain.symmetric_eigenvalues().min();
        assert!(least > -1e-10, "seed {seed}: {least:e}");
        count += usize::from(gain.norm() > 1e-3);
    }
    assert!(count > 25, "only {count} images told something");
}

#[test]
fn points_seen_by_one_chosen_image_count_for_nothing() {
    let scene = scene(1, 14, 60);
    let subset = some(6, 14, 5);
    let found = candidates(&scene).information(&subset).matrix;
    // The frame of the adjustment differs, as it centres on the points that are left.
    let wanted = candidates(&alone(&scene, &subset)).information(&[0, 1, 2, 3, 4, 5]).matrix;
    assert!(off(&found, &wanted) < 1e-9, "{:e}", off(&found, &wanted));
}

#[test]
fn every_heuristic_keeps_its_promises() {
    let scene = scene(3, 24, 60);
    let candidates = candidates(&scene);
    let pool = some(19, 24, 9);
    let mut count = 0;
    for heuristic in HEURISTICS {
        for (size, camera) in [(3, None), (8, None), (4, Some(CameraId(2)))] {
            let request = Request { pool: &pool, size, seed: 4, unit: Unit::Image, camera };
            let choices = heuristic.choose(&candidates, &request).unwrap();
            let name = heuristic.name;
            let mut images: Vec<usize> = choices.iter().flat_map(|it| it.images.clone()).collect();
            images.sort_unstable();
            images.dedup();
            assert_eq!(images.len(), size, "{name}");
            assert!(images.iter().all(|image| pool.contains(image)), "{name}");
            let seen: BTreeSet<_> = images.iter().map(|&image| candidates.camera(image)).collect();
            let wanted: BTreeSet<_> = match camera {
                Some(camera) => [camera].into(),
                None => [1, 2, 3].map(CameraId).into(),
            };
            assert_eq!(seen, wanted, "{name}");
            assert!(choices.iter().all(|choice| !choice.reason.is_empty()), "{name}");
            assert_eq!(heuristic.choose(&candidates, &request).unwrap(), choices, "{name}");
            count += 1;
        }
    }
    assert_eq!(count, 3 * HEURISTICS.len());
    let names: BTreeSet<_> = HEURISTICS.iter().map(|heuristic| heuristic.name).collect();
    assert_eq!(names.len(), 11);
    assert!(Heuristic::named(RECOMMENDED).is_some());
}

#[test]
fn what_cannot_be_chosen_is_refused_with_its_reason() {
    let scene = scene(2, 12, 60);
    let candidates = candidates(&scene);
    let pool: Vec<usize> = (0..12).collect();
    let base = Request { pool: &pool, size: 4, seed: 0, unit: Unit::Image, camera: None };
    let refused = |request: Request<'_>| {
        let errors: Vec<SelectionError> = HEURISTICS
            .iter()
            .map(|heuristic| heuristic.choose(&candidates, &request).unwrap_err())
            .collect();
        assert!(errors.iter().all(|error| *error == errors[0]), "{errors:?}");
        errors[0].clone()
    };
    assert_eq!(refused(Request { size: 1, ..base }), SelectionError::TooFew);
    let many = SelectionError::TooMany { size: 13, pool: 12, connected: 12 };
    assert_eq!(refused(Request { size: 13, ..base }), many);
    let camera = Some(CameraId(7));
    assert_eq!(refused(Request { camera, ..base }), SelectionError::NoCamera(CameraId(7)));
}

/// How many of those that a heuristic chooses are planted.
fn planted(
    heuristic: &str,
    candidates: &Candidates,
    (size, seed): (usize, u64),
    is_planted: impl Fn(usize) -> bool,
) -> usize {
    let pool: Vec<usize> = (0..candidates.image_count()).collect();
    let request = Request { pool: &pool, size, seed, unit: Unit::Image, camera: None };
    let choices = Heuristic::named(heuristic).unwrap().choose(candidates, &request).unwrap();
    choices.iter().flat_map(|it| it.images.iter()).filter(|&&image| is_planted(image)).count()
}

/// The same of random choice, the mean over many seeds.
fn planted_by_chance(
    candidates: &Candidates,
    size: usize,
    is_planted: impl Fn(usize) -> bool,
) -> f64 {
    let counts = (0..50).map(|seed| planted("random", candidates, (size, seed), &is_planted));
    counts.sum::<usize>() as f64 / 50.0
}

#[test]
fn a_car_that_stands_is_passed_over() {
    let mut world = World::ring(vec![camera("SIMPLE_RADIAL", &LENS)], 24, 60).with_noise(0.5);
    let standing = world.poses[0];
    world.poses[12..].fill(standing);
    let candidates = candidates(&world.scene());
    let stands = |image: usize| image == 0 || image >= 12;
    let standing: Vec<usize> = (0..24).filter(|&image| stands(image)).collect();
    assert!(candidates.information(&standing).covariance(&[0, 1, 2, 3]).is_none());
    for heuristic in ["mapping-error", "growing-error", "d-optimal", "directions", "baseline"] {
        let count = planted(heuristic, &candidates, (6, 0), stands);
        assert!(count <= 1, "{heuristic} takes {count} of a car that stands");
    }
    assert!(planted_by_chance(&candidates, 6, stands) > 2.5);
}

#[test]
fn the_few_images_that_see_corners_are_found() {
    const CORNERS: [usize; 4] = [3, 9, 14, 20];
    let mut world = World::ring(vec![camera("SIMPLE_RADIAL", &LENS)], 24, 80).with_noise(0.5);
    // All see a small cloud in the middle, but these a part of it in a corner.
    world.points.iter_mut().for_each(|point| *point *= 0.4);
    for (&image, (x, y)) in CORNERS.iter().zip([(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
    {
        let turn = Isometry3::rotation(Vector3::new(0.25 * x, 0.35 * y, 0.0));
        world.poses[image] = turn * world.poses[image];
    }
    let candidates = candidates(&world.scene());
    let is_corner = |image: usize| CORNERS.contains(&image);
    // What is built up one by one may pass over one whose worth shows with others only.
    let least = [("mapping-error", 4), ("d-optimal", 4), ("coverage", 4), ("growing-error", 3)];
    for (heuristic, least) in least {
        let count = planted(heuristic, &candidates, (8, 0), is_corner);
        assert!(count >= least, "{heuristic}: {count}");
    }
    assert!(planted_by_chance(&candidates, 8, is_corner) < 2.0);
}
