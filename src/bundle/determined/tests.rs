//! Rank and covariances beside the same algebra on the whole Jacobian, which is made from the scene alone.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Isometry3, Matrix2x3, Point3, UnitQuaternion, Vector3};

use super::super::testing::{Noise, World, camera};
use super::super::{Adjusted, Mode, Outcome, Refine, adjust, adjust_to_optimum};
use super::super::{Loss, Options};
use super::{Known, Problem, Solver, State, determined};
use crate::camera::{CameraModel, Job};
use crate::least_squares::{self, Problem as _, Trial};
use crate::scene::{
    Camera, CameraId, ImageId, Keypoint, Keypoints, Point3D, Points3D, Scene, TrackElement,
};

fn opencv() -> Camera {
    camera("OPENCV", &[1000.0, 1010.0, 645.0, 472.0, -0.1, 0.03, 0.001, -0.0005])
}

fn fisheye() -> Camera {
    camera("OPENCV_FISHEYE", &[420.0, 421.0, 640.0, 480.0, 0.02, -0.008, 0.003, -0.0009])
}

fn free(mode: Mode, loss: Loss) -> Options {
    Options { refine: Refine::all(), mode, loss, ..Options::default() }
}

fn run(scene: &Scene, options: &Options) -> Adjusted {
    adjust(scene.clone(), options, &mut |_| {}).unwrap()
}

/// d pixel / d point in camera coordinates and d pixel / d parameters, and the pixel.
struct Blocks(Vector3<f64>);

impl Job for Blocks {
    type Output = (Matrix2x3<f64>, Vec<[f64; 2]>, [f64; 2]);

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Self::Output {
        let at = M::linearize(params, &self.0).unwrap();
        let by_params = (0..N).map(|k| [at.wrt_params[(0, k)], at.wrt_params[(1, k)]]).collect();
        (at.wrt_point, by_params, at.pixel.into())
    }
}

/// All columns that the mode moves, gauge and all: poses, then intrinsics, then points.
struct Whole {
    jacobian: DMatrix<f64>,
    residual: DVector<f64>,
    /// Of each row.
    image: Vec<ImageId>,
    /// Which columns are intrinsics.
    intrinsics: std::ops::Range<usize>,
}

impl Whole {
    fn of(scene: &Scene, options: &Options) -> Self {
        let geometry = scene.geometry.as_ref().unwrap();
        let (mode, mut width) = (options.mode, 0);
        let mut take = |count: usize, moves: bool| {
            width += if moves { count } else { 0 };
            moves.then(|| width - count)
        };
        let poses: BTreeMap<ImageId, Option<usize>> =
            geometry.images.keys().map(|&id| (id, take(6, mode.moves_poses()))).collect();
        let mut params = BTreeMap::new();
        for (id, camera) in &scene.cameras {
            let which = options.refine.of(*id);
            let all = camera.intrinsics.model().params.iter();
            let moves = all.map(|p| mode.moves_intrinsics() && which.iter().any(|w| w.is(p)));
            params.insert(*id, moves.map(|moves| take(1, moves)).collect::<Vec<_>>());
        }
        let own: Vec<usize> = params.values().flatten().flatten().copied().collect();
        let points: Vec<Option<usize>> =
            geometry.points.iter().map(|_| take(3, mode.moves_points())).collect();
        let rows = 2 * geometry.points.observation_count();
        let (mut jacobian, mut residual) = (DMatrix::zeros(rows, width), DVector::zeros(rows));
        let (mut image_of, mut row) = (Vec::new(), 0);
        for (point, own) in geometry.points.iter().zip(&points) {
            for element in point.track {
                let image = &geometry.images[&element.image];
                let pose = image.cam_from_world.to_isometry().unwrap();
                let seen = pose.transform_point(&Point3::from(point.xyz)).coords;
                let lens = &scene.cameras[&image.camera].intrinsics;
                let (by_point, by_params, pixel) = lens.visit(Blocks(seen));
                if let Some(at) = poses[&element.image] {
                    // The camera turns and moves in its own coordinates.
                    jacobian
                        .view_mut((row, at), (2, 3))
                        .copy_from(&(-by_point * seen.cross_matrix()));
                    jacobian.view_mut((row, at + 3), (2, 3)).copy_from(&by_point);
                }
                for (place, by_param) in params[&image.camera].iter().zip(&by_params) {
                    if let Some(at) = place {
                        (0..2).for_each(|axis| jacobian[(row + axis, *at)] = by_param[axis]);
                    }
                }
                if let Some(at) = own {
                    let turned = by_point * pose.rotation.to_rotation_matrix().matrix();
                    jacobian.view_mut((row, *at), (2, 3)).copy_from(&turned);
                }
                let xy = image.keypoints.get(element.keypoint as usize).unwrap().xy;
                (0..2).for_each(|axis| residual[row + axis] = pixel[axis] - xy[axis]);
                image_of.extend([element.image; 2]);
                row += 2;
            }
        }
        let intrinsics = own.first().map_or(0..0, |&first| first..first + own.len());
        Self { jacobian, residual, image: image_of, intrinsics }
    }

