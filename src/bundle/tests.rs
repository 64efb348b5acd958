//! The adjustment as a whole, on scenes of known truth.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use super::testing::{Noise, World, camera, displacement, disturbed, map_points, reordered_points};
use super::*;
use crate::camera::ParamClass;
use crate::least_squares::Reason;
use crate::scene::{Camera, CameraId, Geometry, ImageId, Scene};

const ALL: [ParamClass; 3] = [ParamClass::Focal, ParamClass::PrincipalPoint, ParamClass::Extra];

fn opencv() -> Camera {
    camera("OPENCV", &[1000.0, 1010.0, 645.0, 472.0, -0.1, 0.03, 0.001, -0.0005])
}

fn fisheye() -> Camera {
    camera("OPENCV_FISHEYE", &[420.0, 421.0, 640.0, 480.0, 0.02, -0.008, 0.003, -0.0009])
}

/// All intrinsics free.
fn free() -> Options {
    let others = ALL.map(Which::Class).to_vec();
    Options { refine: Refine { others, ..Refine::default() }, ..Options::default() }
}

fn run(scene: &Scene, options: &Options) -> Adjusted {
    adjust(scene.clone(), options, &mut |_| {}).unwrap()
}

fn params(scene: &Scene, camera: u32) -> Vec<f64> {
    scene.cameras[&CameraId(camera)].intrinsics.params().to_vec()
}

/// The largest difference of free intrinsics, in standard deviations of the first.
fn apart(one: &Adjusted, other: &Adjusted) -> f64 {
    let covariance = one.outcome.covariance.as_ref().unwrap();
    let stds = covariance.stds().unwrap();
    let value = |of: &Adjusted, param: &FreeParam| params(&of.scene, param.camera.0)[param.place];
    assert!(!covariance.params.is_empty());
    let shifts = covariance.params.iter().zip(stds);
    shifts
        .map(|(param, std)| (value(one, param) - value(other, param)).abs() / std)
        .fold(0.0, f64::max)
}

#[test]
fn without_noise_the_truth_is_found_from_afar() {
    let cases = [
        vec![opencv()],
        vec![fisheye()],
        vec![opencv(), fisheye()],
        vec![
            camera("SIMPLE_RADIAL", &[900.0, 640.0, 480.0, -0.05]),
            camera("PINHOLE", &[800.0, 801.0, 640.0, 480.0]),
        ],
        vec![camera("DOUBLE_SPHERE", &[500.0, 501.0, 640.0, 480.0, -0.2, 0.55])],
    ];
    for cameras in cases {
        let world = World::ring(cameras.clone(), 14, 120);
        let adjusted = run(&disturbed(world.scene(), 0.01, 1.03), &free());
        assert_eq!(adjusted.outcome.rank, adjusted.outcome.unknowns);
        assert!(adjusted.outcome.cost < 1e-12, "{:?}", adjusted.outcome);
        for (id, truth) in (1..).zip(&cameras) {
            let found = &adjusted.scene.cameras[&CameraId(id)].intrinsics;
            let px = displacement(&truth.intrinsics, found, truth);
            assert!(px < 1e-7, "{}: {px:.1e} px", truth.intrinsics.model().name);
        }
    }
}

#[test]
fn a_focal_length_that_is_a_fifth_off_is_found() {
    let world = World::ring(vec![opencv()], 14, 120).with_noise(0.5);
    let from_truth = run(&world.scene(), &free());
    let from_afar = run(&disturbed(world.scene(), 0.005, 1.2), &free());
    assert_eq!(from_afar.outcome.reason, Reason::Converged);
    assert!(apart(&from_truth, &from_afar) < 1e-5, "{:.1e}", apart(&from_truth, &from_afar));
    assert!(from_afar.outcome.iterations < 30, "{}", from_afar.outcome.iterations);
    let sigma = from_afar.outcome.sigma_px.unwrap();
    assert!((sigma - 0.5).abs() < 0.05, "{sigma}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    // Enough points for several chunks.
    let world = World::ring(vec![opencv(), fisheye()], 20, 900).with_noise(0.5);
    let start = disturbed(world.scene(), 0.005, 1.02);
    assert!(problem::Problem::new(&start, &free()).unwrap().chunks.len() > 2);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&start, &free()))
    };
    let alone = with(1);
    for threads in [2, 3, 8] {
        assert_eq!(with(threads), alone, "{threads}");
    }
}

