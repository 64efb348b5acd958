//! `BAL_STRICT`: Bundle Adjustment in the Large as published; looks along -Z.

use super::param::{focal, polynomial};
use super::{CameraModel, Param, BalStrict};

impl CameraModel<3> for BalStrict {
    const NAME: &str = "BAL_STRICT";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 3] = [focal("f"), polynomial("k1"), polynomial("k2")];
}
