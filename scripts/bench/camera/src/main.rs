//! Times our camera models beside apex-camera-models 0.2.0 and 0.4.0, and checks that all of them see the same.
//!
//! cargo run --release --locked --manifest-path scripts/bench/camera/Cargo.toml [ROUNDS]
//!
//! Prints ns of CPU time a point, on one core. In every round each contestant goes over the same 4096 points once; a time is
//! the median of the rounds, a ratio (theirs to ours in one round) its median with the lowest and the highest. `all` is our
//! batch beside the same work of theirs: they project in a batch and unproject one by one.
//! For beside_pycolmap.py: `points` prints what COLMAP's models are given, `ours` what they cost us.

mod ours;
mod peers;
mod scene;

use std::hint::black_box;

use calibstab::camera::{self, CameraModel};
use nalgebra::{Vector2, Vector3};
use rustix::time::{ClockId, clock_gettime};

use ours::Ours;
use peers::{v0_2, v0_4};
use scene::{POINTS, Scene};

/// The works of a camera model, over all points of a scene: point by point, and as fast as it takes them all.
trait Contestant {
    fn project(&self);
    fn project_all(&self) {
        self.project();
    }
    /// Residuals with their derivatives by point, pose and parameters.
    fn factor(&self);
    fn unproject(&self) -> Vec<[f64; 3]>;
    fn unproject_all(&self) {
        black_box(self.unproject());
    }
    /// The factor of one point, as numbers.
    fn one_factor(&self, index: usize) -> Vec<f64>;
}

fn main() {
    match std::env::args().nth(1).as_deref() {
        Some("points") => with_colmaps_models(print_points),
        Some("ours") => with_colmaps_models(print_costs),
        rounds => race_all(rounds.map_or(101, |rounds| rounds.parse().unwrap())),
    }
}

fn with_colmaps_models(work: impl Fn(&Scene, &dyn Contestant)) {
    macro_rules! each {
        ($($Model:ident, $params:expr;)+) => {
            $({
                let scene = Scene::of::<camera::$Model, _>(&$params);
                work(&scene, &Ours::<camera::$Model, _>::new($params, &scene));
            })+
        };
    }
    each! {
        OpenCv, [465.7, 465.0, 376.0, 240.0, -0.275, 0.067, 0.0014, -0.00044];
        OpenCvFisheye, [419.591, 418.346, 512.0, 512.0, -0.0748247, 0.00877295, -0.00344216, 0.000329053];
        Eucm, [460.0, 458.0, 376.0, 240.0, 0.6, 1.1];
        Fov, [460.0, 458.0, 376.0, 240.0, 0.9];
    }
}

/// The model and its parameters, then x, y, z and the pixel's x, y of every point, all on one line.
fn print_points(scene: &Scene, _: &dyn Contestant) {
    print!("{}", scene.camera.model().name);
    scene.camera.params().iter().for_each(|value| print!(" {value}"));
    for (point, pixel) in scene.in_camera.iter().zip(&scene.observed) {
        print!(" {} {} {} {} {}", point.x, point.y, point.z, pixel.x, pixel.y);
    }
    println!();
}

fn print_costs(scene: &Scene, ours: &dyn Contestant) {
    let cost = |work: &dyn Fn()| spread((0..61).map(|_| ns_a_point(work)))[1];
    let error = largest_error(scene, &ours.unproject());
    println!("{} {} {error}", cost(&|| ours.project_all()), cost(&|| ours.unproject_all()));
}