#[test]
fn neither_unit_nor_place_nor_order_nor_numbers_change_the_intrinsics() {
    let world = World::ring(vec![opencv(), fisheye()], 14, 150).with_noise(0.5);
    let start = disturbed(world.scene(), 0.005, 1.02);
    let plain = run(&start, &free());
    let moved = |scale: f64, shift: Vector3<f64>| {
        let mut scene = start.clone();
        let turn = UnitQuaternion::from_euler_angles(0.5, 1.0, -2.0);
        let geometry = scene.geometry.as_mut().unwrap();
        for image in geometry.images.values_mut() {
            let pose = image.cam_from_world.to_isometry().unwrap();
            let rotation = pose.rotation * turn.inverse();
            let translation = pose.translation.vector * scale - rotation * shift;
            image.cam_from_world = Isometry3::from_parts(translation.into(), rotation).into();
        }
        map_points(geometry, |xyz| turn * xyz * scale + shift);
        scene
    };
    let mut reordered = start.clone();
    let geometry = reordered.geometry.as_mut().unwrap();
    geometry.points = reordered_points(geometry);
    let cases = [
        moved(1e6, Vector3::zeros()),
        moved(1e-7, Vector3::zeros()),
        moved(1.0, Vector3::new(1e4, -2e4, 3e3)),
        reordered,
        renumbered(&start),
    ];
    for (index, case) in cases.iter().enumerate() {
        let other = run(case, &free());
        assert_eq!(other.outcome.observations, plain.outcome.observations);
        assert!(apart(&plain, &other) < 1e-6, "case {index}: {:.1e}", apart(&plain, &other));
    }
}

/// Images under other ids, in another order.
fn renumbered(scene: &Scene) -> Scene {
    let number = |id: ImageId| ImageId(1000 - 7 * id.0);
    let mut scene = scene.clone();
    let Geometry { images, points, mounting } = scene.geometry.take().unwrap();
    let images = images.into_iter().map(|(id, image)| (number(id), image)).collect();
    let mut renumbered = crate::scene::Points3D::default();
    for point in points.iter() {
        let crate::scene::Point3D { id, xyz, rgb, error_px, track } = point;
        let track: Vec<_> = track
            .map(|element| crate::scene::TrackElement { image: number(element.image), ..element })
            .collect();
        renumbered.push(crate::scene::Point3D { id, xyz, rgb, error_px, track });
    }
    scene.geometry = Some(Geometry { images, points: renumbered, mounting });
    scene
}

#[test]
fn each_mode_moves_what_it_names_and_leaves_every_other_bit() {
    let world = World::ring(vec![opencv()], 12, 100).with_noise(0.5);
    let truth = world.scene();
    let modes = [
        Mode::SelfCalibration,
        Mode::BundleAdjustment,
        Mode::OnlyPose,
        Mode::OnlyLandmarks,
        Mode::OnlyIntrinsics,
    ];
    for mode in modes {
        // Only what moves is off.
        let mut start = disturbed(truth.clone(), 0.02, 1.01);
        let (off, right) = (start.geometry.clone().unwrap(), truth.geometry.clone().unwrap());
        let poses = if mode.moves_poses() { &off } else { &right };
        let points = if mode.moves_points() { &off } else { &right };
        let geometry = Geometry {
            images: poses.images.clone(),
            points: points.points.clone(),
            mounting: None,
        };
        start.geometry = Some(geometry);
        if !mode.moves_intrinsics() {
            start.cameras.clone_from(&truth.cameras);
        }
        let adjusted = run(&start, &Options { mode, ..free() });
        let (before, after) = (start.geometry.unwrap(), adjusted.scene.geometry.unwrap());
        assert!(adjusted.outcome.cost < 0.1 * adjusted.outcome.initial_cost, "{mode:?}");
        let sigma = adjusted.outcome.sigma_px.unwrap();
        assert!((sigma - 0.5).abs() < 0.06, "{mode:?}: {sigma}");
        assert_eq!(adjusted.outcome.rank, adjusted.outcome.unknowns, "{mode:?}");
        assert_eq!(before.images == after.images, !mode.moves_poses(), "{mode:?}");
        let places = |geometry: &Geometry| {
            geometry.points.iter().map(|p| p.xyz.map(f64::to_bits)).collect::<Vec<_>>()
        };
        assert_eq!(places(&before) == places(&after), !mode.moves_points(), "{mode:?}");
        assert_eq!(start.cameras == adjusted.scene.cameras, !mode.moves_intrinsics(), "{mode:?}");
    }
}

