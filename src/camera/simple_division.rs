//! `SIMPLE_DIVISION`: one-parameter division model, one focal length.

use super::param::{focal, principal_point, extra};
use super::{CameraModel, Param, SimpleDivision};

impl CameraModel<4> for SimpleDivision {
    const NAME: &str = "SIMPLE_DIVISION";
    const COLMAP_ID: Option<i32> = Some(12);
    const PARAMS: [Param; 4] = [focal("f"), principal_point("cx"), principal_point("cy"), extra("k")];
}
