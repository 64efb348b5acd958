//! `PINHOLE`: pinhole, two focal lengths.

use super::param::{focal, principal_point};
use super::{CameraModel, Param, Pinhole};

impl CameraModel<4> for Pinhole {
    const NAME: &str = "PINHOLE";
    const COLMAP_ID: Option<i32> = Some(1);
    const PARAMS: [Param; 4] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy")];
}
