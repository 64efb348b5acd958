//! What adjustments predict of the spread, beside what many repeats of synthetic rooms show; and what no ratio can see.
//!
//! `CALIBSTAB_GROUPS` groups of four runs; 400 in `scripts/verify`.

// Helpers of tests, which the allowance for tests in clippy.toml does not reach.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stderr)]

use calibstab::bundle::{self, Options, Refine, Which};
use calibstab::camera::{Model, ParamClass};
use calibstab::scene::{Camera, CameraId, Keypoint, Keypoints, Scene};
use calibstab::stability::spread::Region;
use calibstab::stability::{
    self, FindingId, HeldClass, Inside, Mean, Population, ResidualsInRun, Run,
};
use calibstab::synth;
use statrs::distribution::{ChiSquared, ContinuousCDF};

const GROUP: u32 = 4;

fn group_count() -> u32 {
    match std::env::var("CALIBSTAB_GROUPS") {
        Ok(count) => count.parse().expect("CALIBSTAB_GROUPS is a number"),
        Err(_) => 40,
    }
}

/// A room in which f, distortion and all else are well determined, with the noise of this run.
fn room(seed: u64, run: u32) -> Scene {
    noisy_room(seed, run, 0.5)
}

fn noisy_room(seed: u64, run: u32, noise_px: f64) -> Scene {
    let model = Model::named("OPENCV").unwrap();
    let lens = [600.0, 598.0, 320.0, 240.0, -0.2, 0.06, 5e-4, -3e-4];
    let intrinsics = model.with_params(&lens).unwrap();
    let options = synth::Options {
        cameras: vec![Camera { intrinsics, width: 640, height: 480 }],
        image_count: 14,
        point_count: 300,
        most_per_image: 90,
        noise_px,
        start_off: 0.0,
        seed,
        run,
        own_views: false,
        ..synth::Options::default()
    };
    synth::make(&options).unwrap().run
}

/// The run, adjusted, with its covariance multiplied by what a fault makes of it.
fn refined(name: u32, scene: Scene, fault: fn(&bundle::Outcome) -> f64) -> Run {
    refined_with(&Options::default(), name, scene, fault)
}

fn refined_with(
    options: &Options,
    name: u32,
    scene: Scene,
    fault: fn(&bundle::Outcome) -> f64,
) -> Run {
    let adjusted = bundle::adjust_to_optimum(scene.clone(), options, &mut |_| ());
    let (mut adjusted, optimum) = adjusted.unwrap();
    let inside = Inside::of(&adjusted.outcome, &optimum, None);
    let factor = fault(&adjusted.outcome);
    let covariance = adjusted.outcome.covariance.as_mut().unwrap();
    let values = covariance.matrix.as_mut().unwrap().iter_mut().flatten();
    values.for_each(|value| *value *= factor);
    Run {
        group: String::new(),
        name: format!("run{name:04}"),
        files: vec![],
        remarks: vec![],
        scene,
        refinement: Some(Ok(adjusted.outcome)),
        inside,
    }
}

fn population(runs: Vec<Run>) -> Population {
    // Over the middle of the image, which is quicker; what is predicted is over the same cells.
    let options =
        stability::Options { region: Some(Region::Center(0.4)), ..stability::Options::default() };
    let analysis = stability::analyze(runs, vec![], options).unwrap();
    assert_eq!(analysis.populations.len(), 1);
    analysis.populations.into_iter().next().unwrap()
}

fn no_fault(_: &bundle::Outcome) -> f64 {
    1.0
}

/// Groups of four runs of one room.
fn groups(count: u32, fault: fn(&bundle::Outcome) -> f64) -> Vec<Population> {
    groups_with(&Options::default(), count, fault)
}

fn groups_with(
    options: &Options,
    count: u32,
    fault: fn(&bundle::Outcome) -> f64,
) -> Vec<Population> {
    let group = |group: u32| {
        let runs = group * GROUP..(group + 1) * GROUP;
        population(runs.map(|run| refined_with(options, run, room(1, run), fault)).collect())
    };
    (0..count).map(group).collect()
}

