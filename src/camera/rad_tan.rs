//! `RADTAN`: `OPENCV` with a third radial term (ROS's plumb_bob).

use super::param::{focal, principal_point, polynomial};
use super::{CameraModel, Param, RadTan};

impl CameraModel<9> for RadTan {
    const NAME: &str = "RADTAN";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 9] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), polynomial("k1"), polynomial("k2"), polynomial("p1"), polynomial("p2"), polynomial("k3")];
}
