//! Some images of a scene, and what they see: a scene of its own.

use std::collections::BTreeSet;

use super::{
    Geometry, ImageId, Keypoint, Keypoints, Mounting, Point3D, Point3DId, Points3D, Scene,
    SensorKind, TrackElement,
};

impl Scene {
    /// The scene of some of its images. Points that fewer than two of them see are left out, frames without any of them too; all
    /// cameras and rigs stay. The points' stored errors are means over tracks that may be shorter now: they are not known.
    pub fn with_images(&self, kept: &BTreeSet<ImageId>) -> Self {
        let geometry = self.geometry.as_ref().map(|geometry| geometry.with_images(kept));
        Self { cameras: self.cameras.clone(), geometry }
    }
}

impl Geometry {
    fn with_images(&self, kept: &BTreeSet<ImageId>) -> Self {
        const UNKNOWN: f64 = -1.0;
        let mut points = Points3D::default();
        let mut seen: BTreeSet<Point3DId> = BTreeSet::new();
        for point in self.points.iter() {
            let track: Vec<TrackElement> =
                point.track.filter(|element| kept.contains(&element.image)).collect();
            if track.iter().any(|element| element.image != track[0].image) {
                seen.insert(point.id);
                let Point3D { id, xyz, rgb, .. } = point;
                points.push(Point3D { id, xyz, rgb, error_px: UNKNOWN, track });
            }
        }
        let mut images = self.images.clone();
        images.retain(|id, _| kept.contains(id));
        for image in images.values_mut() {
            let mut keypoints = Keypoints::default();
            for Keypoint { xy, point } in image.keypoints.iter() {
                keypoints.push(Keypoint { xy, point: point.filter(|id| seen.contains(id)) });
            }
            image.keypoints = keypoints;
        }
        let mounting = self.mounting.as_ref().map(|mounting| mounting.with_images(kept));
        Self { images, points, mounting }
    }
}

impl Mounting {
    fn with_images(&self, kept: &BTreeSet<ImageId>) -> Self {
        let is_kept = |datum: u64| u32::try_from(datum).is_ok_and(|id| kept.contains(&ImageId(id)));
        let mut frames = self.frames.clone();
        frames.retain(|_, frame| {
            let is_image = |kind| kind == SensorKind::Camera;
            frame.data.retain(|&(sensor, datum)| !is_image(sensor.kind) || is_kept(datum));
            frame.data.iter().any(|(sensor, _)| is_image(sensor.kind))
        });
        Self { rigs: self.rigs.clone(), frames }
    }
}