/// Observed squares over predicted ones of all groups, and the 99.99 % interval of that ratio: chi-square weighted by the squares
/// of the directions, with the degrees of its first two moments.
fn ratio(groups: &[Population], observed: fn(&Population) -> f64) -> (f64, [f64; 2]) {
    let predicted =
        |one: &Population| one.prediction.as_ref().unwrap().spread.as_ref().unwrap().rms_px.powi(2);
    let sum: f64 = groups.iter().map(|one| observed(one).powi(2)).sum();
    let ratio = sum / groups.iter().map(predicted).sum::<f64>();
    let directions = &groups[0].prediction.as_ref().unwrap().directions;
    let squares: Vec<f64> = directions.iter().map(|one| one.moves_px.powi(2)).collect();
    let square_sum: f64 = squares.iter().sum();
    let concentration = square_sum.powi(2) / squares.iter().map(|s| s * s).sum::<f64>();
    let degrees = f64::from(GROUP - 1) * groups.len() as f64 * concentration;
    let law = ChiSquared::new(degrees).unwrap();
    (ratio, [5e-5, 1.0 - 5e-5].map(|p| law.inverse_cdf(p) / degrees))
}

fn turned(one: &Population) -> f64 {
    one.spread.as_ref().unwrap().rotated.rms_px
}

/// The unevenness of the p-values of T.
fn unevenness(groups: &[Population]) -> f64 {
    let p = |one: &Population| one.prediction.as_ref()?.consistency.as_ref().map(|c| c.found.p);
    distance_from_even(groups.iter().map(|one| p(one).unwrap()).collect())
}

/// The p-values that the runs of all groups give to what they hold of this class.
fn held_p(groups: &[Population], class: HeldClass) -> Vec<f64> {
    let tests = groups.iter().flat_map(|one| &one.held).filter(|test| test.class == class);
    tests.flat_map(|test| &test.runs).map(|run| run.test.p).collect()
}

/// Kolmogorov and Smirnov's distance of p-values from even ones, as a multiple of what 1 in 1000 exceeds.
fn distance_from_even(mut p: Vec<f64>) -> f64 {
    p.sort_by(f64::total_cmp);
    let n = p.len() as f64;
    let steps = p.iter().enumerate();
    let distance = steps
        .map(|(at, p)| (p - at as f64 / n).abs().max(((at + 1) as f64 / n - p).abs()))
        .fold(0.0, f64::max);
    distance * n.sqrt() / (-(0.001_f64 / 2.0).ln() / 2.0).sqrt()
}

fn is_inside(ratio: f64, [low, high]: [f64; 2]) -> bool {
    low < ratio && ratio < high
}

#[test]
fn independent_noise_spreads_as_predicted_and_planted_faults_are_found_out() {
    let count = group_count();
    let sound = groups(count, no_fault);
    let (found, interval) = ratio(&sound, turned);
    let uneven = unevenness(&sound);
    eprintln!(
        "{count} groups: observed / predicted {found:.4} in {interval:.4?}, unevenness {uneven:.2}"
    );
    assert!(is_inside(found, interval), "{found} {interval:?}");
    assert!(count < 400 || (found - 1.0).abs() < 0.05, "{found}");
    assert!(uneven < 1.0, "{uneven}");
    for class in [HeldClass::PrincipalPoint, HeldClass::NextRadial] {
        let p = held_p(&sound, class);
        assert_eq!(p.len(), (GROUP * count) as usize);
        let uneven = distance_from_even(p);
        eprintln!("{class:?}: unevenness {uneven:.2}");
        assert!(uneven < 1.0, "{class:?} {uneven}");
    }
    assert_no_pattern(&sound);

    // Sigma for unit noise.
    let without_sigma = groups(10, |outcome| outcome.sigma_px.unwrap().powi(-2));
    let (found, interval) = ratio(&without_sigma, turned);
    assert!(!is_inside(found, interval) && unevenness(&without_sigma) > 1.0, "{found}");
    // Degrees of freedom without those that the points take.
    let without_points = groups(count.min(60), |outcome| {
        let residuals = 2.0 * outcome.observations as f64;
        let rank = outcome.rank as f64;
        (residuals - rank) / (residuals - rank + 3.0 * outcome.points as f64)
    });
    let (found, interval) = ratio(&without_points, turned);
    assert!(!is_inside(found, interval) && unevenness(&without_points) > 1.0, "{found}");
    // The rotation that poses absorb left in: it is large where the principal point is free.
    let all = Refine {
        others: [ParamClass::Focal, ParamClass::PrincipalPoint, ParamClass::Extra]
            .map(Which::Class)
            .to_vec(),
        ..Refine::default()
    };
    let options = Options { refine: all, ..Options::default() };
    let free = groups_with(&options, 10, no_fault);
    let (found, interval) = ratio(&free, turned);
    assert!(is_inside(found, interval), "{found} {interval:?}");
    let (found, interval) = ratio(&free, |one| one.spread.as_ref().unwrap().raw.rms_px);
    assert!(!is_inside(found, interval), "{found} {interval:?}");
}

