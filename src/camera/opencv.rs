//! `OPENCV`: pinhole, two focal lengths, two radial and two tangential terms.
//! Numbers five to eight are k1 k2 p1 p2; `OPENCV_FISHEYE` has k1 to k4 there.

use super::param::{focal, principal_point, polynomial};
use super::{CameraModel, Param, OpenCv};

impl CameraModel<8> for OpenCv {
    const NAME: &str = "OPENCV";
    const COLMAP_ID: Option<i32> = Some(4);
    const PARAMS: [Param; 8] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), polynomial("k1"), polynomial("k2"), polynomial("p1"), polynomial("p2")];
}
