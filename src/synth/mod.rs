//! Seeded synthetic reconstructions with known truth: for tests, benches, a user's first try.
//!
//! One seed gives the same scene in every version. Knows nothing of files, nor of any camera model by name.

mod frame;
mod lens;
mod observe;
mod random;
mod redraw;
mod remarks;
mod scene;
mod start;
mod world;

use std::f64::consts::PI;

use nalgebra::{Isometry3, Vector2, Vector3};

pub use lens::camera;
pub use random::{Purpose, Random};
pub use redraw::{Noiseless, with_redrawn_noise};
pub use start::Starts;
pub use world::{Views, World};

use crate::camera::Intrinsics;
use crate::scene::{Camera, Scene};
use frame::Frame;
use observe::Sightings;

/// What to make.
///
/// ```
/// use calibstab::synth::{Options, make};
///
/// let exact = make(&Options { noise_px: 0.0, start_off: 0.0, ..Options::default() })?;
/// assert_eq!(exact.run, exact.truth);
/// # Ok::<(), calibstab::synth::SynthError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The true cameras; they take the images in turn.
    pub cameras: Vec<Camera>,
    /// How many images are taken.
    pub image_count: u32,
    /// How many points there are to be seen.
    pub point_count: u32,
    /// An image sees no more points than this, drawn from all that are visible.
    pub most_per_image: u32,
    /// A point is kept when so many images see it.
    pub least_track: u32,
    /// What is seen.
    pub world: World,
    /// From where.
    pub views: Views,
    /// Further from the axis than this nothing is seen, whatever the lens.
    pub widest_degrees: f64,
    /// Standard deviation of the errors of x and of y, in px.
    pub noise_px: f64,
    /// How far off the run's estimates are: standard deviation of focal lengths and distortion as a share of themselves, of
    /// camera centres and points in m (the room is 10 m wide), of rotations about each axis in 0.1 rad.
    pub start_off: f64,
    /// The same seed gives the same room.
    pub seed: u64,
    /// Each run, counted from 0, has its own noise and start.
    pub run: u32,
    /// Each run has its own images too; else all have those of run 0.
    pub own_views: bool,
}

impl Default for Options {
    fn default() -> Self {
        let lens = [950.0, 945.0, 640.0, 480.0, -0.25, 0.08, 0.0006, -0.0004];
        Self {
            cameras: vec![Camera {
                intrinsics: Intrinsics::OpenCv(lens),
                width: 1280,
                height: 960,
            }],
            image_count: 60,
            point_count: 5000,
            most_per_image: 500,
            least_track: 2,
            world: World::default(),
            views: Views::default(),
            widest_degrees: 180.0,
            noise_px: 0.5,
            start_off: 0.02,
            seed: 1,
            run: 0,
            own_views: true,
        }
    }
}

/// What cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SynthError {
    /// There is no camera.
    #[error("there is no camera to take images with")]
    NoCamera,
    /// A quantity that is no number, or below 0.
    #[error("{name} is {value}, expected a number from 0 on")]
    OutOfRange {
        /// What it is.
        name: &'static str,
        /// Its value.
        value: f64,
    },
}

/// The truth, and what a reconstruction of it might hold before its last adjustment.
#[derive(Debug, Clone, PartialEq)]
pub struct Synthetic {
    /// Cameras, poses, points and pixels without error.
    pub truth: Scene,
    /// The same, under the same ids: pixels with noise, all else as far off as asked for. Principal points are not off, since
    /// COLMAP holds them.
    pub run: Scene,
    /// What was left out, and what a user should know of the rest.
    pub remarks: Vec<String>,
}

/// Everything but the pixels; poses from world to camera, one an image.
struct Estimate {
    cameras: Vec<Camera>,
    poses: Vec<Isometry3<f64>>,
    points: Vec<Vector3<f64>>,
}

impl Estimate {
    fn of_truth(options: &Options) -> Self {
        let Options { world, views, seed, .. } = *options;
        let points = world.points(options.point_count, &mut Random::new(seed, 0, Purpose::World));
        let mut random = Random::new(seed, options.run_of_views(), Purpose::Views);
        let mut poses = views.poses(options.image_count, world, &mut random);
        let cameras = options.cameras.clone();
        for (image, pose) in poses.iter_mut().enumerate() {
            if Frame::axis(&camera_of(&cameras, image).intrinsics).z < 0.0 {
                // What such a camera looks at lies along its -Z, and what is up along its Y.
                *pose = Isometry3::rotation(PI * Vector3::x()) * *pose;
            }
        }
        Self { cameras, poses, points }
    }

    /// The pixel in an image of what is at this place.
    fn project(&self, image: usize, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        let seen = self.poses[image].transform_point(&(*point).into());
        camera_of(&self.cameras, image).intrinsics.project(&seen.coords).ok()
    }
}

/// Cameras take images in turn.
fn camera_of(cameras: &[Camera], image: usize) -> &Camera {
    &cameras[image % cameras.len()]
}

/// Makes a synthetic reconstruction.
pub fn make(options: &Options) -> Result<Synthetic, SynthError> {
    options.check()?;
    let truth = Estimate::of_truth(options);
    let seen = Sightings::of(&truth, options);
    let truth = Estimate { points: seen.kept(truth.points), ..truth };
    let start = truth.off_by(options.start_off, &mut options.random(Purpose::Start));
    let noisy = seen.with_noise(options.noise_px, &mut options.random(Purpose::Noise));
    let earlier_images = options.run_of_views() * u64::from(options.image_count);
    Ok(Synthetic {
        truth: truth.scene(&seen, earlier_images),
        run: start.scene(&noisy, earlier_images),
        remarks: remarks::remarks(&truth, &start, &seen, options),
    })
}

impl Options {
    fn check(&self) -> Result<(), SynthError> {
        if self.cameras.is_empty() {
            return Err(SynthError::NoCamera);
        }
        for (name, value) in [
            ("the widest angle", self.widest_degrees),
            ("the noise", self.noise_px),
            ("the start's error", self.start_off),
        ] {
            if !(0.0..f64::INFINITY).contains(&value) {
                return Err(SynthError::OutOfRange { name, value });
            }
        }
        Ok(())
    }

    /// The stream of random numbers for what this run has to itself.
    fn random(&self, purpose: Purpose) -> Random {
        Random::new(self.seed, self.run.into(), purpose)
    }

    /// The run whose images these are.
    fn run_of_views(&self) -> u64 {
        if self.own_views { self.run.into() } else { 0 }
    }
}
