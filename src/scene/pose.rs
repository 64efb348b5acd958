//! Poses as transforms: composed, and back to numbers.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::{Geometry, ImageId, Pose, SensorId, SensorKind};

impl Pose {
    /// The transform, its quaternion made one of unit length; none when that has no length.
    pub fn to_isometry(&self) -> Option<Isometry3<f64>> {
        let [w, x, y, z] = self.quaternion;
        let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), f64::MIN_POSITIVE)?;
        Some(Isometry3::from_parts(Translation3::from(self.translation), rotation))
    }
}

impl From<Isometry3<f64>> for Pose {
    fn from(transform: Isometry3<f64>) -> Self {
        let turn = transform.rotation;
        Self {
            quaternion: [turn.w, turn.i, turn.j, turn.k],
            translation: transform.translation.vector.into(),
        }
    }
}

impl Geometry {
    /// The pose of every image, cam_from_world, in the order of the images: by rig and frame where there are frames. None
    /// where a quaternion has no length or a sensor no pose.
    pub fn poses(&self) -> Vec<Option<Isometry3<f64>>> {
        let by_frame = self.poses_by_frame();
        let pose = |(id, image): (&ImageId, &super::Image)| match &by_frame {
            Some(poses) => poses.get(id).copied().flatten(),
            None => image.cam_from_world.to_isometry(),
        };
        self.images.iter().map(pose).collect()
    }

    fn poses_by_frame(
        &self,
    ) -> Option<std::collections::BTreeMap<ImageId, Option<Isometry3<f64>>>> {
        let mounting = self.mounting.as_ref()?;
        let mut poses = std::collections::BTreeMap::new();
        for frame in mounting.frames.values() {
            let rig_from_world = frame.rig_from_world.to_isometry();
            for &(sensor, datum) in &frame.data {
                let Some(id) = image_id(sensor, datum) else { continue };
                let rig = &mounting.rigs[&frame.rig];
                let sensor_from_rig = if rig.reference == Some(sensor) {
                    Some(Isometry3::identity())
                } else {
                    rig.sensors.get(&sensor).copied().flatten().and_then(|pose| pose.to_isometry())
                };
                poses.insert(id, sensor_from_rig.zip(rig_from_world).map(|(s, r)| s * r));
            }
        }
        Some(poses)
    }
}

/// The image that a datum of a frame is; none when another kind of sensor recorded it.
fn image_id(sensor: SensorId, datum: u64) -> Option<ImageId> {
    (sensor.kind == SensorKind::Camera).then(|| datum.try_into().ok().map(ImageId)).flatten()
}