#[test]
fn parameters_are_chosen_by_name_and_by_camera() {
    let world = World::ring(vec![opencv(), fisheye()], 12, 100).with_noise(0.5);
    let start = disturbed(world.scene(), 0.003, 1.01);
    let named = |name: &str| Which::Named(name.to_owned());
    let mut options = Options::default();
    options.refine.cameras.insert(CameraId(1), vec![named("fx"), named("k1")]);
    options.refine.cameras.insert(CameraId(2), vec![]);
    let adjusted = run(&start, &options);
    let (before, after) = (params(&start, 1), params(&adjusted.scene, 1));
    let moved: Vec<usize> =
        (0..8).filter(|&at| before[at].to_bits() != after[at].to_bits()).collect();
    assert_eq!(moved, [0, 4]);
    assert_eq!(params(&start, 2), params(&adjusted.scene, 2));
    let free: Vec<_> =
        adjusted.outcome.covariance.unwrap().params.iter().map(|p| (p.camera.0, p.name)).collect();
    assert_eq!(free, [(1, "fx"), (1, "k1")]);
    // A name that means nothing is refused.
    options.refine.cameras.insert(CameraId(1), vec![named("k7")]);
    let refused = adjust(start.clone(), &options, &mut |_| {}).unwrap_err();
    assert!(matches!(refused, BundleError::NoParam { camera: Some(CameraId(1)), .. }), "{refused}");
    options.refine = Refine::default();
    options.refine.cameras.insert(CameraId(9), vec![]);
    let refused = adjust(start, &options, &mut |_| {}).unwrap_err();
    assert_eq!(refused, BundleError::NoCamera(CameraId(9)));
}

#[test]
fn with_all_parameters_held_and_a_camera_unused_the_rest_is_adjusted() {
    let world = World::ring(vec![opencv()], 10, 80).with_noise(0.5);
    let mut start = disturbed(world.scene(), 0.003, 1.0);
    start.cameras.insert(CameraId(5), fisheye());
    let options =
        Options { refine: Refine { others: vec![], ..Refine::default() }, ..Options::default() };
    let adjusted = run(&start, &options);
    assert_eq!(adjusted.scene.cameras, start.cameras);
    assert_eq!(adjusted.outcome.reason, Reason::Converged);
    assert_eq!(adjusted.outcome.covariance, None);
    let unused = adjusted.outcome.cameras.iter().find(|camera| camera.id == CameraId(5)).unwrap();
    assert_eq!(unused.images, 0);
    // Free, it is no unknown either: nothing depends on it.
    assert_eq!(run(&start, &free()).outcome.rank, run(&start, &free()).outcome.unknowns);
}

#[test]
fn what_cannot_be_projected_and_what_one_image_sees_is_left_out_and_counted() {
    let world = World::ring(vec![opencv()], 10, 80).with_noise(0.5);
    let mut scene = disturbed(world.scene(), 0.002, 1.0);
    let seen = scene.geometry.as_ref().unwrap().points.observation_count();
    let geometry = scene.geometry.as_mut().unwrap();
    let first = geometry.points.iter().next().unwrap();
    let (track, id) = (first.track.clone().collect::<Vec<_>>(), first.id);
    // A point behind the first image that claims to see it.
    let eye = geometry.images[&track[0].image].cam_from_world.to_isometry().unwrap().inverse();
    let behind = eye.transform_point(&Point3::new(0.0, 0.0, -2.0)).coords;
    let mut points = crate::scene::Points3D::default();
    for point in geometry.points.iter() {
        let is_first = point.id == id;
        let crate::scene::Point3D { id, xyz, rgb, error_px, track } = point;
        let xyz = if is_first { behind.into() } else { xyz };
        let keep = if is_first { 1 } else { usize::MAX };
        points.push(crate::scene::Point3D {
            id,
            xyz,
            rgb,
            error_px,
            track: track.take(keep).collect::<Vec<_>>(),
        });
    }
    // Another, that a single image sees.
    let lone = crate::scene::Point3DId(10_000);
    let element = track[1];
    points.push(crate::scene::Point3D {
        id: lone,
        xyz: first_point(geometry),
        rgb: [0; 3],
        error_px: -1.0,
        track: vec![element],
    });
    geometry.points = points;
    let adjusted = run(&scene, &free());
    let dropped = adjusted.outcome.dropped;
    assert_eq!(dropped, Dropped { unprojectable: 1, lone_points: 2, of_lone_points: 1 });
    assert_eq!(adjusted.outcome.observations, seen - track.len());
    assert_eq!(adjusted.outcome.reason, Reason::Converged);
}

