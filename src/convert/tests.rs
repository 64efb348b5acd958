//! Every model to every model.

use super::*;
use crate::camera::{MODELS, examples};

/// Which models contain which, as their formulas say: whatever its parameters, the first is one of each of the others.
const CONTAINED: [(&str, &str); 14] = [
    (
        "SIMPLE_PINHOLE",
        "PINHOLE SIMPLE_RADIAL RADIAL OPENCV FULL_OPENCV RADTAN FOV SIMPLE_DIVISION DIVISION UCM EUCM DOUBLE_SPHERE",
    ),
    ("PINHOLE", "OPENCV FULL_OPENCV RADTAN FOV DIVISION UCM EUCM DOUBLE_SPHERE"),
    ("SIMPLE_RADIAL", "RADIAL OPENCV RADTAN FULL_OPENCV"),
    ("RADIAL", "OPENCV RADTAN FULL_OPENCV"),
    ("OPENCV", "RADTAN FULL_OPENCV"),
    ("RADTAN", "FULL_OPENCV"),
    // FOV divides the angle by omega = 2 atan(1/2), and is equidistant there.
    (
        "SIMPLE_FISHEYE",
        "FISHEYE SIMPLE_RADIAL_FISHEYE RADIAL_FISHEYE OPENCV_FISHEYE THIN_PRISM_FISHEYE RAD_TAN_THIN_PRISM_FISHEYE \
         FTHETA FOV",
    ),
    ("FISHEYE", "OPENCV_FISHEYE THIN_PRISM_FISHEYE RAD_TAN_THIN_PRISM_FISHEYE FOV"),
    // F-Theta has k3 = f k.
    (
        "SIMPLE_RADIAL_FISHEYE",
        "RADIAL_FISHEYE OPENCV_FISHEYE THIN_PRISM_FISHEYE RAD_TAN_THIN_PRISM_FISHEYE FTHETA",
    ),
    ("RADIAL_FISHEYE", "OPENCV_FISHEYE THIN_PRISM_FISHEYE RAD_TAN_THIN_PRISM_FISHEYE"),
    ("OPENCV_FISHEYE", "THIN_PRISM_FISHEYE RAD_TAN_THIN_PRISM_FISHEYE"),
    ("SIMPLE_DIVISION", "DIVISION"),
    ("UCM", "EUCM DOUBLE_SPHERE"),
    ("BAL_STRICT", "BAL_PINHOLE"),
];

fn camera(name: &str, params: &[f64]) -> Intrinsics {
    Model::named(name).unwrap().with_params(params).unwrap()
}

/// An image around the camera's principal point, as far as that is in its middle.
fn size_of(camera: &Intrinsics) -> [u32; 2] {
    let centre = camera.project(&camera.optical_axis()).unwrap();
    [centre.x, centre.y].map(|middle| {
        (120..2000).rev().find(|side| f64::from(*side) <= 2.0 * middle).unwrap_or(480)
    })
}

fn is_contained(from: &str, to: &str) -> bool {
    let targets = CONTAINED.iter().find(|(name, _)| *name == from).map_or("", |found| found.1);
    from == to || targets.split_whitespace().any(|target| target == to)
}

#[test]
fn a_conversion_is_exact_for_all_cameras_where_the_model_contains_theirs_and_for_no_other_pair() {
    let (mut exact, mut other) = (0, 0);
    for from in MODELS {
        for to in MODELS {
            let mut cameras =
                examples().into_iter().filter(|camera| camera.model().name == from.name);
            let is_exact = |camera: Intrinsics| {
                let done = convert(&camera, size_of(&camera), to, Folds::LeftOut);
                done.is_ok_and(|done| done.how == How::Exact)
            };
            let names = format!("{} to {}", from.name, to.name);
            assert_eq!(cameras.all(is_exact), is_contained(from.name, to.name), "{names}");
            if is_contained(from.name, to.name) { exact += 1 } else { other += 1 }
        }
    }
    assert_eq!((exact, exact + other), (24 + 56, 24 * 24));
}

#[test]
fn what_is_carried_over_keeps_its_bits_and_what_does_nothing_is_dropped() {
    let mut checked = 0;
    for (from, params, to, want) in [
        (
            "SIMPLE_RADIAL",
            vec![500.1, 320.2, 240.3, -0.1],
            "RADTAN",
            vec![500.1, 500.1, 320.2, 240.3, -0.1, 0.0, 0.0, 0.0, 0.0],
        ),
        (
            "OPENCV",
            vec![500.1, 500.1, 320.2, 240.3, -0.1, 0.0, 0.0, 0.0],
            "SIMPLE_RADIAL",
            vec![500.1, 320.2, 240.3, -0.1],
        ),
        (
            "RADIAL_FISHEYE",
            vec![500.1, 320.2, 240.3, -0.01, 0.002],
            "OPENCV_FISHEYE",
            vec![500.1, 500.1, 320.2, 240.3, -0.01, 0.002, 0.0, 0.0],
        ),
        (
            "UCM",
            vec![500.1, 490.1, 320.2, 240.3, 0.6],
            "EUCM",
            vec![500.1, 490.1, 320.2, 240.3, 0.6, 1.0],
        ),
        (
            "EUCM",
            vec![500.1, 490.1, 320.2, 240.3, 0.6, 1.0],
            "DOUBLE_SPHERE",
            vec![500.1, 490.1, 320.2, 240.3, 0.0, 0.6],
        ),
        ("SIMPLE_PINHOLE", vec![500.1, 320.2, 240.3], "FOV", vec![500.1, 500.1, 320.2, 240.3, 0.0]),
        (
            "BAL_PINHOLE",
            vec![500.1, 500.1, 0.0, 0.0, -0.1, 0.02],
            "BAL_STRICT",
            vec![500.1, -0.1, 0.02],
        ),
        ("EQUIRECTANGULAR", vec![2000.0, 1000.0], "EQUIRECTANGULAR", vec![2000.0, 1000.0]),
    ] {
        let target = Model::named(to).unwrap();
        let done = convert(&camera(from, &params), [640, 480], target, Folds::Refused).unwrap();
        assert_eq!((done.how, done.intrinsics.params()), (How::Exact, want.as_slice()), "{from}");
        checked += 1;
    }
    assert_eq!(checked, 8);
}

