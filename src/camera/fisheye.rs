//! `FISHEYE`: equidistant fisheye, two focal lengths.

use super::param::{focal, principal_point};
use super::{CameraModel, Param, Fisheye};

impl CameraModel<4> for Fisheye {
    const NAME: &str = "FISHEYE";
    const COLMAP_ID: Option<i32> = Some(15);
    const PARAMS: [Param; 4] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy")];
}
