//! What each file of a model holds, field by field, in the order in which COLMAP writes it.

use std::collections::BTreeMap;
use std::io;

use super::sink::{Head, Sink};
use crate::scene::{
    Camera, CameraId, Frame, FrameId, Image, ImageId, Points3D, Rig, RigId, SensorId,
};

/// The records of one file.
pub trait Records {
    /// What stands above them.
    const HEAD: Head;
    /// Writes all of them.
    fn write(&self, sink: &mut impl Sink) -> io::Result<()>;
}

impl Records for BTreeMap<CameraId, Camera> {
    const HEAD: Head = Head {
        kind: "cameras",
        comment: &[
            "Camera list with one line of data per camera:",
            "  CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]",
        ],
        records: "cameras",
        mean: None,
    };

    fn write(&self, sink: &mut impl Sink) -> io::Result<()> {
        sink.head(&Self::HEAD, self.len(), 0)?;
        for (id, camera) in self {
            sink.u32(id.0);
            sink.model(camera.intrinsics.model())?;
            sink.u64(camera.width);
            sink.u64(camera.height);
            sink.f64s(camera.intrinsics.params())?;
            sink.end_record()?;
        }
        Ok(())
    }
}

impl Records for BTreeMap<ImageId, Image> {
    const HEAD: Head = Head {
        kind: "images",
        comment: &[
            "Image list with two lines of data per image:",
            "  IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME",
            "  POINTS2D[] as (X, Y, POINT3D_ID)",
        ],
        records: "images",
        mean: Some("observations per image"),
    };

    fn write(&self, sink: &mut impl Sink) -> io::Result<()> {
        let keypoints = self.values().flat_map(|image| image.keypoints.iter());
        let seen = keypoints.filter(|keypoint| keypoint.point.is_some()).count();
        sink.head(&Self::HEAD, self.len(), seen)?;
        for (id, image) in self {
            sink.u32(id.0);
            sink.pose(&image.cam_from_world)?;
            sink.u32(image.camera.0);
            sink.name(&image.name);
            sink.second_line(image.keypoints.len())?;
            for keypoint in image.keypoints.iter() {
                sink.f64s(&keypoint.xy)?;
                sink.point(keypoint.point);
            }
            sink.end_record()?;
        }
        Ok(())
    }
}

impl Records for Points3D {
    const HEAD: Head = Head {
        kind: "points3D",
        comment: &[
            "3D point list with one line of data per point:",
            "  POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)",
        ],
        records: "points",
        mean: Some("track length"),
    };

    fn write(&self, sink: &mut impl Sink) -> io::Result<()> {
        sink.head(&Self::HEAD, self.len(), self.observation_count())?;
        for point in self.iter() {
            sink.u64(point.id.0);
            sink.f64s(&point.xyz)?;
            point.rgb.iter().for_each(|&part| sink.u8(part));
            sink.f64(point.error_px)?;
            sink.list(point.track.len());
            for seen in point.track {
                sink.u32(seen.image.0);
                sink.u32(seen.keypoint);
            }
            sink.end_record()?;
        }
        Ok(())
    }
}

impl Records for BTreeMap<RigId, Rig> {
    const HEAD: Head = Head {
        kind: "rigs",
        comment: &[
            "Rig calib list with one line of data per calib:",
            "  RIG_ID, NUM_SENSORS, REF_SENSOR_TYPE, REF_SENSOR_ID, SENSORS[] as (SENSOR_TYPE, SENSOR_ID, HAS_POSE, \
             [QW, QX, QY, QZ, TX, TY, TZ])",
        ],
        records: "rigs",
        mean: None,
    };

    fn write(&self, sink: &mut impl Sink) -> io::Result<()> {
        sink.head(&Self::HEAD, self.len(), 0)?;
        for (id, rig) in self {
            sink.u32(id.0);
            sink.short_count(rig.sensors.len() + usize::from(rig.reference.is_some()))?;
            if let Some(reference) = rig.reference {
                sensor(reference, sink);
            }
            for (&other, sensor_from_rig) in &rig.sensors {
                sensor(other, sink);
                sink.u8(sensor_from_rig.is_some().into());
                if let Some(pose) = sensor_from_rig {
                    sink.pose(pose)?;
                }
            }
            sink.end_record()?;
        }
        Ok(())
    }
}

impl Records for BTreeMap<FrameId, Frame> {
    const HEAD: Head = Head {
        kind: "frames",
        comment: &[
            "Frame list with one line of data per frame:",
            "  FRAME_ID, RIG_ID, RIG_FROM_WORLD[QW, QX, QY, QZ, TX, TY, TZ], NUM_DATA_IDS, DATA_IDS[] as (SENSOR_TYPE, \
             SENSOR_ID, DATA_ID)",
        ],
        records: "frames",
        mean: None,
    };

    fn write(&self, sink: &mut impl Sink) -> io::Result<()> {
        sink.head(&Self::HEAD, self.len(), 0)?;
        for (id, frame) in self {
            sink.u32(id.0);
            sink.u32(frame.rig.0);
            sink.pose(&frame.rig_from_world)?;
            sink.short_count(frame.data.len())?;
            for &(by, datum) in &frame.data {
                sensor(by, sink);
                sink.u64(datum);
            }
            sink.end_record()?;
        }
        Ok(())
    }
}

fn sensor(sensor: SensorId, sink: &mut impl Sink) {
    sink.sensor_kind(sensor.kind);
    sink.u32(sensor.id);
}
