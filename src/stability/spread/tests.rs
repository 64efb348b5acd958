//! Closed forms, the thesis, and what must not matter.

use nalgebra::{Rotation3, Vector3};

use super::consensus::{Consensus, Lenses, consensus};
use super::rays::deviations;
use super::*;
use crate::camera::Model;

fn camera_of(model: &str, params: &[f64], [width, height]: [u64; 2]) -> Camera {
    let intrinsics = Model::named(model).unwrap().with_params(params).unwrap();
    Camera { intrinsics, width, height }
}

fn calibration<'a>(run: &'a str, camera: &'a Camera) -> Calibration<'a> {
    Calibration { run, camera_id: 1, camera, is_flagged: false, view: None }
}

fn spread_of(cameras: &[Camera]) -> Spread {
    let all: Vec<Calibration> = cameras.iter().map(|camera| calibration("a", camera)).collect();
    spread(&all, None).unwrap()
}

const SIZE: [u64; 2] = [1280, 960];

fn thesis() -> [Camera; 3] {
    [
        [1104.37, 1029.92, 640.0, 480.0, -0.364639, 0.143539, 0.001229, 0.00258186],
        [1098.07, 1031.41, 640.0, 480.0, -0.359058, 0.148217, 0.001335, 0.00193668],
        [1013.00, 1041.81, 640.0, 480.0, -0.34398, 0.119602, -0.002218, -0.00528645],
    ]
    .map(|params| camera_of("OPENCV", &params, SIZE))
}

fn assert_px(found: f64, want: f64, tolerance: f64, what: &str) {
    assert!((found - want).abs() <= tolerance, "{what}: found {found}, want {want}");
}

#[test]
fn the_rows_of_the_thesis_spread_as_was_computed_twice_by_others() {
    let [one, two, three] = thesis();
    for (cameras, raw, rotated) in [
        (vec![one, two, three], 17.580, 17.410),
        (vec![one, three], 22.216, 21.969),
        (vec![one, two], 1.296, 1.266),
    ] {
        let found = spread_of(&cameras);
        assert_eq!(found.cells.len(), 2700);
        assert_px(found.raw.rms_px, raw, 0.005, "raw");
        assert_px(found.rotated.rms_px, rotated, 0.005, "rotated");
    }
}

#[test]
fn the_rows_of_the_thesis_differ_by_direction() {
    let [one, _, three] = thesis();
    let (one, three) = (calibration("1", &one), calibration("3", &three));
    for (from, to, raw, rotated) in [(&one, &three, 30.05, 29.79), (&three, &one, 33.14, 32.62)] {
        let found = difference(from, to, None).unwrap();
        assert_px(found.raw.rms_px, raw, 0.005, "raw");
        assert_px(found.rotated.rms_px, rotated, 0.005, "rotated");
    }
}

#[test]
fn equal_calibrations_have_no_spread() {
    let [one, ..] = thesis();
    let found = spread_of(&[one, one, one]);
    assert!(found.raw.max_px < 1e-9 && found.rotated.max_px < 1e-9, "{:?}", found.raw.max_px);
    assert!(found.rotated.max_deg < 1e-11 && found.runs.iter().all(|run| run.rotation_deg < 1e-11));
}

#[test]
fn a_shift_of_the_principal_point_of_a_narrow_lens_is_a_rotation() {
    let lens = |cx| camera_of("SIMPLE_PINHOLE", &[20_000.0, cx, 480.0], SIZE);
    let found = spread_of(&[lens(640.0), lens(650.0)]);
    // Two values 10 apart have a std of 10 / sqrt(2).
    assert_px(found.raw.rms_px, 10.0 / 2.0_f64.sqrt(), 1e-9, "raw");
    // What is left is of second order: 10 px times the square of the half image over f.
    assert!(
        found.rotated.rms_px < 10.0 * (640.0_f64 / 20_000.0).powi(2),
        "{}",
        found.rotated.rms_px
    );
    assert!(found.rotated.rms_px > 0.0);
    let turned: f64 = found.runs.iter().map(|run| run.rotation_deg).sum();
    assert_px(turned, (10.0_f64 / 20_000.0).to_degrees(), 1e-4, "turn");
}

#[test]
fn a_change_of_the_focal_length_alone_stays() {
    let lens = |f| camera_of("SIMPLE_PINHOLE", &[f, 640.0, 480.0], SIZE);
    let found = spread_of(&[lens(1000.0), lens(1010.0)]);
    assert_px(found.rotated.rms_px, found.raw.rms_px, 1e-9, "no turn helps");
    // Rays at radius r deviate by r (f1 - f2) / (f1 + f2) to first order, both ways: spread sqrt(2) times that.
    let square: f64 = Grid::new(1280, 960)
        .pixels()
        .map(|pixel| (pixel - Vector2::new(640.0, 480.0)).norm_squared())
        .sum();
    let want = 2.0_f64.sqrt() * 10.0 / 2010.0 * (square / 2700.0).sqrt();
    assert_px(found.raw.rms_px / want, 1.0, 1e-4, "first order");
}

