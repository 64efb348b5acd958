//! Estimates and sightings as a scene, each camera a rig of its own.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

use super::Estimate;
use super::observe::{Sighting, Sightings};
use crate::scene::{
    CameraId, Frame, FrameId, Geometry, Image, ImageId, Keypoint, Keypoints, Mounting, Point3D,
    Point3DId, Points3D, Pose, Rig, RigId, Scene, SensorId, SensorKind, TrackElement,
};

/// The colour of all points: a middle grey.
const COLOUR: [u8; 3] = [128; 3];

/// What COLMAP writes for an error that was not computed.
pub(super) const NO_ERROR: f64 = -1.0;

impl Estimate {
    /// The scene in which these pixels are seen, its images named as if so many had been taken before.
    pub fn scene(&self, seen: &Sightings, earlier_images: u64) -> Scene {
        let cameras = (1..).map(CameraId).zip(self.cameras.iter().copied()).collect();
        let takers = (1..).take(self.cameras.len()).cycle();
        let images: BTreeMap<ImageId, Image> = (1..)
            .zip(takers.zip(self.poses.iter().zip(&seen.by_image)))
            .map(|(number, (camera, (pose, seen)))| {
                let name = format!("camera{camera}/{:05}.png", earlier_images + u64::from(number));
                let cam_from_world = as_pose(pose);
                let keypoints = keypoints(seen);
                let camera = CameraId(camera);
                (ImageId(number), Image { name, camera, cam_from_world, keypoints })
            })
            .collect();
        let mounting = Some(each_camera_a_rig(&images));
        let points = self.points_seen(seen);
        Scene { cameras, geometry: Some(Geometry { images, points, mounting }) }
    }

    fn points_seen(&self, seen: &Sightings) -> Points3D {
        let mut tracks: Vec<Vec<TrackElement>> = vec![Vec::new(); self.points.len()];
        let mut errors_px: Vec<Vec<f64>> = vec![Vec::new(); self.points.len()];
        for ((number, index), sightings) in (1..).map(ImageId).zip(0..).zip(&seen.by_image) {
            for (keypoint, &Sighting { point, pixel }) in (0..).zip(sightings) {
                tracks[point].push(TrackElement { image: number, keypoint });
                let projected = self.project(index, &self.points[point]);
                errors_px[point].extend(projected.map(|at| (at - pixel).norm()));
            }
        }
        let mut points = Points3D::default();
        for (index, place) in self.points.iter().enumerate() {
            let errors = &errors_px[index];
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            let error_px = if errors.is_empty() { NO_ERROR } else { mean };
            let (id, xyz, track) = (point_id(index), (*place).into(), &tracks[index]);
            points.push(Point3D { id, xyz, rgb: COLOUR, error_px, track });
        }
        points
    }
}

fn point_id(index: usize) -> Point3DId {
    Point3DId(index as u64 + 1)
}

fn keypoints(sightings: &[Sighting]) -> Keypoints {
    let mut keypoints = Keypoints::default();
    for &Sighting { point, pixel } in sightings {
        keypoints.push(Keypoint { xy: pixel.into(), point: Some(point_id(point)) });
    }
    keypoints
}

fn as_pose(pose: &Isometry3<f64>) -> Pose {
    let rotation = pose.rotation;
    let quaternion = [rotation.w, rotation.i, rotation.j, rotation.k];
    Pose { quaternion, translation: pose.translation.vector.into() }
}

/// What COLMAP makes of images without rigs: each camera is a rig, each image a frame.
fn each_camera_a_rig(images: &BTreeMap<ImageId, Image>) -> Mounting {
    let sensor = |camera: CameraId| SensorId { kind: SensorKind::Camera, id: camera.0 };
    let rig = |image: &Image| {
        let reference = Some(sensor(image.camera));
        (RigId(image.camera.0), Rig { reference, sensors: BTreeMap::new() })
    };
    let frame = |(&id, image): (&ImageId, &Image)| {
        let (rig, rig_from_world) = (RigId(image.camera.0), image.cam_from_world);
        let data = vec![(sensor(image.camera), id.0.into())];
        (FrameId(id.0), Frame { rig, rig_from_world, data })
    };
    Mounting {
        rigs: images.values().map(rig).collect(),
        frames: images.iter().map(frame).collect(),
    }
}