    /// By singular values, columns scaled.
    fn rank(&self) -> usize {
        // Between the least that these scenes determine, about 1e-5, and rounding, about 1e-14.
        const NULL: f64 = 1e-9;
        let mut scaled = self.jacobian.clone();
        for mut column in scaled.column_iter_mut() {
            let norm = column.norm();
            column /= if norm > 0.0 { norm } else { 1.0 };
        }
        let values = scaled.singular_values();
        let least = values.iter().filter(|&&value| value > NULL * values[0]);
        least.count()
    }
}

/// The scene with each point's track as this makes it of the point's number.
fn with_tracks(mut scene: Scene, keep: impl Fn(usize, &mut Vec<TrackElement>)) -> Scene {
    let geometry = scene.geometry.as_mut().unwrap();
    let mut points = Points3D::default();
    for (index, point) in geometry.points.iter().enumerate() {
        let Point3D { id, xyz, rgb, error_px, track } = point;
        let mut track: Vec<_> = track.collect();
        keep(index, &mut track);
        points.push(Point3D { id, xyz, rgb, error_px, track });
    }
    geometry.points = points;
    scene
}

/// Scenes at the truth, without noise: what is open stays so.
fn scenes() -> Vec<(&'static str, Scene)> {
    let ring = |cameras, images| World::ring(cameras, images, 24).scene();
    let cloud = World::ring(vec![opencv()], 3, 24).points;
    let of = |cameras: Vec<Camera>, poses: Vec<Isometry3<f64>>| {
        World { cameras, poses, points: cloud.clone(), noise_px: 0.0 }.scene()
    };
    let back = Vector3::new(0.0, 0.0, 9.0);
    let turned = |at: u32| {
        let (a, b) = (0.05 * f64::from(at % 3), 0.04 * f64::from(at));
        let turn = UnitQuaternion::from_euler_angles(a, b, 0.1);
        Isometry3::from_parts((turn * back).into(), turn)
    };
    let beside = |at: u32| Isometry3::translation(0.4 * f64::from(at) - 1.0, 0.0, 9.0);
    let pinhole = camera("PINHOLE", &[1000.0, 1000.0, 640.0, 480.0]);
    let simple = camera("SIMPLE_PINHOLE", &[1000.0, 640.0, 480.0]);
    let mut unused = ring(vec![opencv()], 7);
    unused.cameras.insert(CameraId(9), fisheye());
    let blind = with_tracks(ring(vec![opencv()], 7), |_, track| track.retain(|e| e.image.0 != 3));
    vec![
        ("one camera", ring(vec![opencv()], 7)),
        ("two cameras", ring(vec![opencv(), fisheye()], 8)),
        (
            "two parts that share a camera",
            with_tracks(ring(vec![opencv()], 10), |index, track| {
                track.retain(|e| (e.image.0 <= 5) == (index % 2 == 1));
            }),
        ),
        (
            "three parts, each camera in all",
            with_tracks(ring(vec![opencv(), fisheye()], 15), |index, track| {
                track.retain(|e| usize::try_from(e.image.0).unwrap() % 3 == index % 3);
            }),
        ),
        (
            "points seen once and twice",
            with_tracks(ring(vec![opencv()], 8), |index, track| match index % 4 {
                0 => track.truncate(1),
                1 => track.truncate(2),
                _ => {}
            }),
        ),
        ("pure rotation", of(vec![opencv()], (0..6).map(turned).collect())),
        ("a straight line, looking ahead", of(vec![pinhole], (0..6).map(beside).collect())),
        ("the same, one focal length", of(vec![simple], (0..6).map(beside).collect())),
        ("three images", ring(vec![opencv()], 3)),
        ("an unused camera", unused),
        ("an image that sees nothing", blind),
    ]
}

