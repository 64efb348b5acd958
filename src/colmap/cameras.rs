//! cameras.txt and cameras.bin: id, model, width, height, parameters.

use std::collections::BTreeMap;

use super::Why;
use super::source::{Fault, Listed, Records, Source};
use crate::camera::CameraError;
use crate::scene::{Camera, CameraId};

/// The records of a cameras file.
pub struct Cameras;

/// A camera of the model with the fewest parameters, two, takes 40 bytes.
const CAMERAS: Listed =
    Listed { name: "cameras", count: "count of cameras", fields: 1, min_bytes: 40 };

impl Records for Cameras {
    type Read = BTreeMap<CameraId, Camera>;

    fn read(self, source: &mut impl Source) -> Result<Self::Read, Fault> {
        let mut cameras = BTreeMap::new();
        while source.next_record(&CAMERAS)? {
            let field = "camera id";
            let id = CameraId(source.id(field)?);
            if cameras.contains_key(&id) {
                return Err(source.fault(Why::Duplicate { field, id: id.0.into() }));
            }
            cameras.insert(id, camera(source)?);
        }
        Ok(cameras)
    }
}

/// What follows a camera's id.
fn camera(source: &mut impl Source) -> Result<Camera, Fault> {
    let model = source.model()?;
    let model_at = source.mark();
    let not_a_camera = |error: CameraError| Fault::new(model_at, Why::Camera(error.into()));
    let (width, height) = (source.size("width")?, source.size("height")?);
    let (want, got) = (model.params.len(), source.param_count(model));
    if got != want {
        return Err(not_a_camera(CameraError::ParamCount { model: model.name, want, got }));
    }
    let params: Vec<f64> =
        model.params.iter().map(|param| source.f64(param.name)).collect::<Result<_, _>>()?;
    let intrinsics = model.with_params(&params).map_err(not_a_camera)?;
    Ok(Camera { intrinsics, width, height })
}
