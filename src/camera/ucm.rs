//! `UCM`: unified camera model.

use super::param::{focal, principal_point, extra};
use super::{CameraModel, Param, Ucm};

impl CameraModel<5> for Ucm {
    const NAME: &str = "UCM";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 5] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), extra("alpha")];
}
