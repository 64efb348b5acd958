//! `BAL_PINHOLE`: Bundle Adjustment in the Large with a full pinhole; looks along -Z.

use super::param::{focal, principal_point, polynomial};
use super::{CameraModel, Param, BalPinhole};

impl CameraModel<6> for BalPinhole {
    const NAME: &str = "BAL_PINHOLE";
    const COLMAP_ID: Option<i32> = None;
    const PARAMS: [Param; 6] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), polynomial("k1"), polynomial("k2")];
}
