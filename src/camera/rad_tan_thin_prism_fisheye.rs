//! `RAD_TAN_THIN_PRISM_FISHEYE`: equidistant fisheye with six radial, two tangential and
//! four thin-prism terms (Project Aria's Fisheye624).

use super::param::{focal, principal_point, polynomial};
use super::{CameraModel, Param, RadTanThinPrismFisheye};

impl CameraModel<16> for RadTanThinPrismFisheye {
    const NAME: &str = "RAD_TAN_THIN_PRISM_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(11);
    const PARAMS: [Param; 16] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), polynomial("k0"), polynomial("k1"), polynomial("k2"), polynomial("k3"), polynomial("k4"), polynomial("k5"), polynomial("p0"), polynomial("p1"), polynomial("s0"), polynomial("s1"), polynomial("s2"), polynomial("s3")];
}
