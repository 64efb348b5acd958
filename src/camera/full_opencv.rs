//! `FULL_OPENCV`: `OPENCV` with a rational radial term.
//! Numerator and denominator trade freely, so its k are not small.

use super::param::{focal, principal_point, polynomial, extra};
use super::{CameraModel, Param, FullOpenCv};

impl CameraModel<12> for FullOpenCv {
    const NAME: &str = "FULL_OPENCV";
    const COLMAP_ID: Option<i32> = Some(6);
    const PARAMS: [Param; 12] = [focal("fx"), focal("fy"), principal_point("cx"), principal_point("cy"), extra("k1"), extra("k2"), polynomial("p1"), polynomial("p2"), extra("k3"), extra("k4"), extra("k5"), extra("k6")];
}
