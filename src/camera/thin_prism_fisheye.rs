//! `THIN_PRISM_FISHEYE`: equidistant fisheye with radial, tangential and thin-prism terms.

use super::param::{focal, principal_point, polynomial};
use super::{CameraModel, Param, ThinPrismFisheye};

impl CameraModel<12> for ThinPrismFisheye {
    const NAME: &str = "THIN_PRISM_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(10);
    const PARAMS: [Param; 12] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), polynomial("k1"), polynomial("k2"), polynomial("p1"), polynomial("p2"), polynomial("k3"), polynomial("k4"), polynomial("sx1"), polynomial("sy1")];
}