#[test]
fn an_image_twice_as_large_has_twice_the_pixels_and_the_same_degrees() {
    let larger = thesis().map(|camera| {
        let mut params = camera.intrinsics.params().to_vec();
        params[..4].iter_mut().for_each(|value| *value *= 2.0);
        camera_of("OPENCV", &params, [2560, 1920])
    });
    let (small, large) = (spread_of(&thesis()), spread_of(&larger));
    for (small, large) in [(&small.raw, &large.raw), (&small.rotated, &large.rotated)] {
        for (small, large) in [
            (small.rms_px, large.rms_px / 2.0),
            (small.p95_px, large.p95_px / 2.0),
            (small.median_based_px, large.median_based_px / 2.0),
            (small.rms_deg, large.rms_deg),
            (small.max_deg, large.max_deg),
        ] {
            assert!((small / large - 1.0).abs() < 1e-9, "{small} {large}");
        }
    }
}

#[test]
fn neither_order_nor_names_change_a_bit() {
    let [one, two, three] = thesis();
    let bits = |cameras: [(&str, Camera); 3]| {
        let all: Vec<Calibration> = cameras.iter().map(|(run, c)| calibration(run, c)).collect();
        let found = spread(&all, None).unwrap();
        let mut maps: Vec<u64> = found.rotated.map_px.iter().map(|px| px.to_bits()).collect();
        maps.extend(found.raw.map_px.iter().map(|px| px.to_bits()));
        maps.extend([found.raw.rms_deg, found.rotated.max_deg].map(f64::to_bits));
        assert!(found.worst.px.len() > 200);
        maps.extend(found.worst.px.iter().flatten().map(|px| px.to_bits()));
        let mut runs: Vec<u64> = found.runs.iter().map(|run| run.rms_px.to_bits()).collect();
        runs.sort_unstable();
        (maps, runs, found.rotated.rms_px.to_bits())
    };
    let first = bits([("a", one), ("b", two), ("c", three)]);
    assert_eq!(first, bits([("z", three), ("y", one), ("x", two)]));
    assert_eq!(first, bits([("a", two), ("a", three), ("a", one)]));
}

#[test]
fn one_lens_in_another_models_words_is_the_same() {
    let values = [[1000.0, -0.1], [1003.0, -0.104], [998.0, -0.097]];
    let simple = values.map(|[f, k]| camera_of("SIMPLE_RADIAL", &[f, 640.0, 480.0, k], SIZE));
    let opencv =
        values.map(|[f, k]| camera_of("OPENCV", &[f, f, 640.0, 480.0, k, 0.0, 0.0, 0.0], SIZE));
    let (plain, other) = (spread_of(&simple), spread_of(&opencv));
    let mixed = spread_of(&[simple[0], opencv[1], simple[2]]);
    assert!(plain.rotated.rms_px > 0.1);
    // Lenses that are round about one centre cannot be turned to any use.
    assert!(plain.runs.iter().all(|run| run.rotation_deg < 1e-9), "{:?}", plain.runs);
    for other in [other, mixed] {
        for (a, b) in plain.rotated.map_px.iter().zip(&other.rotated.map_px) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        assert_px(other.raw.rms_px, plain.raw.rms_px, 1e-9, "raw");
    }
}

#[test]
fn images_of_two_sizes_are_refused() {
    let one = camera_of("SIMPLE_PINHOLE", &[500.0, 320.0, 240.0], [640, 480]);
    let other = camera_of("SIMPLE_PINHOLE", &[1000.0, 640.0, 480.0], SIZE);
    let error = spread(&[calibration("a", &one), calibration("b", &other)], None).unwrap_err();
    assert_eq!(error.to_string(), "image sizes differ: a of 640 x 480, b of 1280 x 960");
    assert!(difference(&calibration("a", &one), &calibration("b", &other), None).is_err());
    assert!(matches!(spread(&[calibration("a", &one)], None), Err(SpreadError::TooFew)));
}

#[test]
fn a_rotation_vector_keeps_its_digits_however_small_the_rotation() {
    for angle in [3.0, 0.1, 1e-6, 1e-12] {
        let wanted = Vector3::new(0.6, 0.0, -0.8) * angle;
        let found = super::consensus::rotation_vector(&Rotation3::from_scaled_axis(wanted));
        assert!((found - wanted).norm() < 1e-14 * angle.max(1e-3), "{found} {wanted}");
    }
}

/// Turns spread evenly over all directions, of about this angle.
fn restarts(count: usize, angle: f64) -> impl Iterator<Item = Rotation3<f64>> {
    (0..count).map(move |index| {
        let share = (index as f64 + 0.5) / count as f64;
        let (sin, cos) = (2.399_963_229_728_653 * index as f64).sin_cos();
        let height = 1.0 - 2.0 * share;
        let across = (1.0 - height * height).sqrt();
        Rotation3::from_scaled_axis(
            Vector3::new(across * cos, across * sin, height) * angle * share,
        )
    })
}

