//! `SIMPLE_RADIAL_FISHEYE`: equidistant fisheye with one term.

use super::param::{focal, principal_point, polynomial};
use super::{CameraModel, Param, SimpleRadialFisheye};

impl CameraModel<4> for SimpleRadialFisheye {
    const NAME: &str = "SIMPLE_RADIAL_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(8);
    const PARAMS: [Param; 4] = [focal("f"), principal_point("cx"), principal_point("cy"), polynomial("k")];
}