/// Of groups whose lenses are right: residuals have no pattern, and no points stand out.
fn assert_no_pattern(sound: &[Population]) {
    let runs = sound.iter().flat_map(|one| &one.residuals.as_ref().unwrap().runs);
    let runs: Vec<&ResidualsInRun> = runs.map(|run| &run.residuals).collect();
    assert_eq!(runs.len(), GROUP as usize * sound.len());
    let uneven = distance_from_even(runs.iter().map(|run| run.p).collect());
    let mean = |of: &dyn Fn(&ResidualsInRun) -> f64| {
        runs.iter().map(|run| of(run)).sum::<f64>() / runs.len() as f64
    };
    let [sigma, effect] = [mean(&|run| run.sigma_px), mean(&|run| run.effect_px)];
    let [ratio, beyond] =
        [mean(&|run| run.tails.unwrap().sigma_ratio), mean(&|run| run.tails.unwrap().beyond_share)];
    eprintln!(
        "pattern: unevenness {uneven:.2}, sigma {sigma:.4} px, effect {effect:.4} px; sigma ratio {ratio:.4}, beyond {beyond:.5}"
    );
    assert!(uneven < 1.0, "{uneven}");
    assert!((sigma - 0.5).abs() < 0.01, "{sigma}");
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    assert!((beyond - 1e-3).abs() < 5e-4, "{beyond}");
    for one in sound {
        assert!(!is_found(one, FindingId::ResidualPattern), "{:?}", one.verdict);
        assert!(!has_tails(one), "{:?}", one.residuals.as_ref().unwrap().tails);
        // Of a mean the noise is what its standard error says.
        let map = &one.residuals.as_ref().unwrap().map;
        assert_eq!(map.n, GROUP as usize);
    }
    let cells = sound.iter().flat_map(|one| &one.residuals.as_ref().unwrap().map.cells);
    let rings = sound.iter().flat_map(|one| &one.residuals.as_ref().unwrap().map.rings);
    for means in [cells.map(|cell| cell.mean).collect::<Vec<_>>(), rings.map(|r| r.mean).collect()]
    {
        let off =
            |mean: &Mean| [0, 1].map(|axis| (mean.px[axis] / mean.std_error_px[axis]).powi(2));
        let squares: Vec<f64> = means.iter().flat_map(off).collect();
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        eprintln!("{} means: squares in their standard errors {mean:.3}", means.len());
        // Means of a run hang together; five times the deviation of independent ones.
        let wide = 5.0 * (2.0 / squares.len() as f64).sqrt();
        assert!((mean - 1.0).abs() < wide, "{mean} {wide}");
    }
}

/// Whether points that do not fit were found.
fn has_tails(one: &Population) -> bool {
    let tails = one.residuals.as_ref().unwrap().tails.unwrap();
    tails.p < 1e-3 && tails.sigma_ratio > 1.4
}

