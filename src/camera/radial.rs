//! `RADIAL`: pinhole, one focal length, two radial terms.

use super::param::{focal, principal_point, polynomial};
use super::{CameraModel, Param, Radial};

impl CameraModel<5> for Radial {
    const NAME: &str = "RADIAL";
    const COLMAP_ID: Option<i32> = Some(3);
    const PARAMS: [Param; 5] = [focal("f"), principal_point("cx"), principal_point("cy"), polynomial("k1"), polynomial("k2")];
}