fn first_point(geometry: &Geometry) -> [f64; 3] {
    geometry.points.iter().nth(1).unwrap().xyz
}

#[test]
fn gross_outliers_move_little_under_a_robust_loss() {
    let world = World::ring(vec![opencv()], 14, 150).with_noise(0.3);
    let clean = run(&world.scene(), &free());
    let mut scene = world.scene();
    let mut noise = Noise(3);
    for image in scene.geometry.as_mut().unwrap().images.values_mut() {
        let moved: Vec<_> = image
            .keypoints
            .iter()
            .enumerate()
            .map(|(index, mut keypoint)| {
                if index % 20 == 7 {
                    keypoint.xy = keypoint.xy.map(|value| value + 60.0 * noise.even());
                }
                keypoint
            })
            .collect();
        image.keypoints.clear();
        moved.into_iter().for_each(|keypoint| image.keypoints.push(keypoint));
    }
    let squared = apart(&clean, &run(&scene, &free()));
    assert!(squared > 3.0, "{squared}");
    for loss in [Loss::Huber(0.5), Loss::SoftL1(0.5), Loss::Cauchy(0.5)] {
        let robust = run(&scene, &Options { loss, ..free() });
        assert_eq!(robust.outcome.reason, Reason::Converged, "{loss:?}");
        let shift = apart(&clean, &robust);
        assert!(shift < 0.3 * squared, "{loss:?}: {shift}, squared {squared}");
        assert!(robust.outcome.iterations < 60, "{loss:?}: {}", robust.outcome.iterations);
    }
}

#[test]
fn parts_that_share_no_point_are_adjusted_side_by_side() {
    let world = World::ring(vec![opencv()], 12, 160).with_noise(0.5);
    let mut scene = disturbed(world.scene(), 0.003, 1.01);
    let geometry = scene.geometry.as_mut().unwrap();
    let mut points = crate::scene::Points3D::default();
    for (index, point) in geometry.points.iter().enumerate() {
        // Odd points are seen by images 1 to 6 alone, even ones by the others.
        let crate::scene::Point3D { id, xyz, rgb, error_px, track } = point;
        let track: Vec<_> = track.filter(|e| (e.image.0 <= 6) == (index % 2 == 1)).collect();
        points.push(crate::scene::Point3D { id, xyz, rgb, error_px, track });
    }
    geometry.points = points;
    let outcome = run(&scene, &free()).outcome;
    assert_eq!(outcome.components, 2);
    assert_eq!(outcome.unknowns, 6 * 12 + 3 * outcome.points + 8 - 14);
    assert_eq!((outcome.rank, outcome.reason), (outcome.unknowns, Reason::Converged));
}

#[test]
fn what_the_views_do_not_determine_is_said() {
    // Cameras on a straight line that all look ahead, with the same roll: focal length and depth are one.
    let points = World::ring(vec![opencv()], 3, 60).points;
    let poses =
        (0..6).map(|at| Isometry3::translation(0.4 * f64::from(at) - 1.0, 0.0, 9.0)).collect();
    let pinhole = camera("PINHOLE", &[1000.0, 1000.0, 640.0, 480.0]);
    let world = World { cameras: vec![pinhole], poses, points, noise_px: 0.0 };
    let options = Options { mode: Mode::SelfCalibration, ..free() };
    let outcome = run(&world.scene(), &options).outcome;
    let covariance = outcome.covariance.unwrap();
    assert!(covariance.matrix.is_none());
    assert!(!covariance.open.is_empty());
    assert!(outcome.rank < outcome.unknowns);
    let words: Vec<String> = covariance.open.iter().map(|open| covariance.words(open)).collect();
    assert!(words.iter().any(|words| words.contains("fx") || words.contains("fy")), "{words:?}");
}

