//! `EQUIRECTANGULAR`: the whole sphere; its width and height are never optimised.

use super::param::{metadata};
use super::{CameraModel, Param, Equirectangular};

impl CameraModel<2> for Equirectangular {
    const NAME: &str = "EQUIRECTANGULAR";
    const COLMAP_ID: Option<i32> = Some(17);
    const PARAMS: [Param; 2] = [metadata("w"), metadata("h")];
}