#[test]
fn two_cameras_of_unlike_noise_make_no_pattern_that_is_a_finding() {
    let runs = (2 * group_count()).min(200);
    let two = |run: u32, noise_px: f64| {
        let lens = |model: &str, lens: &[f64]| {
            let intrinsics = Model::named(model).unwrap().with_params(lens).unwrap();
            Camera { intrinsics, width: 640, height: 480 }
        };
        let options = synth::Options {
            cameras: vec![
                lens("OPENCV", &[600.0, 598.0, 320.0, 240.0, -0.2, 0.06, 5e-4, -3e-4]),
                lens("SIMPLE_RADIAL", &[500.0, 320.0, 240.0, -0.1]),
            ],
            image_count: 16,
            point_count: 300,
            most_per_image: 90,
            noise_px,
            start_off: 0.0,
            run,
            own_views: false,
            ..synth::Options::default()
        };
        synth::make(&options).unwrap().run
    };
    let mut p: Vec<Vec<f64>> = vec![Vec::new(); 2];
    let mut sigma = [0.0; 2];
    for run in 0..runs {
        let noisy = two(run, 0.75);
        let keypoints: Vec<Vec<[f64; 2]>> = noisy
            .geometry
            .iter()
            .flat_map(|geometry| geometry.images.values())
            .map(|image| image.keypoints.iter().map(|keypoint| keypoint.xy).collect())
            .collect();
        let mut scene = two(run, 0.5);
        with_keypoints(
            &mut scene,
            |image, at, own| {
                if image % 2 == 1 { keypoints[image][at] } else { own }
            },
        );
        let inside = refined(run, scene, no_fault).inside.unwrap();
        assert_eq!(inside.residuals.len(), 2);
        for (camera, residuals) in inside.residuals.iter().enumerate() {
            p[camera].push(residuals.p);
            sigma[camera] += residuals.sigma_px / f64::from(runs);
        }
    }
    // Points carry some noise from camera to camera, which makes p of the quieter one too small, by a factor of two or so:
    // nothing beside the thousandth that a finding needs.
    for p in &p {
        let share = |limit: f64| p.iter().filter(|p| **p < limit).count() as f64 / p.len() as f64;
        assert!(share(0.05) < 0.2 && share(1e-3) < 0.02, "{} {}", share(0.05), share(1e-3));
    }
    // Less than a third of the difference is carried over.
    let most = (0.75 - 0.5) / 3.0;
    assert!((sigma[0] - 0.5).abs() < most && (sigma[1] - 0.75).abs() < most, "{sigma:?}");
}

/// Moves the keypoints of some images, by the number of the image and of the keypoint.
fn with_keypoints(scene: &mut Scene, place: impl Fn(usize, usize, [f64; 2]) -> [f64; 2]) {
    let images = scene.geometry.as_mut().unwrap().images.values_mut();
    for (number, image) in images.enumerate() {
        let mut moved = Keypoints::default();
        for (at, keypoint) in image.keypoints.iter().enumerate() {
            moved.push(Keypoint { xy: place(number, at, keypoint.xy), ..keypoint });
        }
        image.keypoints = moved;
    }
}

#[test]
fn what_runs_share_is_corrected_for() {
    let shared = room(1, 1_000_000);
    let keypoints: Vec<Vec<[f64; 2]>> = shared
        .geometry
        .iter()
        .flat_map(|geometry| geometry.images.values())
        .map(|image| image.keypoints.iter().map(|keypoint| keypoint.xy).collect())
        .collect();
    // Every second image is the same in all runs of a group.
    let group =
        |group: u32| {
            let runs =
                (group * GROUP..(group + 1) * GROUP).map(|run| {
                    let mut scene = room(1, run);
                    with_keypoints(&mut scene, |image, at, own| {
                        if image % 2 == 0 { keypoints[image][at] } else { own }
                    });
                    refined(run, scene, no_fault)
                });
            population(runs.collect())
        };
    let found: Vec<Population> = (0..group_count().min(100)).map(group).collect();
    let overlap = found[0].overlap.as_ref().unwrap();
    assert!((overlap.shared_fraction - 0.5).abs() < 0.05, "{overlap:?}");
    let corrected = |one: &Population| one.overlap.as_ref().unwrap().independent_rms_px.unwrap();
    let (as_found, _) = ratio(&found, turned);
    // What is shared carries half of the information, about: images are not all worth the same.
    let (ratio, interval) = ratio(&found, corrected);
    eprintln!("as found {as_found:.3}, corrected {ratio:.3} in {interval:.3?}");
    assert!(is_inside(ratio, [0.9 * interval[0], 1.1 * interval[1]]), "{ratio} {interval:?}");
    assert!(as_found < 0.75, "{as_found}");
}

/// The Birge ratio of the runs of a camera.
fn birge(one: &Population) -> f64 {
    one.prediction.as_ref().unwrap().consistency.as_ref().unwrap().found.birge
}

/// Whether the verdict on the camera has this finding.
fn is_found(one: &Population, id: FindingId) -> bool {
    one.verdict.reasons.iter().any(|reason| reason.id == id)
}

