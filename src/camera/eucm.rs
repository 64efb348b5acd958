//! `EUCM`: enhanced unified camera model.

use super::param::{focal, principal_point, extra};
use super::{CameraModel, Param, Eucm};

impl CameraModel<6> for Eucm {
    const NAME: &str = "EUCM";
    const COLMAP_ID: Option<i32> = Some(16);
    const PARAMS: [Param; 6] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), extra("alpha"), extra("beta")];
}
