//! What the images of each camera of a run observed: where in the image, and how far away.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};

use super::spread::{View, observation_counts, observed_cells};
use crate::camera::Grid;
use crate::scene::{CameraId, Geometry, ImageId, Mounting, Pose, Scene, SensorId, SensorKind};
use crate::stats::Sorted;

/// What each camera of a scene observed; nothing when it is a lone list of cameras.
pub fn views(scene: &Scene) -> BTreeMap<CameraId, View> {
    let Some(geometry) = &scene.geometry else { return BTreeMap::new() };
    let places: HashMap<_, _> = geometry.points.iter().map(|point| (point.id, point.xyz)).collect();
    let poses = poses(geometry);
    let mut seen: BTreeMap<CameraId, (Vec<[f64; 2]>, Vec<f64>)> = BTreeMap::new();
    for (id, image) in &geometry.images {
        let (pixels, distances) = seen.entry(image.camera).or_default();
        for keypoint in image.keypoints.iter() {
            if let Some(place) = keypoint.point.and_then(|point| places.get(&point)) {
                pixels.push(keypoint.xy);
                distances.push((poses[id] * Point3::from(*place)).coords.norm());
            }
        }
    }
    let view = |(id, (pixels, distances)): (CameraId, (Vec<[f64; 2]>, Vec<f64>))| {
        let camera = scene.cameras.get(&id)?;
        let grid = Grid::new(camera.width, camera.height);
        let quantiles = Sorted::new(distances).map(|d| [0.1, 0.5, 0.9].map(|p| d.quantile(p)));
        let distances = quantiles.filter(|quantiles| quantiles[0] > 0.0);
        let observation_counts = observation_counts(&grid, pixels.into_iter());
        let observed_cells = observed_cells(&grid, &observation_counts);
        Some((id, View { observation_counts, observed_cells, distances }))
    };
    seen.into_iter().filter_map(view).collect()
}

/// From world to camera, of every image. With frames, what the image itself says does not count.
fn poses(geometry: &Geometry) -> BTreeMap<ImageId, Isometry3<f64>> {
    let own = geometry.images.iter().map(|(id, image)| (*id, isometry(&image.cam_from_world)));
    let mut poses: BTreeMap<ImageId, Isometry3<f64>> = own.collect();
    let Some(Mounting { rigs, frames }) = &geometry.mounting else { return poses };
    for frame in frames.values() {
        let Some(rig) = rigs.get(&frame.rig) else { continue };
        let sensor_from_rig = |sensor: &SensorId| match rig.sensors.get(sensor) {
            Some(pose) => pose.as_ref().map(isometry),
            None => (rig.reference == Some(*sensor)).then(Isometry3::identity),
        };
        for (sensor, data) in frame.data.iter().filter(|(s, _)| s.kind == SensorKind::Camera) {
            let image = u32::try_from(*data).ok().map(ImageId);
            let pose = image.and_then(|image| poses.get_mut(&image));
            if let (Some(pose), Some(sensor_from_rig)) = (pose, sensor_from_rig(sensor)) {
                *pose = sensor_from_rig * isometry(&frame.rig_from_world);
            }
        }
    }
    poses
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let [w, x, y, z] = pose.quaternion;
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(pose.translation), rotation)
}