#[test]
fn degenerate_views_end_and_never_get_worse() {
    let cloud = World::ring(vec![opencv()], 3, 80).points;
    let plane: Vec<_> = cloud.iter().map(|p| Vector3::new(p.x, p.y, 0.0)).collect();
    let ahead = |at: u32| Isometry3::translation(0.0, 0.0, 9.0 - 0.5 * f64::from(at));
    let turned = |at: u32| {
        let turn =
            UnitQuaternion::from_euler_angles(0.05 * f64::from(at % 3), 0.04 * f64::from(at), 0.1);
        Isometry3::from_parts(Vector3::new(0.0, 0.0, 9.0).into(), turn)
    };
    let ring = World::ring(vec![opencv()], 8, 3).poses;
    type Case<'a> = (&'a str, Vec<Isometry3<f64>>, &'a [Vector3<f64>]);
    let cases: [Case; 6] = [
        ("a plane", ring.clone(), &plane),
        ("forward motion", (0..6).map(ahead).collect(), &cloud),
        (
            "pure rotation",
            (0..6)
                .map(turned)
                .map(|p| p.rotation)
                .map(|r| Isometry3::from_parts((r * Vector3::new(0.0, 0.0, 9.0)).into(), r))
                .collect(),
            &cloud,
        ),
        ("two images", ring[..2].to_vec(), &cloud),
        ("three images at one place", vec![ring[0]; 3], &cloud),
        ("a collapsed cluster", ring[..4].to_vec(), &cloud),
    ];
    for (name, poses, points) in cases {
        let world =
            World { cameras: vec![opencv()], poses, points: points.to_vec(), noise_px: 0.5 };
        let mut scene = world.scene();
        if name == "a collapsed cluster" {
            let (mut count, geometry) = (0, scene.geometry.as_mut().unwrap());
            map_points(geometry, |xyz| {
                count += 1;
                if count % 2 == 0 { Vector3::new(1.0, 1.0, 1.0) + xyz * 1e-12 } else { xyz }
            });
        }
        let outcome = run(&scene, &Options::default()).outcome;
        assert!(
            outcome.cost <= outcome.initial_cost && outcome.cost.is_finite(),
            "{name}: {outcome:?}"
        );
        assert!(outcome.rank <= outcome.unknowns, "{name}");
        let values =
            outcome.cameras.iter().flat_map(|camera| camera.after.intrinsics.params().to_vec());
        assert!(values.into_iter().all(f64::is_finite), "{name}");
    }
}

#[test]
fn one_image_alone_has_nothing_to_adjust_but_its_pose() {
    let world = World::ring(vec![opencv()], 1, 80).with_noise(0.5);
    let refused = adjust(world.scene(), &free(), &mut |_| {}).unwrap_err();
    assert!(matches!(refused, BundleError::NoObservation { unprojectable: 0, .. }), "{refused}");
    let posed =
        run(&disturbed(world.scene(), 0.0, 1.0), &Options { mode: Mode::OnlyPose, ..free() });
    assert_eq!((posed.outcome.unknowns, posed.outcome.rank), (6, 6));
}

#[test]
fn too_little_memory_and_a_lone_list_of_cameras_are_refused() {
    let scene = World::ring(vec![opencv()], 10, 80).scene();
    let options = Options { memory: Some(1000), ..free() };
    let refused = adjust(scene.clone(), &options, &mut |_| {}).unwrap_err();
    assert!(
        matches!(refused, BundleError::Memory { images: 10, needed, limit: 1000 } if needed > 30_000),
        "{refused}"
    );
    let lone = Scene { geometry: None, ..scene };
    assert_eq!(adjust(lone, &free(), &mut |_| {}).unwrap_err(), BundleError::NoGeometry);
}

#[test]
fn points_beyond_ninety_degrees_take_part() {
    let mut world = World::ring(
        vec![camera("OPENCV_FISHEYE", &[300.0, 301.0, 640.0, 480.0, 0.02, -0.008, 0.003, -0.0009])],
        12,
        300,
    );
    world.points.iter_mut().for_each(|point| *point *= 4.0);
    let world = world.with_noise(0.5);
    let scene = world.scene();
    let geometry = scene.geometry.as_ref().unwrap();
    let beyond =
        geometry.points.iter().flat_map(|p| p.track.map(move |e| (p.xyz, e.image))).filter(
            |(xyz, image)| {
                let pose = geometry.images[image].cam_from_world.to_isometry().unwrap();
                pose.transform_point(&Point3::from(*xyz)).z < 0.0
            },
        );
    assert!(beyond.count() > 20);
    let adjusted = run(&disturbed(scene, 0.003, 1.01), &free());
    assert_eq!(adjusted.outcome.dropped, Dropped::default());
    let sigma = adjusted.outcome.sigma_px.unwrap();
    assert!((sigma - 0.5).abs() < 0.05, "{sigma}");
}
