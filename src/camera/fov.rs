//! `FOV`: field-of-view model of Devernay and Faugeras; omega in radians.

use super::param::{focal, principal_point, extra};
use super::{CameraModel, Param, Fov};

impl CameraModel<5> for Fov {
    const NAME: &str = "FOV";
    const COLMAP_ID: Option<i32> = Some(7);
    const PARAMS: [Param; 5] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), extra("omega").in_unit("rad")];
}
