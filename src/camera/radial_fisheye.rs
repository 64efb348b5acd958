//! `RADIAL_FISHEYE`: equidistant fisheye with two terms.

use super::param::{focal, principal_point, polynomial};
use super::{CameraModel, Param, RadialFisheye};

impl CameraModel<5> for RadialFisheye {
    const NAME: &str = "RADIAL_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(9);
    const PARAMS: [Param; 5] = [focal("f"), principal_point("cx"), principal_point("cy"), polynomial("k1"), polynomial("k2")];
}