#[test]
fn the_rank_is_that_of_the_whole_jacobian_in_every_mode() {
    let modes = [
        Mode::SelfCalibration,
        Mode::BundleAdjustment,
        Mode::OnlyPose,
        Mode::OnlyLandmarks,
        Mode::OnlyIntrinsics,
    ];
    let (mut checked, mut short) = (0, 0);
    for (name, scene) in scenes() {
        for mode in modes {
            let options = free(mode, Loss::Squared);
            let Adjusted { scene: ended, outcome } = run(&scene, &options);
            let whole = Whole::of(&ended, &options);
            // A point that one image sees was left out: its two rows serve nothing but itself.
            let left_out = 2 * outcome.dropped.of_lone_points;
            assert_eq!(outcome.rank + left_out, whole.rank(), "{name}, {mode:?}");
            // The rank is a matter of the geometry, not of the loss.
            let robust = run(&scene, &free(mode, Loss::Cauchy(1.0))).outcome;
            assert_eq!((robust.rank, robust.unknowns), (outcome.rank, outcome.unknowns), "{name}");
            checked += 1;
            short += usize::from(outcome.rank < outcome.unknowns);
        }
    }
    // Some of them leave directions open beyond the gauge.
    assert!(checked == 55 && short >= 3, "{checked} {short}");
}

/// A camera with images enough for clusters, and one without; noise, and every twelfth keypoint some px off.
fn two_cameras() -> Scene {
    let mut scene = World::ring(vec![opencv(), opencv()], 34, 24).scene();
    scene.cameras.insert(CameraId(2), fisheye());
    let geometry = scene.geometry.as_mut().unwrap();
    let places: BTreeMap<_, _> = geometry.points.iter().map(|p| (p.id, p.xyz)).collect();
    let mut noise = Noise(5);
    for (id, image) in &mut geometry.images {
        image.camera = CameraId(if id.0 % 11 == 3 { 2 } else { 1 });
        let pose = image.cam_from_world.to_isometry().unwrap();
        let mut keypoints = Keypoints::default();
        for (index, Keypoint { point, .. }) in image.keypoints.iter().enumerate() {
            let seen = pose.transform_point(&Point3::from(places[&point.unwrap()])).coords;
            let pixel = scene.cameras[&image.camera].intrinsics.project(&seen).unwrap();
            let size = if index % 12 == 7 { 5.0 } else { 0.5 };
            let xy = [pixel.x, pixel.y].map(|value| value + size * noise.normal());
            keypoints.push(Keypoint { xy, point });
        }
        image.keypoints = keypoints;
    }
    scene
}

const LOSSES: [Loss; 4] = [Loss::Squared, Loss::Huber(0.8), Loss::SoftL1(0.8), Loss::Cauchy(1.0)];

/// The largest difference of two matrices, rows and columns in units of the first's diagonal.
fn apart(one: &DMatrix<f64>, other: &DMatrix<f64>) -> f64 {
    let std = one.diagonal().map(f64::sqrt);
    let mut most: f64 = 0.0;
    for row in 0..one.nrows() {
        for column in 0..one.ncols() {
            let off = (one[(row, column)] - other[(row, column)]) / (std[row] * std[column]);
            assert!(off.is_finite());
            most = most.max(off.abs());
        }
    }
    most
}

fn matrix(rows: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows.len(), |row, column| rows[row][column])
}

