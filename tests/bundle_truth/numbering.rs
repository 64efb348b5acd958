//! Ids are names: which they are, and in which order things stand, changes nothing.

use std::collections::BTreeMap;

use calibstab::bundle::{Covariance, Loss, Options};
use calibstab::camera::Model;
use calibstab::least_squares::Reason;
use calibstab::scene::{
    CameraId, Geometry, Image, ImageId, Keypoint, Keypoints, Point3D, Point3DId, Points3D, Scene,
    TrackElement,
};
use calibstab::synth;
use nalgebra::{DMatrix, Isometry3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::{adjust, all_free, largest};

fn camera_id(id: CameraId) -> CameraId {
    CameraId(100 - id.0)
}

fn image_id(id: ImageId) -> ImageId {
    ImageId(1000 - 7 * id.0)
}

fn point_id(id: Point3DId) -> Point3DId {
    Point3DId(1_000_000 - 3 * id.0)
}

/// Cameras, images and points under ids in the reverse order; points and tracks turned round.
fn renumbered(scene: &Scene) -> Scene {
    let cameras = scene.cameras.iter().map(|(&id, camera)| (camera_id(id), *camera)).collect();
    let geometry = scene.geometry.as_ref().unwrap();
    let image = |image: &Image| {
        let mut keypoints = Keypoints::default();
        for Keypoint { xy, point } in image.keypoints.iter() {
            keypoints.push(Keypoint { xy, point: point.map(point_id) });
        }
        Image { camera: camera_id(image.camera), keypoints, ..image.clone() }
    };
    let images: BTreeMap<_, _> =
        geometry.images.iter().map(|(&id, it)| (image_id(id), image(it))).collect();
    let mut points = Points3D::default();
    let all: Vec<_> = geometry.points.iter().collect();
    for Point3D { id, xyz, rgb, error_px, track } in all.into_iter().rev() {
        let element = |it: TrackElement| TrackElement { image: image_id(it.image), ..it };
        let mut track: Vec<_> = track.map(element).collect();
        track.reverse();
        points.push(Point3D { id: point_id(id), xyz, rgb, error_px, track });
    }
    Scene { cameras, geometry: Some(Geometry { images, points, mounting: None }) }
}

/// A run of three cameras, each with images enough to be clusters when there are so many.
fn run(image_count: u32, start_off: f64) -> Scene {
    let camera = |name: &str| synth::camera(Model::named(name).unwrap(), 640, 480).unwrap();
    let options = synth::Options {
        cameras: vec![camera("OPENCV"), camera("OPENCV_FISHEYE"), camera("RADIAL")],
        image_count,
        start_off,
        point_count: 600,
        most_per_image: 120,
        ..synth::Options::default()
    };
    synth::make(&options).unwrap().run
}

#[test]
fn other_ids_in_another_order_change_no_intrinsic() {
    let start = run(18, 0.02);
    let plain = adjust(&start, &all_free());
    let other = adjust(&renumbered(&start), &all_free());
    let covariance = plain.outcome.covariance.as_ref().unwrap();
    let of_other = other.outcome.covariance.as_ref().unwrap();
    let (stds, of_other_stds) = (covariance.stds().unwrap(), of_other.stds().unwrap());
    let apart = covariance.params.iter().zip(&stds).map(|(param, std)| {
        let id = camera_id(param.camera);
        let [one, two] = [(&plain, param.camera), (&other, id)]
            .map(|(of, id)| of.scene.cameras[&id].intrinsics.params()[param.place]);
        let at = |of: &Covariance| {
            of.params.iter().position(|p| (p.camera, p.place) == (id, param.place)).unwrap()
        };
        let ratio = of_other_stds[at(of_other)] / std;
        assert!((ratio - 1.0).abs() < 1e-7, "{param:?}: {ratio}");
        (one - two) / std
    });
    assert_eq!(stds.len(), 21);
    let apart = largest(apart);
    assert!(apart < 1e-6, "{apart:.1e}");
}

/// The scene in another place, turned, of another size.
fn transformed(scene: &Scene, scale: f64, turn: Vector3<f64>, shift: Vector3<f64>) -> Scene {
    let turn = UnitQuaternion::from_scaled_axis(turn);
    let mut moved = scene.clone();
    let geometry = moved.geometry.as_mut().unwrap();
    for image in geometry.images.values_mut() {
        let pose = image.cam_from_world.to_isometry().unwrap();
        let rotation = pose.rotation * turn.inverse();
        let translation = (pose.translation.vector - rotation * shift) * scale;
        image.cam_from_world = Isometry3::from_parts(translation.into(), rotation).into();
    }
    let mut points = Points3D::default();
    for point in geometry.points.iter() {
        let xyz = (turn * Vector3::from(point.xyz) + shift) * scale;
        points.push(Point3D { xyz: xyz.into(), ..point });
    }
    geometry.points = points;
    // Frames would overrule the images' poses.
    geometry.mounting = None;
    moved
}

/// Both covariances of each camera by the names that it had, in stds of the first scene's.
fn matrices(covariance: &Covariance, id: impl Fn(CameraId) -> CameraId) -> Vec<[DMatrix<f64>; 2]> {
    let matrix = covariance.matrix.as_ref().unwrap();
    let of_camera = |number: u32| {
        let camera = id(CameraId(number));
        let is_own = |&row: &usize| covariance.params[row].camera == camera;
        let rows: Vec<usize> = (0..matrix.len()).filter(is_own).collect();
        let clustered =
            &covariance.clustered.iter().find(|one| one.camera == camera).unwrap().matrix;
        let plain = |r: usize, c: usize| matrix[rows[r]][rows[c]];
        let size = rows.len();
        [DMatrix::from_fn(size, size, plain), DMatrix::from_fn(size, size, |r, c| clustered[r][c])]
    };
    [1, 2, 3].map(of_camera).to_vec()
}

fn assert_alike(one: &[[DMatrix<f64>; 2]], other: &[[DMatrix<f64>; 2]]) {
    for (one, other) in one.iter().zip(other) {
        let std = one[0].diagonal().map(f64::sqrt);
        for (kind, (one, other)) in one.iter().zip(other).enumerate() {
            let off = largest((0..one.len()).map(|at| {
                let (row, column) = (at % std.len(), at / std.len());
                (one[at] - other[at]) / (std[row] * std[column])
            }));
            // Both stop within 1e-6 std of the end.
            assert!(off < 1e-5, "kind {kind}: {off:.1e}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2))]
    #[test]
    fn no_covariance_depends_on_size_place_direction_or_numbers(
        power in -6.0..6.0_f64,
        turn in prop::array::uniform3(-3.0..3.0_f64),
        shift in prop::array::uniform3(-1e3..1e3_f64),
    ) {
        let start = run(96, 0.0);
        for loss in [Loss::Squared, Loss::Huber(0.7), Loss::SoftL1(0.7), Loss::Cauchy(1.0)] {
            let options = Options { loss, ..all_free() };
            let of = |scene: &Scene| {
                let outcome = adjust(scene, &options).outcome;
                assert!(
                    matches!(outcome.reason, Reason::Converged | Reason::Rounding),
                    "{loss:?}: {:?}",
                    outcome.reason
                );
                outcome.covariance.unwrap()
            };
            let plain = matrices(&of(&start), |id| id);
            let moved = transformed(&start, 10_f64.powf(power), turn.into(), shift.into());
            assert_alike(&plain, &matrices(&of(&moved), |id| id));
            assert_alike(&plain, &matrices(&of(&renumbered(&start)), camera_id));
        }
    }
}