fn race_all(rounds: usize) {
    println!(
        "{:<16}{:<10}{:>6} {:>24} {:>24}   error of rays, px",
        "model", "work", "ours", "apex 0.2.0", "apex 0.4.0"
    );
    macro_rules! race {
        ($($Model:ident, $Peer:ident, $params:expr;)+) => {
            $({
                let scene = Scene::of::<camera::$Model, _>(&$params);
                let ours = Ours::<camera::$Model, _>::new($params, &scene);
                let older = v0_2::Peer::new(apex_0_2::$Peer::from($params), &scene);
                let newer = v0_4::Peer::new(apex_0_4::$Peer::from($params), &scene);
                race(camera::$Model::NAME, &scene, [&ours, &older, &newer], rounds);
            })+
        };
    }
    race! {
        RadTan, RadTanCamera, [465.7, 465.0, 376.0, 240.0, -0.275, 0.067, 0.0014, -0.00044, 0.003];
        OpenCvFisheye, KannalaBrandtCamera, [419.591, 418.346, 512.0, 512.0, -0.0748247, 0.00877295, -0.00344216, 0.000329053];
        DoubleSphere, DoubleSphereCamera, [313.0, 313.0, 638.0, 514.0, -0.18, 0.59];
        Eucm, EucmCamera, [460.0, 458.0, 376.0, 240.0, 0.6, 1.1];
        Ucm, UcmCamera, [460.0, 458.0, 376.0, 240.0, 0.6];
        Fov, FovCamera, [460.0, 458.0, 376.0, 240.0, 0.9];
        FTheta, FThetaCamera, [512.0, 512.0, 420.0, 5.0, -20.0, 2.0];
    }
}

fn race(model: &str, scene: &Scene, contestants: [&dyn Contestant; 3], rounds: usize) {
    for index in 0..POINTS {
        agree(model, contestants.map(|contestant| contestant.one_factor(index)));
    }
    let works: [(&str, fn(&dyn Contestant)); 5] = [
        ("project", |contestant| contestant.project()),
        ("  all", |contestant| contestant.project_all()),
        ("factor", |contestant| contestant.factor()),
        ("unproject", |contestant| drop(black_box(contestant.unproject()))),
        ("  all", |contestant| contestant.unproject_all()),
    ];
    for (name, work) in works {
        let times: Vec<[f64; 3]> =
            (0..rounds).map(|_| contestants.map(|who| ns_a_point(|| work(who)))).collect();
        let ratio = |peer: usize| {
            let [low, middle, high] = spread(times.iter().map(|round| round[peer] / round[0]));
            let [_, ns, _] = spread(times.iter().map(|round| round[peer]));
            format!("{ns:6.1} {middle:5.1} ({low:.1} to {high:.1})")
        };
        let [_, ours, _] = spread(times.iter().map(|round| round[0]));
        print!("{model:<16}{name:<10}{ours:>6.1} {:>24} {:>24}", ratio(1), ratio(2));
        if name == "unproject" {
            let errors =
                contestants.map(|who| format!("{:8.1e}", largest_error(scene, &who.unproject())));
            print!("  {}", errors.join(" "));
        }
        println!();
    }
}

/// All numbers alike but for rounding: else they do not do the same work.
fn agree(model: &str, factors: [Vec<f64>; 3]) {
    let [ours, peers @ ..] = factors;
    for theirs in peers {
        assert_eq!(ours.len(), theirs.len());
        for (index, (a, b)) in ours.iter().zip(&theirs).enumerate() {
            assert!(
                (a - b).abs() <= 1e-6 * (1.0 + a.abs()),
                "{model}: number {index} is {a} and {b}"
            );
        }
    }
}

fn ns_a_point(work: impl FnOnce()) -> f64 {
    let now = || {
        let time = clock_gettime(ClockId::ThreadCPUTime);
        1e9 * time.tv_sec as f64 + time.tv_nsec as f64
    };
    let start = now();
    work();
    (now() - start) / POINTS as f64
}

/// Lowest, middle, highest.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    [values[0], values[values.len() / 2], values[values.len() - 1]]
}

/// How far from its pixel the worst of the rays projects, by our model; infinity for a ray that is not there.
fn largest_error(scene: &Scene, rays: &[[f64; 3]]) -> f64 {
    let error = |(ray, pixel): (&[f64; 3], &Vector2<f64>)| {
        scene
            .camera
            .project(&Vector3::from(*ray))
            .map_or(f64::INFINITY, |seen| (seen - pixel).norm())
    };
    rays.iter().zip(&scene.observed).map(error).fold(0.0, f64::max)
}