#[test]
fn covariances_are_those_of_the_whole_jacobian() {
    let scene = two_cameras();
    let mut clusters = 0;
    for loss in LOSSES {
        let options = free(Mode::SelfCalibration, loss);
        let Adjusted { scene: ended, outcome } = run(&scene, &options);
        let whole = Whole::of(&ended, &options);
        let covariance = outcome.covariance.as_ref().unwrap();
        let (plain, first) = by_hand(&whole, loss, outcome.rank);
        let off = apart(&plain, &matrix(covariance.matrix.as_ref().unwrap()));
        assert!(off < 1e-6, "{loss:?}: {off:.1e}");
        for one in &covariance.clustered {
            assert_eq!((one.camera, one.images), (CameraId(1), 31));
            let off = apart(&first, &matrix(&one.matrix));
            assert!(off < 1e-6, "{loss:?}: clustered {off:.1e}");
            let own = plain.view((0, 0), (8, 8)).into_owned();
            let ratio = (own.try_inverse().unwrap() * &first).trace() / 8.0;
            assert!((one.ratio / ratio - 1.0).abs() < 1e-6, "{loss:?}: {} {ratio}", one.ratio);
            clusters += 1;
        }
    }
    assert_eq!(clusters, 4);
}

/// The plain covariance, and the clustered one of the first camera, which has eight parameters.
fn by_hand(whole: &Whole, loss: Loss, rank: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let count = whole.residual.len();
    let (mut weights, mut psi) = (DMatrix::zeros(count, count), DVector::zeros(count));
    for row in (0..count).step_by(2) {
        let (x, y) = (whole.residual[row], whole.residual[row + 1]);
        let rho = loss.at(x * x + y * y);
        // d psi / d r = rho' 1 + 2 rho'' r r^T; where that is nothing along r, a thousandth of rho' is kept.
        let (square, own) = (x * x + y * y, rho.slope);
        let along = 1.0 + 2.0 * square * rho.curvature / own;
        let along = if along.abs() > 1e-3 { along } else { 1e-3 };
        let both = own * (along - 1.0) / square;
        weights[(row, row)] = own + both * x * x;
        weights[(row + 1, row + 1)] = own + both * y * y;
        weights[(row, row + 1)] = both * x * y;
        weights[(row + 1, row)] = both * x * y;
        (psi[row], psi[row + 1]) = (own * x, own * y);
    }
    let own = whole.intrinsics.clone();
    let rest = whole.jacobian.clone().remove_columns(own.start, own.len());
    let own = whole.jacobian.columns(own.start, own.len()).into_owned();
    let projected = |weights: Option<&DMatrix<f64>>| {
        let weighed = |columns: &DMatrix<f64>| weights.map_or(columns.clone(), |w| w * columns);
        let scale = DMatrix::from_diagonal(
            &rest.column_iter().map(|c| 1.0 / c.norm()).collect::<Vec<_>>().into(),
        );
        let rest = &rest * scale;
        let square = rest.transpose() * weighed(&rest);
        // The gauge is open.
        let inverse = square.pseudo_inverse(1e-11).unwrap();
        &own - &rest * (inverse * (rest.transpose() * weighed(&own)))
    };
    let efficient = projected(None);
    let lambda = own.transpose() * &efficient;
    let bent = own.transpose() * (&weights * projected(Some(&weights)));
    let bread = bent.try_inverse().unwrap();
    let variance = psi.norm_squared() / (count - rank) as f64;
    let plain = &bread * lambda * &bread * variance;
    // What points leave of independent noise; two rows are an observation.
    let points = whole.jacobian.columns_range(whole.intrinsics.end..).into_owned();
    let square = (points.transpose() * &points).try_inverse().unwrap();
    let left = DMatrix::identity(count, count) - &points * square * points.transpose();
    let moved = efficient * bread.columns(0, 8);
    let unit = plain.view((0, 0), (8, 8)).into_owned().try_inverse().unwrap() * variance;
    let mut images: BTreeMap<ImageId, (DVector<f64>, DMatrix<f64>)> = BTreeMap::new();
    for row in (0..count).step_by(2) {
        let none = || (DVector::zeros(8), DMatrix::zeros(8, 8));
        let (score, share) = images.entry(whole.image[row]).or_insert_with(none);
        let own = moved.rows(row, 2);
        *score += own.transpose() * psi.rows(row, 2);
        *share += own.transpose() * left.view((row, row), (2, 2)) * own;
    }
    let shares = || images.values().map(|(_, share)| &unit * share);
    let kept = shares().map(|share| share.trace()).sum::<f64>() / 8.0;
    let equal = shares().map(|share| (&share * &share).trace()).sum::<f64>() / (8.0 * kept * kept);
    let middle: DMatrix<f64> = images.values().map(|(score, _)| score * score.transpose()).sum();
    let absorbed = left.trace() / (count - rank) as f64;
    (plain, middle * absorbed / (kept * (1.0 - equal)))
}

