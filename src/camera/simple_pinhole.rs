//! `SIMPLE_PINHOLE`: pinhole, one focal length.

use super::param::{focal, principal_point};
use super::{CameraModel, Param, SimplePinhole};

impl CameraModel<3> for SimplePinhole {
    const NAME: &str = "SIMPLE_PINHOLE";
    const COLMAP_ID: Option<i32> = Some(0);
    const PARAMS: [Param; 3] = [focal("f"), principal_point("cx"), principal_point("cy")];
}
