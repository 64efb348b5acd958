//! `SIMPLE_FISHEYE`: equidistant fisheye, one focal length.

use super::param::{focal, principal_point};
use super::{CameraModel, Param, SimpleFisheye};

impl CameraModel<3> for SimpleFisheye {
    const NAME: &str = "SIMPLE_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(14);
    const PARAMS: [Param; 3] = [focal("f"), principal_point("cx"), principal_point("cy")];
}
