//! `DIVISION`: one-parameter division model, two focal lengths.

use super::param::{focal, principal_point, extra};
use super::{CameraModel, Param, Division};

impl CameraModel<5> for Division {
    const NAME: &str = "DIVISION";
    const COLMAP_ID: Option<i32> = Some(13);
    const PARAMS: [Param; 5] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), extra("k")];
}
