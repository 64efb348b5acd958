//! `SIMPLE_RADIAL`: pinhole, one focal length, one radial term.

use super::param::{focal, principal_point, polynomial};
use super::{CameraModel, Param, SimpleRadial};

impl CameraModel<4> for SimpleRadial {
    const NAME: &str = "SIMPLE_RADIAL";
    const COLMAP_ID: Option<i32> = Some(2);
    const PARAMS: [Param; 4] = [focal("f"), principal_point("cx"), principal_point("cy"), polynomial("k")];
}