#[test]
fn no_covariance_depends_on_the_gauge() {
    let scene = two_cameras();
    for loss in LOSSES {
        let options = free(Mode::SelfCalibration, loss);
        let (_, optimum) = adjust_to_optimum(scene.clone(), &options, &mut |_| {}).unwrap();
        let of_gauge = |held: &[usize]| {
            let mut problem = optimum.problem.clone();
            problem.layout.held[..problem.layout.poses].fill(false);
            held.iter().for_each(|&unknown| problem.layout.held[unknown] = true);
            determined(&problem, &options, (&optimum.state, 1.0, None), optimum.free.clone())
        };
        let baseline = |image: usize| 6 * image + 3;
        let one = of_gauge(&[0, 1, 2, 3, 4, 5, baseline(17)]);
        let other = of_gauge(&[48, 49, 50, 51, 52, 53, baseline(2) + 1]);
        let [a, b] = [&one, &other].map(|it| it.covariance.as_ref().unwrap());
        let plain = [a, b].map(|it| matrix(it.matrix.as_ref().unwrap()));
        let off = apart(&plain[0], &plain[1]);
        assert!(off < 1e-8, "{loss:?}: {off:.1e}");
        let clustered = [a, b].map(|it| matrix(&it.clustered[0].matrix));
        let off = apart(&clustered[0], &clustered[1]);
        assert!(off < 1e-8, "{loss:?}: clustered {off:.1e}");
    }
    // Where none is held, the seven that are open are found.
    let options = free(Mode::SelfCalibration, Loss::Squared);
    let (adjusted, optimum) = adjust_to_optimum(scene, &options, &mut |_| {}).unwrap();
    let mut loose = optimum.problem.clone();
    loose.layout.held[..loose.layout.poses].fill(false);
    let loose = determined(&loose, &options, (&optimum.state, 1.0, None), optimum.free.clone());
    let Outcome { rank, unknowns, .. } = adjusted.outcome;
    assert_eq!((loose.rank, loose.unknowns), (rank, unknowns + 7));
}

#[test]
fn the_last_step_leaves_what_an_elimination_afresh_gives() {
    let options = free(Mode::SelfCalibration, Loss::Squared);
    let problem = Problem::new(&two_cameras(), &options).unwrap();
    let mut watch = |_: &Trial| ();
    let mut solver = Solver::new(&problem, &options, &mut watch);
    let end = least_squares::minimize(&mut solver, problem.start.clone(), &options.stop).unwrap();
    let mut known = solver.into_known(&end.state).unwrap();
    let mut solver = Solver::new(&problem, &options, &mut watch);
    let (afresh, nullity) = solver.information(&end.state);
    let Known { information, system, .. } = &mut known;
    assert_eq!((&information.rows, &information.scales), (&afresh.rows, &afresh.scales));
    let right = (0..problem.layout.size).map(|at| (at as f64).sin()).collect::<Vec<f64>>();
    let [mut one, mut other] = [vec![right.clone()], vec![right]];
    system.more_answers(&mut one);
    solver.answers(&end.state, &mut other);
    assert_eq!((one, known.nullity), (other, nullity));
    // That of a damped step is not the observations' own, nor that of another state theirs.
    let leaves = |damping: f64, state: &State| {
        let mut watch = |_: &Trial| ();
        let mut solver = Solver::new(&problem, &options, &mut watch);
        solver.linearize(&problem.start);
        assert!(solver.solve(damping).is_some());
        if !std::ptr::eq(state, &problem.start) {
            solver.linearize(state);
        }
        solver.into_known(state).is_some()
    };
    assert!(leaves(0.0, &problem.start));
    assert!(!leaves(1e-3, &problem.start) && !leaves(0.0, &end.state));
}
