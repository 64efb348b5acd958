//! `OPENCV_FISHEYE`: Kannala-Brandt: four terms in the angle from the axis.

use super::param::{focal, principal_point, polynomial};
use super::{CameraModel, Param, OpenCvFisheye};

impl CameraModel<8> for OpenCvFisheye {
    const NAME: &str = "OPENCV_FISHEYE";
    const COLMAP_ID: Option<i32> = Some(5);
    const PARAMS: [Param; 8] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), polynomial("k1"), polynomial("k2"), polynomial("k3"), polynomial("k4")];
}