/// Whether the ratio says nothing.
fn is_silent(birge: f64) -> bool {
    0.6 < birge && birge < 1.15
}

fn replace_camera(scene: &mut Scene, model: &str, params: &[f64]) {
    let intrinsics = Model::named(model).unwrap().with_params(params).unwrap();
    scene.cameras.get_mut(&CameraId(1)).unwrap().intrinsics = intrinsics;
}

#[test]
fn what_is_wrong_in_all_runs_alike_does_not_show_in_the_ratio() {
    let runs = 0..group_count().min(60);
    let of = |runs: &mut dyn Iterator<Item = Run>| population(runs.collect());
    let held_off = of(&mut runs.clone().map(|run| {
        let mut scene = room(1, run);
        let lens = [600.0, 598.0, 350.0, 240.0, -0.2, 0.06, 5e-4, -3e-4];
        replace_camera(&mut scene, "OPENCV", &lens);
        refined(run, scene, no_fault)
    }));
    let outliers = of(&mut runs.clone().map(|run| {
        let mut scene = room(1, run);
        // One keypoint of 25 is off by 5 px, in a direction that differs.
        let seed = 7919 * (run as usize + 1);
        with_keypoints(&mut scene, |image, at, [x, y]| {
            let hash = (image * 613 + at * 31 + seed) % 25;
            let turn = ((image * 13 + at * 7 + seed) % 360) as f64;
            let off = if hash == 0 { 5.0 } else { 0.0 };
            [x + off * turn.cos(), y + off * turn.sin()]
        });
        refined(run, scene, no_fault)
    }));
    let wrong_order = of(&mut runs.clone().map(|run| {
        let mut scene = room(1, run);
        replace_camera(&mut scene, "SIMPLE_RADIAL", &[600.0, 320.0, 240.0, -0.15]);
        refined(run, scene, no_fault)
    }));
    for one in [&held_off, &outliers, &wrong_order] {
        assert!(is_silent(birge(one)), "{}", birge(one));
    }
    // What the runs hold speaks where their differences do not.
    let held =
        |one: &Population, class| one.held.iter().find(|test| test.class == class).unwrap().clone();
    let test = held(&held_off, HeldClass::PrincipalPoint);
    assert!(is_found(&held_off, FindingId::HeldParameter), "{:?}", held_off.verdict);
    assert!((test.parameters[2].after - 320.0).abs() < 2.0, "{:?}", test.parameters);
    let test = held(&wrong_order, HeldClass::NextRadial);
    assert!(test.p < 1e-3, "{test:?}");
    let residuals = wrong_order.residuals.as_ref().unwrap();
    eprintln!(
        "wrong order: {:?} px; pattern {:.3} px, p {:.0e}",
        test.effect_px, residuals.effect_px, residuals.p
    );
    assert!(is_found(&wrong_order, FindingId::ResidualPattern), "{:?}", wrong_order.verdict);
    // Inward or outward by rings above all: SIMPLE_RADIAL has no tangential terms and one focal length, which shows less.
    let of_axis = |axis: usize| {
        let rings = residuals.map.rings.iter();
        rings
            .map(|ring| (ring.mean.px[axis] / ring.mean.std_error_px[axis]).abs())
            .fold(0.0, f64::max)
    };
    assert!(of_axis(0) > 10.0 && of_axis(0) > 2.0 * of_axis(1), "{} {}", of_axis(0), of_axis(1));
    let tails = outliers.residuals.as_ref().unwrap().tails.unwrap();
    eprintln!("outliers: {tails:?}");
    assert!(has_tails(&outliers), "{tails:?}");
    assert!((tails.robust_sigma_px - 0.5).abs() < 0.1, "{tails:?}");
    assert!(!is_found(&outliers, FindingId::ResidualPattern), "{:?}", outliers.verdict);
    let other_scenes = of(&mut runs.map(|run| {
        let mut scene = noisy_room(u64::from(run) + 1, run, 0.15);
        replace_camera(&mut scene, "SIMPLE_RADIAL", &[600.0, 320.0, 240.0, -0.15]);
        refined(run, scene, no_fault)
    }));
    assert!(birge(&other_scenes) > 1.5, "{}", birge(&other_scenes));
}