#[test]
fn no_other_start_leads_lower_and_alignment_never_raises_the_spread() {
    let wide = |f: f64, cx: f64, k1: f64| {
        camera_of("OPENCV_FISHEYE", &[f, f + 1.0, cx, 480.0, k1, -0.01, 0.002, 0.0], SIZE)
    };
    let fisheyes = [wide(500.0, 640.0, 0.02), wide(512.0, 655.0, 0.01), wide(490.0, 631.0, 0.04)];
    let mut tried = 0;
    for cameras in [thesis(), fisheyes] {
        let found = spread_of(&cameras);
        assert!(found.rotated.rms_px <= found.raw.rms_px);
        let intrinsics: Vec<&Intrinsics> =
            cameras.iter().map(|camera| &camera.intrinsics).collect();
        let grid = Grid::new(1280, 960);
        let pixels: Vec<Vector2<f64>> = found.cells.iter().map(|&cell| grid.pixel(cell)).collect();
        let lenses = Lenses { cameras: &intrinsics, pixels: &pixels, inverse_depths: &[0.0] };
        let turns: Vec<Rotation3<f64>> = restarts(12, 0.05).collect();
        for index in 0..turns.len() {
            let turn = |lens: usize| Placement {
                rotation: turns[(index + 5 * lens) % turns.len()],
                ..Placement::unmoved()
            };
            // Rays that all lenses see although they are turned: those of a narrower image.
            let rays = pixels
                .iter()
                .map(|pixel| {
                    let centre = Vector2::new(640.0, 480.0);
                    intrinsics[index % 3].unproject(&(centre + (pixel - centre) * 0.8)).unwrap()
                })
                .collect();
            let start = Consensus { rays, placements: (0..3).map(turn).collect() };
            let end = consensus::<3>(lenses, start).unwrap();
            let px = deviations(lenses, &end).unwrap().px;
            let square: f64 = px.iter().map(Vector2::norm_squared).sum();
            let rms = (square / 2.0 / pixels.len() as f64).sqrt();
            assert!(rms >= found.rotated.rms_px - 1e-7, "{rms} < {}", found.rotated.rms_px);
            tried += 1;
        }
    }
    assert_eq!(tried, 24);
}

#[test]
fn a_translation_helps_where_depths_tell_it_from_a_rotation() {
    let [one, two, three] = thesis();
    let view = |near: f64, far: f64| {
        let (observation_counts, observed_cells) = (vec![1; 2700], vec![true; 2700]);
        Some(View { observation_counts, observed_cells, distances: Some([near, 5.0, far]) })
    };
    let with =
        |run, camera, near, far| Calibration { view: view(near, far), ..calibration(run, camera) };
    let all =
        [with("a", &one, 2.5, 10.0), with("b", &two, 2.0, 10.0), with("c", &three, 2.5, 20.0)];
    let found = spread(&all, None).unwrap();
    assert_eq!(found.region, Region::Observed);
    assert_eq!(found.observation_counts, Some(vec![3; 2700]));
    let moved = found.moved.unwrap();
    // Binary fractions: these divisions are exact.
    assert_eq!(moved.depths.map(f64::to_bits), [0.5, 1.0, 2.0].map(f64::to_bits));
    assert!(moved.measure.rms_px < found.rotated.rms_px, "{}", moved.measure.rms_px);
    // Beyond all depths a translation does nothing.
    let far = Some([1e9, 1e9, 1e9]);
    let all = all
        .map(|one| Calibration { view: Some(View { distances: far, ..one.view.unwrap() }), ..one });
    assert!(spread(&all, None).unwrap().moved.unwrap().measure.rms_px <= found.rotated.rms_px);
}

#[test]
fn the_odd_run_is_named_with_its_place() {
    let [one, two, three] = thesis();
    let all = [calibration("1", &one), calibration("odd", &three), calibration("2", &two)];
    let found = spread(&all, None).unwrap();
    assert_eq!(found.worst.run, "odd");
    assert_eq!(
        found.runs.iter().map(|run| run.run.as_str()).collect::<Vec<_>>(),
        ["1", "odd", "2"]
    );
    assert!(found.runs[1].rms_px > 1.5 * found.runs[0].rms_px);
    let distances = found.distances_px.unwrap();
    assert!(distances[0][2] < 3.0 && distances[0][1] > 20.0 && distances[1][2] > 20.0);
    // 20 x 15 of 60 x 45 cells; the furthest off is at the border, and less far within.
    assert_eq!((found.worst.pitch, found.worst.cells.len(), found.worst.px.len()), (3, 300, 300));
    assert_eq!(found.worst.cells[..2], [61, 64]);
    let largest = found.worst.px.iter().map(|px| px[0].hypot(px[1])).fold(0.0, f64::max);
    let all = found.runs[1].max_px;
    assert!((0.8 * all..=all).contains(&largest), "{largest} {all}");
}
