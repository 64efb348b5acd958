//! Priors and bounds: as closed forms have them.

use calibstab::bundle::{Adjusted, Bound, Of, Options, Prior, Which};
use calibstab::least_squares::Reason;
use calibstab::scene::{CameraId, Scene};
use calibstab::synth::{self, Synthetic};
use nalgebra::{DMatrix, DVector};

use super::{adjust, all_free, excess, largest};

fn room() -> Synthetic {
    let options = synth::Options {
        image_count: 16,
        point_count: 600,
        most_per_image: 150,
        start_off: 0.01,
        ..synth::Options::default()
    };
    synth::make(&options).unwrap()
}

fn of(name: &str) -> Of {
    Of { camera: None, name: name.to_owned() }
}

fn param(adjusted: &Adjusted, name: &str) -> (f64, f64) {
    let covariance = adjusted.outcome.covariance.as_ref().unwrap();
    let at = covariance.params.iter().position(|param| param.name == name).unwrap();
    let value = super::value(&adjusted.scene, &covariance.params[at]);
    (value, covariance.stds().unwrap()[at])
}

fn matrix(adjusted: &Adjusted) -> DMatrix<f64> {
    let rows = adjusted.outcome.covariance.as_ref().unwrap().matrix.clone().unwrap();
    DMatrix::from_fn(rows.len(), rows.len(), |row, column| rows[row][column])
}

#[test]
fn priors_are_one_more_measurement_each() {
    let start = room().run;
    let plain = adjust(&start, &all_free());
    let [(fx, fx_std), (k1, k1_std)] = ["fx", "k1"].map(|name| param(&plain, name));
    let priors = vec![
        Prior { of: of("fx"), mean: fx + 0.5 * fx_std, std: 2.0 * fx_std },
        Prior { of: of("k1"), mean: k1 - 0.3 * k1_std, std: 1.5 * k1_std },
    ];
    let told = adjust(&start, &Options { priors, ..all_free() });
    assert_eq!(told.outcome.reason, Reason::Converged);

    // Linear about the plain optimum: (A + P) shift = P (mean - plain), A = sigma^2 / Sigma.
    let variance = plain.outcome.sigma_px.unwrap().powi(2);
    let information = matrix(&plain).try_inverse().unwrap() * variance;
    let mut precision = DMatrix::zeros(8, 8);
    let mut pull = DVector::zeros(8);
    for (at, std, off) in [(0, 2.0 * fx_std, 0.5 * fx_std), (4, 1.5 * k1_std, -0.3 * k1_std)] {
        precision[(at, at)] = 1.0 / (std * std);
        pull[at] = off / (std * std);
    }
    let inverse = (&information + &precision).try_inverse().unwrap();
    let shift = &inverse * pull;
    let covariance = plain.outcome.covariance.as_ref().unwrap();
    let found = excess(&told.scene, &plain.scene, covariance);
    let stds = covariance.stds().unwrap();
    assert!(largest(shift.iter().zip(&stds).map(|(shift, std)| shift / std)) > 0.1);
    let off =
        found.iter().zip(shift.iter()).zip(&stds).map(|((found, want), std)| (found - want) / std);
    let off = largest(off);
    assert!(off < 2e-3, "{off:.1e}");

    // Of an estimate with these weights, when pixels have the variance that they show and priors the one that they state.
    let want = &inverse * (information * variance + &precision) * &inverse;
    let got = matrix(&told);
    let mut compared = 0;
    for (row, column) in (0..8).flat_map(|row| (0..8).map(move |column| (row, column))) {
        let scale = (want[(row, row)] * want[(column, column)]).sqrt();
        let apart = (got[(row, column)] - want[(row, column)]) / scale;
        assert!(apart.abs() < 2e-3, "{row} {column}: {apart:.1e}");
        compared += 1;
    }
    assert_eq!(compared, 64);
    // The noise of the pixels is as large as without priors.
    let ratio = told.outcome.sigma_px.unwrap().powi(2) / variance;
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
}

#[test]
fn a_prior_alone_tells_what_views_leave_open() {
    let model = calibstab::camera::Model::named("EUCM").unwrap();
    // Without alpha beta is nowhere in the formula.
    let intrinsics = model.with_params(&[500.0, 490.0, 320.0, 240.0, 0.0, 1.0]).unwrap();
    let options = synth::Options {
        cameras: vec![calibstab::scene::Camera { intrinsics, width: 640, height: 480 }],
        image_count: 16,
        point_count: 900,
        noise_px: 0.0,
        start_off: 0.0,
        ..Default::default()
    };
    let start = synth::make(&options).unwrap().run;
    let outcome = adjust(&start, &all_free()).outcome;
    assert_eq!(outcome.rank + 1, outcome.unknowns);
    let priors = vec![Prior { of: of("beta"), mean: 1.2, std: 0.01 }];
    let told = adjust(&start, &Options { priors, ..all_free() });
    assert_eq!(told.outcome.rank, told.outcome.unknowns);
    let (beta, std) = param(&told, "beta");
    assert!((beta - 1.2).abs() < 1e-9 && (std / 0.01 - 1.0).abs() < 1e-6, "{beta} +- {std}");
}

