//! `DOUBLE_SPHERE`: double sphere model of Usenko, Demmel and Cremers.

use super::param::{focal, principal_point, extra};
use super::{CameraModel, Param, DoubleSphere};

impl CameraModel<6> for DoubleSphere {
    const NAME: &str = "DOUBLE_SPHERE";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 6] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), extra("xi"), extra("alpha")];
}
