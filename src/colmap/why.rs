//! Why a model could not be read: the reasons, without the place.

use std::fmt;

use crate::camera::CameraError;
use crate::scene::{CameraId, FrameId, ImageId, Point3DId, RigId, SensorId, SensorKind};

/// Why a model could not be read. Text from the file comes clipped and without control characters.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // what a reason is, its message says
pub enum Why {
    // A field that is not there, or not what it should be.
    #[error("the line ends before its {0}")]
    Missing(&'static str),
    #[error("the file ends within the {0}")]
    Truncated(&'static str),
    #[error("{field} is `{text}`, not a number")]
    NotANumber { field: &'static str, text: String },
    #[error("{field} is `{text}`, not a whole number")]
    NotWhole { field: &'static str, text: String },
    #[error("{field} is {text}, not a finite number")]
    NotFinite { field: &'static str, text: String },
    #[error("{field} is {text}, below 0")]
    Negative { field: &'static str, text: String },
    #[error("{field} is {text}, above {max}")]
    TooLarge { field: &'static str, text: String, max: u64 },
    #[error("{field} is {value}, by which COLMAP means none")]
    Reserved { field: &'static str, value: u64 },
    #[error("{0} is 0, expected at least 1")]
    Zero(&'static str),
    #[error("the quaternion is 0 0 0 0, which is no rotation")]
    NoRotation,
    #[error("sensor type is `{0}`, expected CAMERA (in binary 0) or IMU (1)")]
    SensorKind(String),
    #[error("{0}")]
    Camera(Box<CameraError>),
    #[error("the {0} is not valid UTF-8")]
    NotUtf8(&'static str),
    #[error("the {0} has no end")]
    Unterminated(&'static str),

    // Too much, or too little.
    #[error("the file is UTF-16, expected UTF-8")]
    Utf16,
    #[error("unexpected `{0}` after the last field")]
    TrailingText(String),
    #[error("{0} more bytes after the last record")]
    TrailingBytes(usize),
    #[error(
        "the file ends before the second line of image {0}, which may be empty but must be there"
    )]
    NoSecondLine(ImageId),
    #[error("the {items} have {fields} fields, expected a multiple of {each}")]
    Uneven { items: &'static str, fields: usize, each: usize },
    #[error("{count} {items} are announced, more than the {left} bytes that are left can hold")]
    CountTooLarge { items: &'static str, count: u64, left: usize },
    #[error("there is no camera in the file")]
    NoCamera,

    // Something that exists twice, or not at all.
    #[error("{field} {id} comes twice")]
    Duplicate { field: &'static str, id: u64 },
    #[error("another image has the name `{0}`")]
    DuplicateName(String),
    #[error("{} comes twice", Sensor(*.0))]
    DuplicateSensor(SensorId),
    #[error("there is no camera {0}")]
    UnknownCamera(CameraId),
    #[error("there is no image {0}")]
    UnknownImage(u64),
    #[error("there is no point {0}")]
    UnknownPoint(Point3DId),
    #[error("there is no rig {0}")]
    UnknownRig(RigId),
    #[error("rig {rig} has no {}", Sensor(*.sensor))]
    UnknownSensor { rig: RigId, sensor: SensorId },
    #[error("image {image} has no keypoint {keypoint}: it has {count}, counted from 0")]
    UnknownKeypoint { image: ImageId, keypoint: u32, count: usize },

    // Two places that contradict each other.
    #[error("keypoint {keypoint} of image {image} belongs to {}", Owner(*.owner))]
    NotItsKeypoint { image: ImageId, keypoint: u32, owner: Option<Point3DId> },
    #[error("keypoint {keypoint} of image {image} comes twice in the track")]
    SeenTwice { image: ImageId, keypoint: u32 },
    #[error("the track of point {0} does not name this keypoint")]
    NotInTrack(Point3DId),
    #[error("{} is already on rig {first}", Sensor(*.sensor))]
    OnTwoRigs { sensor: SensorId, first: RigId },
    #[error("image {image} was taken by camera {camera}")]
    OtherCamera { image: ImageId, camera: CameraId },
    #[error("image {image} is already in frame {first}")]
    InTwoFrames { image: ImageId, first: FrameId },
    #[error("image {0} is in no frame")]
    InNoFrame(ImageId),
}

/// How a sensor is called.
struct Sensor(SensorId);

impl fmt::Display for Sensor {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.0.kind {
            SensorKind::Camera => write!(f, "camera {}", self.0.id),
            SensorKind::Imu => write!(f, "IMU {}", self.0.id),
        }
    }
}

/// Whose a keypoint is.
struct Owner(Option<Point3DId>);

impl fmt::Display for Owner {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.0 {
            Some(point) => write!(f, "point {point}"),
            None => f.write_str("no point"),
        }
    }
}
