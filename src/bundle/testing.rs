//! Small scenes of known truth for the tests of this room.

use nalgebra::{Isometry3, Point3, Rotation3, UnitQuaternion, Vector3};

use crate::camera::{Intrinsics, Model};
use crate::scene::{
    Camera, CameraId, Geometry, Image, ImageId, Keypoint, Keypoints, Point3D, Point3DId, Points3D,
    Scene, TrackElement,
};

/// Numbers that look random and are the same everywhere: splitmix64.
pub(crate) struct Noise(pub u64);

impl Noise {
    /// Between -1 and 1.
    pub(crate) fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Of standard deviation one, nearly normal.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.even()).sum::<f64>() * 0.5
    }

    pub(crate) fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.even(), self.even(), self.even())
    }
}

pub(crate) fn camera(model: &str, params: &[f64]) -> Camera {
    let intrinsics = Model::named(model).unwrap().with_params(params).unwrap();
    Camera { intrinsics, width: 1280, height: 960 }
}

/// A scene with the truth in it, and what the images see of it with noise of so many px.
pub(crate) struct World {
    pub cameras: Vec<Camera>,
    pub poses: Vec<Isometry3<f64>>,
    pub points: Vec<Vector3<f64>>,
    pub noise_px: f64,
}

impl World {
    /// Cameras in turn, on a ring round a cloud of points, held at various rolls.
    pub(crate) fn ring(cameras: Vec<Camera>, images: u32, points: usize) -> Self {
        let mut noise = Noise(7);
        let poses = (0..images).map(|image| {
            let angle = f64::from(image) / f64::from(images) * std::f64::consts::TAU;
            let height = 1.5 * (3.0 * angle).sin() + 0.3 * noise.even();
            let eye = Point3::new(6.0 * angle.cos(), 6.0 * angle.sin(), height);
            let facing = Isometry3::look_at_rh(&eye, &Point3::from(noise.vector()), &Vector3::z());
            // Cameras look along +z here, and along -z there.
            let turn =
                Rotation3::from_euler_angles(std::f64::consts::PI, 0.0, 1.3 * f64::from(image));
            UnitQuaternion::from_rotation_matrix(&turn) * facing
        });
        let poses = poses.collect();
        let points = (0..points).map(|_| noise.vector() * 2.5).collect();
        Self { cameras, poses, points, noise_px: 0.0 }
    }

    pub(crate) fn with_noise(self, noise_px: f64) -> Self {
        Self { noise_px, ..self }
    }

    /// The scene at the truth: ids from 1, tracks by image; points that no image sees are left out.
    pub(crate) fn scene(&self) -> Scene {
        let mut noise = Noise(11);
        let mut keypoints = vec![Keypoints::default(); self.poses.len()];
        let mut points = Points3D::default();
        for (index, place) in self.points.iter().enumerate() {
            let id = Point3DId(index as u64 + 1);
            let mut track = Vec::new();
            for (image, pose) in self.poses.iter().enumerate() {
                let camera = self.camera_of(image);
                let seen = pose.transform_point(&Point3::from(*place)).coords;
                let Ok(pixel) = camera.intrinsics.project(&seen) else { continue };
                let inside = |value: f64, side: u64| value > 0.0 && value < side as f64;
                if inside(pixel.x, camera.width) && inside(pixel.y, camera.height) {
                    let xy = [pixel.x, pixel.y].map(|value| value + self.noise_px * noise.normal());
                    track.push(TrackElement {
                        image: ImageId(u32::try_from(image + 1).unwrap()),
                        keypoint: u32::try_from(keypoints[image].len()).unwrap(),
                    });
                    keypoints[image].push(Keypoint { xy, point: Some(id) });
                }
            }
            let xyz: [f64; 3] = (*place).into();
            if !track.is_empty() {
                points.push(Point3D { id, xyz, rgb: [0; 3], error_px: -1.0, track });
            }
        }
        let images = (1..).zip(self.poses.iter().zip(keypoints)).map(|(id, (pose, keypoints))| {
            let camera = CameraId((id - 1) % u32::try_from(self.cameras.len()).unwrap() + 1);
            let name = format!("{id}.jpg");
            (ImageId(id), Image { name, camera, cam_from_world: (*pose).into(), keypoints })
        });
        let cameras = (1..).zip(&self.cameras).map(|(id, camera)| (CameraId(id), *camera));
        let geometry = Geometry { images: images.collect(), points, mounting: None };
        Scene { cameras: cameras.collect(), geometry: Some(geometry) }
    }

    fn camera_of(&self, image: usize) -> &Camera {
        &self.cameras[image % self.cameras.len()]
    }
}

/// Moves poses and points off by noise of this size, and multiplies focal lengths.
pub(crate) fn disturbed(mut scene: Scene, size: f64, focal: f64) -> Scene {
    let mut noise = Noise(23);
    for camera in scene.cameras.values_mut() {
        let model = camera.intrinsics.model();
        let params: Vec<f64> =
            model
                .params
                .iter()
                .zip(camera.intrinsics.params())
                .map(|(p, value)| {
                    if p.class == crate::camera::ParamClass::Focal { value * focal } else { *value }
                })
                .collect();
        camera.intrinsics = model.with_params(&params).unwrap();
    }
    let geometry = scene.geometry.as_mut().unwrap();
    for image in geometry.images.values_mut() {
        let mut pose = image.cam_from_world.to_isometry().unwrap();
        pose.rotation = UnitQuaternion::from_scaled_axis(noise.vector() * size) * pose.rotation;
        pose.translation.vector += noise.vector() * size;
        image.cam_from_world = pose.into();
    }
    map_points(geometry, |xyz| xyz + noise.vector() * size);
    scene
}

/// Moves every point.
pub(crate) fn map_points(
    geometry: &mut Geometry,
    mut place: impl FnMut(Vector3<f64>) -> Vector3<f64>,
) {
    let mut points = Points3D::default();
    for point in geometry.points.iter() {
        points.push(Point3D { xyz: place(Vector3::from(point.xyz)).into(), ..point });
    }
    geometry.points = points;
}

/// The points in another order, under other ids, their tracks turned round.
pub(crate) fn reordered_points(geometry: &Geometry) -> Points3D {
    let mut kept: Vec<(Point3D<()>, Vec<TrackElement>)> = geometry
        .points
        .iter()
        .map(|p| {
            let Point3D { id, xyz, rgb, error_px, track } = p;
            (Point3D { id, xyz, rgb, error_px, track: () }, track.collect())
        })
        .collect();
    kept.reverse();
    kept.rotate_left(17);
    let mut points = Points3D::default();
    for (Point3D { id, xyz, rgb, error_px, .. }, mut track) in kept {
        track.reverse();
        points.push(Point3D { id, xyz, rgb, error_px, track });
    }
    points
}

/// The largest distance between the pixels of two lenses over the image, in px, where both have one.
pub(crate) fn displacement(one: &Intrinsics, other: &Intrinsics, camera: &Camera) -> f64 {
    let mut most: f64 = 0.0;
    let mut compared = 0;
    for (column, row) in (1..16).flat_map(|column| (1..12).map(move |row| (column, row))) {
        let pixel = nalgebra::Vector2::new(
            f64::from(column) / 16.0 * camera.width as f64,
            f64::from(row) / 12.0 * camera.height as f64,
        );
        if let Ok(ray) = one.unproject(&pixel)
            && let Ok(seen) = other.project(&ray)
        {
            most = most.max((seen - pixel).norm());
            compared += 1;
        }
    }
    assert!(compared > 60, "only {compared} pixels have a ray");
    most
}
