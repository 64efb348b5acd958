//! rigs and frames, text and binary: which sensors are fixed to each other, and what they recorded together.

use std::collections::BTreeMap;

use super::Why;
use super::source::{Fault, Listed, Records, Source};
use crate::scene::{
    Camera, CameraId, Frame, FrameId, Image, ImageId, Rig, RigId, SensorId, SensorKind,
};

/// The records of a rigs file.
pub struct Rigs<'a> {
    /// The cameras that may be mounted on them.
    pub cameras: &'a BTreeMap<CameraId, Camera>,
}

/// The records of a frames file.
pub struct Frames<'a> {
    /// The rigs that may have been exposed.
    pub rigs: &'a BTreeMap<RigId, Rig>,
    /// The images that may have come of it.
    pub images: &'a BTreeMap<ImageId, Image>,
}

/// A rig without sensors takes 8 bytes.
const RIGS: Listed = Listed { name: "rigs", count: "count of rigs", fields: 1, min_bytes: 8 };
/// A frame without data takes 68 bytes.
const FRAMES: Listed =
    Listed { name: "frames", count: "count of frames", fields: 1, min_bytes: 68 };

impl Records for Rigs<'_> {
    type Read = BTreeMap<RigId, Rig>;

    fn read(self, source: &mut impl Source) -> Result<Self::Read, Fault> {
        let mut rigs = BTreeMap::new();
        let mut rig_of = BTreeMap::new();
        while source.next_record(&RIGS)? {
            let field = "rig id";
            let id = RigId(source.id(field)?);
            if rigs.contains_key(&id) {
                return Err(source.fault(Why::Duplicate { field, id: id.0.into() }));
            }
            let rig = self.rig(source, |sensor| match rig_of.insert(sensor, id) {
                Some(first) if first == id => Err(Why::DuplicateSensor(sensor)),
                Some(first) => Err(Why::OnTwoRigs { sensor, first }),
                None => Ok(()),
            })?;
            rigs.insert(id, rig);
            source.end_record()?;
        }
        Ok(rigs)
    }
}

impl Rigs<'_> {
    /// What follows a rig's id; `take` is told of every sensor. The first one is the one whose coordinates the rig has.
    fn rig(
        &self,
        source: &mut impl Source,
        mut take: impl FnMut(SensorId) -> Result<(), Why>,
    ) -> Result<Rig, Fault> {
        let mut rig = Rig { reference: None, sensors: BTreeMap::new() };
        for index in 0..source.u32("count of sensors")? {
            let sensor = sensor(source)?;
            take(sensor).map_err(|why| source.fault(why))?;
            let camera = CameraId(sensor.id);
            if sensor.kind == SensorKind::Camera && !self.cameras.contains_key(&camera) {
                return Err(source.fault(Why::UnknownCamera(camera)));
            }
            if index == 0 {
                rig.reference = Some(sensor);
                continue;
            }
            let field = "pose flag";
            let sensor_from_rig = match source.u8(field)? {
                0 => None,
                1 => Some(source.pose()?),
                flag => {
                    let text = flag.to_string();
                    return Err(source.fault(Why::TooLarge { field, text, max: 1 }));
                }
            };
            rig.sensors.insert(sensor, sensor_from_rig);
        }
        Ok(rig)
    }
}

fn sensor(source: &mut impl Source) -> Result<SensorId, Fault> {
    Ok(SensorId { kind: source.sensor_kind()?, id: source.id("sensor id")? })
}

impl Records for Frames<'_> {
    type Read = BTreeMap<FrameId, Frame>;

    fn read(self, source: &mut impl Source) -> Result<Self::Read, Fault> {
        let mut frames = BTreeMap::new();
        let mut frame_of = BTreeMap::new();
        while source.next_record(&FRAMES)? {
            let field = "frame id";
            let id = FrameId(source.id(field)?);
            if frames.contains_key(&id) {
                return Err(source.fault(Why::Duplicate { field, id: id.0.into() }));
            }
            let frame = self.frame(source, |image| match frame_of.insert(image, id) {
                Some(first) => Err(Why::InTwoFrames { image, first }),
                None => Ok(()),
            })?;
            source.end_record()?;
            frames.insert(id, frame);
        }
        Ok(frames)
    }
}

impl Frames<'_> {
    /// What follows a frame's id; `take` is told of every image in it.
    fn frame(
        &self,
        source: &mut impl Source,
        mut take: impl FnMut(ImageId) -> Result<(), Why>,
    ) -> Result<Frame, Fault> {
        let rig = RigId(source.id("rig id")?);
        let Some(mounted) = self.rigs.get(&rig) else {
            return Err(source.fault(Why::UnknownRig(rig)));
        };
        let rig_from_world = source.pose()?;
        let mut data = Vec::new();
        for _ in 0..source.u32("count of data")? {
            let sensor = sensor(source)?;
            if mounted.reference != Some(sensor) && !mounted.sensors.contains_key(&sensor) {
                return Err(source.fault(Why::UnknownSensor { rig, sensor }));
            }
            let datum = source.u64("data id")?;
            if sensor.kind == SensorKind::Camera {
                let image = self.image(datum, CameraId(sensor.id));
                image.and_then(&mut take).map_err(|why| source.fault(why))?;
            }
            data.push((sensor, datum));
        }
        Ok(Frame { rig, rig_from_world, data })
    }

    /// The image that this camera took as this datum.
    fn image(&self, datum: u64, camera: CameraId) -> Result<ImageId, Why> {
        let id = u32::try_from(datum).map(ImageId);
        let known = id.ok().and_then(|id| self.images.get_key_value(&id));
        match known {
            Some((&id, image)) if image.camera == camera => Ok(id),
            Some((&image, found)) => Err(Why::OtherCamera { image, camera: found.camera }),
            None => Err(Why::UnknownImage(datum)),
        }
    }
}