/// The largest difference of the parameters of camera 1, in stds.
fn apart(one: &Scene, other: &Scene, of: &Adjusted) -> f64 {
    let covariance = of.outcome.covariance.as_ref().unwrap();
    let off = excess(one, other, covariance);
    largest(off.iter().zip(covariance.stds().unwrap()).map(|(off, std)| off / std))
}

#[test]
fn a_bound_that_is_in_the_way_holds_its_parameter_and_one_that_is_not_lets_go() {
    let start = room().run;
    let plain = adjust(&start, &all_free());
    let (k1, k1_std) = param(&plain, "k1");
    let (fy, fy_std) = param(&plain, "fy");
    let infinity = f64::INFINITY;
    // Two in the way, one from each side.
    let (least, most) = (k1 + 5.0 * k1_std, fy - 3.0 * fy_std);
    let bounds = vec![
        Bound { of: of("k1"), least, most: infinity },
        Bound { of: of("fy"), least: -infinity, most },
        Bound { of: of("fx"), least: 1.0, most: 1e5 },
    ];
    let bound = adjust(&start, &Options { bounds, ..all_free() });
    assert_eq!(bound.outcome.reason, Reason::Converged);
    let camera = &bound.outcome.cameras[0];
    assert_eq!((camera.at_bound.as_slice(), camera.free.len()), (&[1, 4][..], 6));
    assert!(bound.outcome.iterations < 30, "{}", bound.outcome.iterations);

    // The same with the two held there from the start.
    let mut held = start.clone();
    let camera = held.cameras.get_mut(&CameraId(1)).unwrap();
    let mut params = camera.intrinsics.params().to_vec();
    (params[1], params[4]) = (most, least);
    camera.intrinsics = camera.intrinsics.model().with_params(&params).unwrap();
    let mut options = all_free();
    options.refine.others =
        ["fx", "cx", "cy", "k2", "p1", "p2"].map(|name| Which::Named(name.to_owned())).to_vec();
    let held = adjust(&held, &options);
    assert!(
        apart(&held.scene, &bound.scene, &held) < 1e-5,
        "{:.1e}",
        apart(&held.scene, &bound.scene, &held)
    );
    let off = matrix(&held) - matrix(&bound);
    assert!(off.amax() < 1e-6 * matrix(&held).amax());
    assert_eq!(held.outcome.unknowns, bound.outcome.unknowns);

    // From a bound on the wrong side of where it belongs it is let go; the start, which is outside, is put inside.
    let bounds = vec![Bound { of: of("k1"), least: k1 - 50.0 * k1_std, most: k1 + 20.0 * k1_std }];
    for wrong in [k1 - 60.0 * k1_std, k1 + 60.0 * k1_std] {
        let mut start = start.clone();
        let camera = start.cameras.get_mut(&CameraId(1)).unwrap();
        let mut params = camera.intrinsics.params().to_vec();
        params[4] = wrong;
        camera.intrinsics = camera.intrinsics.model().with_params(&params).unwrap();
        let freed = adjust(&start, &Options { bounds: bounds.clone(), ..all_free() });
        assert!(freed.outcome.cameras[0].at_bound.is_empty());
        let apart = apart(&plain.scene, &freed.scene, &plain);
        assert!(apart < 1e-5, "{apart:.1e}");
    }
}

#[test]
fn a_limit_of_what_no_camera_has_is_refused() {
    let start = room().run;
    let refused = |options: Options| {
        calibstab::bundle::adjust(start.clone(), &options, &mut |_| {}).unwrap_err()
    };
    let bounds = vec![Bound { of: of("k7"), least: 0.0, most: 1.0 }];
    assert!(refused(Options { bounds, ..all_free() }).to_string().contains("no parameter `k7`"));
    let of = Of { camera: Some(CameraId(3)), name: "fx".to_owned() };
    let priors = vec![Prior { of, mean: 1.0, std: 1.0 }];
    assert_eq!(refused(Options { priors, ..all_free() }).to_string(), "there is no camera 3");
}
