//! Every camera model without noise: the truth is found to rounding, and what no view could tell is said.

use calibstab::camera::{MODELS, Model, ParamClass};
use calibstab::least_squares::{self, Stop};
use calibstab::scene::{Camera, Scene};
use calibstab::synth::{self, Synthetic};
use nalgebra::Vector2;

use super::{adjust, all_free, excess, largest};

/// Images around a room, rolled by quarter turns, that determine each model: how often the focal length of synth's lens its camera has
/// (that lens sees 40 degrees off its axis in the corners, or 115), and how far off the start is.
const VIEWS: [(&str, f64, f64); 24] = [
    ("SIMPLE_PINHOLE", 1.0, 0.01),
    ("PINHOLE", 1.0, 0.01),
    ("SIMPLE_RADIAL", 1.0, 0.01),
    ("RADIAL", 1.0, 0.01),
    ("OPENCV", 1.0, 0.01),
    ("OPENCV_FISHEYE", 1.0, 0.01),
    // Six radial terms are told apart by a wide view only.
    ("FULL_OPENCV", 0.6, 0.01),
    ("FOV", 1.0, 0.01),
    ("SIMPLE_RADIAL_FISHEYE", 1.0, 0.01),
    ("RADIAL_FISHEYE", 1.0, 0.01),
    ("THIN_PRISM_FISHEYE", 1.0, 0.01),
    ("RAD_TAN_THIN_PRISM_FISHEYE", 1.0, 0.01),
    ("SIMPLE_DIVISION", 1.0, 0.01),
    ("DIVISION", 1.0, 0.01),
    ("SIMPLE_FISHEYE", 1.0, 0.01),
    ("FISHEYE", 1.0, 0.01),
    ("EUCM", 1.0, 0.01),
    // It has no free parameter: poses and points alone are found.
    ("EQUIRECTANGULAR", 1.0, 0.01),
    ("RADTAN", 1.0, 0.01),
    ("UCM", 1.0, 0.01),
    ("DOUBLE_SPHERE", 1.0, 0.01),
    ("FTHETA", 1.0, 0.01),
    ("BAL_PINHOLE", 1.0, 0.01),
    ("BAL_STRICT", 1.0, 0.01),
];

fn exact(camera: Camera, point_count: u32, start_off: f64) -> Synthetic {
    let options = synth::Options {
        cameras: vec![camera],
        image_count: 16,
        point_count,
        most_per_image: 120.max(point_count / 40),
        noise_px: 0.0,
        start_off,
        ..synth::Options::default()
    };
    synth::make(&options).unwrap()
}

/// synth's lens with another focal length.
fn camera(name: &str, share: f64) -> Camera {
    let model = Model::named(name).unwrap();
    let camera = synth::camera(model, 640, 480).unwrap();
    let values = camera.intrinsics.params().iter().zip(model.params);
    let scaled = values.map(|(value, param)| {
        let is_length = param.class == ParamClass::Focal;
        if is_length { value * share } else { *value }
    });
    let intrinsics = model.with_params(&scaled.collect::<Vec<_>>()).unwrap();
    Camera { intrinsics, ..camera }
}

/// How far the pixels that were observed move from one calibration to another, in px, at most.
fn displacement(truth: &Scene, found: &Scene) -> f64 {
    let mut compared = 0;
    let mut largest: f64 = 0.0;
    for image in truth.geometry.as_ref().unwrap().images.values() {
        let [of_truth, of_found] =
            [truth, found].map(|scene| scene.cameras[&image.camera].intrinsics);
        for keypoint in image.keypoints.iter() {
            let ray = of_truth.unproject(&Vector2::from(keypoint.xy)).unwrap();
            let moved = of_found.project(&ray).unwrap() - of_truth.project(&ray).unwrap();
            largest = largest.max(moved.norm());
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared}");
    largest
}

#[test]
fn without_noise_the_truth_of_every_model_is_found_to_rounding() {
    assert_eq!(
        VIEWS.map(|(name, ..)| name).to_vec(),
        MODELS.iter().map(|m| m.name).collect::<Vec<_>>()
    );
    let mut options = all_free();
    // Nothing but rounding stops it.
    options.stop = least_squares::Options { stop: Stop::Decrement(0.0), max_iterations: 100 };
    let mut checked = 0;
    for (name, share, start_off) in VIEWS {
        let Synthetic { truth, run, .. } = exact(camera(name, share), 900, start_off);
        let adjusted = adjust(&run, &options);
        let outcome = &adjusted.outcome;
        assert!(outcome.initial_cost > 1000.0 && outcome.cost < 1e-20, "{name}: {outcome:?}");
        assert_eq!(outcome.rank, outcome.unknowns, "{name}: {:?}", outcome.covariance);
        let px = displacement(&truth, &adjusted.scene);
        assert!(px <= 1e-7, "{name}: {px:.1e} px");
        let free = outcome.cameras[0].free.len();
        let described = |param: &&calibstab::camera::Param| param.class != ParamClass::Metadata;
        assert_eq!(free, Model::named(name).unwrap().params.iter().filter(described).count());
        if free == 0 {
            assert_eq!((name, &outcome.covariance), ("EQUIRECTANGULAR", &None));
            continue;
        }
        let covariance = outcome.covariance.as_ref().unwrap();
        // At a noise of 1 px.
        let sigma = outcome.sigma_px.unwrap();
        let stds = covariance.stds().unwrap().into_iter().map(|std| std / sigma);
        let off = excess(&adjusted.scene, &truth, covariance);
        let off = largest(off.into_iter().zip(stds).map(|(off, std)| off / std));
        assert!(off <= 1e-5, "{name}: {off:.1e} std");
        checked += free;
    }
    assert_eq!(checked, 143);
}

#[test]
fn the_lens_that_synth_has_for_a_model_is_plausible() {
    for (name, ..) in VIEWS {
        assert_eq!(camera(name, 1.0).implausible(), None, "{name}");
    }
}

/// What is said not to be determined.
fn open(camera: Camera, point_count: u32) -> String {
    let Synthetic { truth, .. } = exact(camera, point_count, 0.0);
    let adjusted = adjust(&truth, &all_free());
    let px = displacement(&truth, &adjusted.scene);
    assert!(px <= 1e-7, "{px:.1e} px");
    let covariance = adjusted.outcome.covariance.unwrap();
    assert!(covariance.matrix.is_none());
    assert!(adjusted.outcome.rank < adjusted.outcome.unknowns);
    let words: Vec<String> = covariance.open.iter().map(|open| covariance.words(open)).collect();
    words.join("; ")
}

fn with(name: &str, params: &[f64]) -> Camera {
    Camera {
        intrinsics: Model::named(name).unwrap().with_params(params).unwrap(),
        width: 640,
        height: 480,
    }
}

#[test]
fn what_no_view_can_tell_is_said_not_to_be_determined() {
    // Without alpha beta is nowhere in the formula; the pixel is even in omega; six radial terms in a narrow view are too many.
    assert_eq!(open(with("EUCM", &[500.0, 490.0, 320.0, 240.0, 0.0, 1.0]), 900), "beta +1");
    assert_eq!(open(with("FOV", &[500.0, 490.0, 320.0, 240.0, 0.0]), 900), "omega +1");
    let terms = [-0.3, 0.12, 0.001, -0.002, -0.02, 0.01, -0.01, 0.002];
    let narrow = with("FULL_OPENCV", &[&[3000.0, 2990.0, 320.0, 240.0], &terms[..]].concat());
    let words = open(narrow, 40_000);
    assert!(words.contains("k1") && words.contains("k4") && !words.contains("p1"), "{words}");
}
