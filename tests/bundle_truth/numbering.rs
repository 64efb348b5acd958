//! Ids are names: which they are, and in which order things stand, changes nothing.

use std::collections::BTreeMap;

use calibstab::bundle::Covariance;
use calibstab::camera::Model;
use calibstab::scene::{
    CameraId, Geometry, Image, ImageId, Keypoint, Keypoints, Point3D, Point3DId, Points3D, Scene,
    TrackElement,
};
use calibstab::synth;

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

#[test]
fn other_ids_in_another_order_change_no_intrinsic() {
    let camera = |name: &str| synth::camera(Model::named(name).unwrap(), 640, 480).unwrap();
    let options = synth::Options {
        cameras: vec![camera("OPENCV"), camera("OPENCV_FISHEYE"), camera("RADIAL")],
        image_count: 18,
        point_count: 600,
        most_per_image: 120,
        ..synth::Options::default()
    };
    let start = synth::make(&options).unwrap().run;
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
