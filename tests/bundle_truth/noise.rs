//! Noise: errors are as large as the covariance says, over many seeds, and a covariance with a known fault is found out.

use calibstab::bundle::{Adjusted, Mode, Options, Outcome};
use calibstab::camera::Model;
use calibstab::scene::Scene;
use calibstab::synth::{self, Synthetic};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{adjust, all_free, excess, largest};

/// How many seeds, unless the environment variable `CALIBSTAB_SEEDS` says otherwise.
const DEFAULT_SEEDS: u32 = 30;

pub fn seeds() -> u32 {
    match std::env::var("CALIBSTAB_SEEDS") {
        Ok(count) => count.parse().expect("CALIBSTAB_SEEDS is a number"),
        Err(_) => DEFAULT_SEEDS,
    }
}

/// A two-sided p below this is called a fault.
pub const LEAST_P: f64 = 1e-4;

/// Errors of the intrinsics over some seeds, in their covariances.
#[derive(Default)]
struct Errors {
    /// Sum of e^T Sigma^-1 e, and of how many unknowns.
    square: f64,
    count: usize,
    /// By parameter, the sum of errors in stds.
    sums: Vec<f64>,
}

impl Errors {
    /// Adds one adjustment, its covariance multiplied by a factor.
    fn add(&mut self, truth: &Scene, adjusted: &Adjusted, factor: f64) {
        let covariance = adjusted.outcome.covariance.as_ref().unwrap();
        let off = DVector::from_vec(excess(&adjusted.scene, truth, covariance));
        let matrix = covariance.matrix.as_ref().unwrap();
        let sigma =
            factor * DMatrix::from_fn(off.len(), off.len(), |row, column| matrix[row][column]);
        let stds = sigma.diagonal().map(f64::sqrt);
        // Scaled, since units differ by many orders.
        let (z, scaled) = (
            off.component_div(&stds),
            DMatrix::from_fn(off.len(), off.len(), |r, c| sigma[(r, c)] / (stds[r] * stds[c])),
        );
        self.square += z.dot(&scaled.cholesky().unwrap().solve(&z));
        self.count += z.len();
        self.sums.resize(z.len(), 0.0);
        self.sums.iter_mut().zip(z.iter()).for_each(|(sum, z)| *sum += z);
    }

    /// The two-sided probability of a sum like this.
    fn p(&self) -> f64 {
        let chi_square = ChiSquared::new(self.count as f64).unwrap();
        2.0 * chi_square.cdf(self.square).min(chi_square.sf(self.square))
    }
}

fn room(models: &[&str], run: u32) -> Synthetic {
    let camera = |name: &&str| synth::camera(Model::named(name).unwrap(), 640, 480).unwrap();
    let options = synth::Options {
        cameras: models.iter().map(camera).collect(),
        image_count: 16,
        point_count: 400,
        most_per_image: 80,
        noise_px: 0.5,
        start_off: 0.0,
        run,
        own_views: false,
        ..synth::Options::default()
    };
    synth::make(&options).unwrap()
}

/// The variance of a residual if points were not counted in the rank, as a share of what it is.
fn variance_without_points(outcome: &Outcome) -> f64 {
    let residuals = 2.0 * outcome.observations as f64;
    let freedom = residuals - outcome.rank as f64;
    freedom / (freedom + 3.0 * outcome.points as f64)
}

fn errors_are_as_predicted(models: &[&str], mode: Mode) {
    let seeds = seeds();
    let options = Options { mode, ..all_free() };
    let [mut plain, mut without_sigma, mut without_points] = [(); 3].map(|()| Errors::default());
    for run in 0..seeds {
        let Synthetic { truth, run, .. } = room(models, run);
        let adjusted = adjust(&run, &options);
        let outcome = &adjusted.outcome;
        assert_eq!(outcome.rank, outcome.unknowns);
        plain.add(&truth, &adjusted, 1.0);
        without_sigma.add(&truth, &adjusted, outcome.sigma_px.unwrap().powi(-2));
        without_points.add(&truth, &adjusted, variance_without_points(outcome));
    }
    let seeds = f64::from(seeds);
    let what = format!("{models:?} {mode:?}: {:.1} of {}", plain.square, plain.count);
    assert!(plain.p() > LEAST_P, "{what}: p {:.1e}", plain.p());
    // 0.3 for 200 seeds: 4.2 deviations of a mean.
    let mean = largest(plain.sums.iter().map(|sum| sum / seeds));
    assert!(mean < 0.3 * (200.0 / seeds).sqrt(), "{what}: mean z {mean:.2}");
    assert!(without_sigma.p() < LEAST_P, "{what}: a covariance without sigma passes");
    if mode == Mode::SelfCalibration {
        assert!(without_points.p() < LEAST_P, "{what}: a rank without points passes");
    }
}

#[test]
fn errors_of_one_camera_are_as_predicted() {
    errors_are_as_predicted(&["OPENCV"], Mode::SelfCalibration);
}

#[test]
fn errors_of_two_cameras_are_as_predicted() {
    errors_are_as_predicted(&["OPENCV", "OPENCV_FISHEYE"], Mode::SelfCalibration);
}

#[test]
fn errors_of_one_camera_with_poses_and_points_held_are_as_predicted() {
    errors_are_as_predicted(&["OPENCV"], Mode::OnlyIntrinsics);
}

#[test]
fn errors_of_three_cameras_with_poses_and_points_held_are_as_predicted() {
    let models = ["RADIAL", "DOUBLE_SPHERE", "OPENCV_FISHEYE"];
    errors_are_as_predicted(&models, Mode::OnlyIntrinsics);
}
