//! `FTHETA`: r = k1 th + k2 th^2 + k3 th^3 + k4 th^4 in px.
//! k1, in px/rad, is its focal length.

use super::param::{focal, principal_point, extra};
use super::{CameraModel, Param, FTheta};

impl CameraModel<6> for FTheta {
    const NAME: &str = "FTHETA";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 6] = [principal_point("cx"), principal_point("cy"), focal("k1").in_unit("px/rad"), extra("k2").in_unit("px/rad²"), extra("k3").in_unit("px/rad³"), extra("k4").in_unit("px/rad⁴")];
}