#[test]
fn one_lens_in_other_words_is_found() {
    // r = 400 (theta - 0.05 theta^3): F-Theta without its even powers.
    let theta = camera("FTHETA", &[320.0, 240.0, 400.0, 0.0, -20.0, 0.0]);
    // The division model back is (u, v, 1 + k r^2), EUCM with alpha 1/2 is (u, v, 1 - beta r^2 / 4).
    let division = camera("DIVISION", &[500.0, 490.0, 320.0, 240.0, -0.2]);
    for (source, to, want) in [
        (theta, "SIMPLE_RADIAL_FISHEYE", vec![400.0, 320.0, 240.0, -0.05]),
        (division, "EUCM", vec![500.0, 490.0, 320.0, 240.0, 0.5, 0.8]),
    ] {
        let target = Model::named(to).unwrap();
        let done = convert(&source, [640, 480], target, Folds::Refused).unwrap();
        assert_eq!(done.how, How::Exact, "{done:?}");
        for (found, want) in done.intrinsics.params().iter().zip(&want) {
            assert!((found - want).abs() < 1e-9 * want.abs(), "{done:?}");
        }
    }
}

#[test]
fn a_fit_states_its_region_and_comes_back() {
    let source = camera("OPENCV", &[465.7, 465.0, 376.0, 240.0, -0.275, 0.067, 0.0014, -0.00044]);
    let target = Model::named("OPENCV_FISHEYE").unwrap();
    let done = convert(&source, [752, 480], target, Folds::Refused).unwrap();
    let How::Fitted(fit) = done.how else { panic!("{done:?}") };
    assert!((fit.seen_share - 1.0).abs() < 1e-12 && fit.rms_px < fit.max_px, "{fit:?}");
    let corner = source.unproject(&Vector2::new(752.0 / 120.0, 240.0 / 38.0)).unwrap();
    assert!((fit.largest_angle - corner.angle(&nalgebra::Vector3::z())).abs() < 0.02, "{fit:?}");
    // The errors, counted here once more.
    let error = |pixel: Vector2<f64>| {
        (done.intrinsics.project(&source.unproject(&pixel).unwrap()).unwrap() - pixel).norm()
    };
    let errors: Vec<f64> = Grid::new(752, 480).pixels().map(error).collect();
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    assert!((rms - fit.rms_px).abs() < 1e-12, "{fit:?}");
}

#[test]
fn what_would_mean_nothing_is_refused_with_its_reason() {
    let thesis = camera("SIMPLE_RADIAL", &[1011.91, 640.0, 480.0, -0.241569]);
    let wide = camera(
        "OPENCV_FISHEYE",
        &[428.331, 444.79, 512.0, 512.0, 0.00974985, 0.0337692, -0.0801194, 0.0217839],
    );
    let pinhole = camera("PINHOLE", &[500.0, 490.0, 320.0, 240.0]);
    let map = camera("EQUIRECTANGULAR", &[2000.0, 1000.0]);
    let upside_down = camera("PINHOLE", &[500.0, -490.0, 320.0, 240.0]);
    let elsewhere = camera("FOV", &[500.0, 490.0, 99999.0, 240.0, 0.9]);
    let mut checked = 0;
    for (source, size, to, reason) in [
        (
            thesis,
            [1280, 960],
            "EUCM",
            "SIMPLE_RADIAL folds inside the image: 0.0195 % of its pixels have no ray",
        ),
        (
            wide,
            [1024, 1024],
            "OPENCV",
            "the image reaches 99.5° from the optical axis, OPENCV sees less than 90°",
        ),
        (wide, [1024, 1024], "UCM", "the nearest UCM folds inside the image"),
        (
            pinhole,
            [640, 480],
            "BAL_STRICT",
            "PINHOLE and BAL_STRICT look in opposite directions along Z",
        ),
        (
            pinhole,
            [640, 480],
            "EQUIRECTANGULAR",
            "EQUIRECTANGULAR is a map of all directions, not a lens",
        ),
        (map, [2000, 1000], "FISHEYE", "EQUIRECTANGULAR is a map of all directions, not a lens"),
        (upside_down, [640, 480], "FISHEYE", "focal length"),
        (elsewhere, [640, 480], "OPENCV", "sees next to nothing in the image"),
    ] {
        let target = Model::named(to).unwrap();
        let error = convert(&source, size, target, Folds::Refused).unwrap_err().to_string();
        assert!(error.contains(reason), "{to}: {error}");
        checked += 1;
    }
    assert_eq!(checked, 8);
    // On request the rest is fitted.
    let done =
        convert(&thesis, [1280, 960], Model::named("DIVISION").unwrap(), Folds::LeftOut).unwrap();
    assert!(matches!(done.how, How::Fitted(_)), "{done:?}");
}
