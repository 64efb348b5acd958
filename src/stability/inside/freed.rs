//! Which parameters of a camera could be freed, and in which model: the smallest that contains the camera's own.

use nalgebra::Vector3;

use super::held::HeldClass;
use crate::bundle::CameraOutcome;
use crate::camera::{Intrinsics, MODELS, Model, Param, ParamClass};
use crate::convert::{Contained, contained};

/// A camera in a model in which a class of parameters can be freed.
#[derive(Debug, Clone)]
pub(super) struct Freeing {
    pub contained: Contained,
    /// The places of the parameters that are freed.
    pub freed: Vec<usize>,
}

/// How a class can be freed; none where nothing of it is held, or no model has more.
pub(super) fn freeing(camera: &CameraOutcome, class: HeldClass, own_only: bool) -> Option<Freeing> {
    let own = camera.after.intrinsics.model();
    let [width, height] = [camera.after.width, camera.after.height].map(u32::try_from);
    let size = [width.ok()?, height.ok()?];
    let mut models: Vec<&'static Model> = vec![own];
    if !own_only {
        let mut wider: Vec<&Model> =
            MODELS.iter().filter(|model| model.params.len() > own.params.len()).collect();
        wider.sort_by_key(|model| model.params.len());
        models.extend(wider);
    }
    models.into_iter().find_map(|model| {
        let freed = freed(camera, class, model)?;
        let contained = contained(&camera.after.intrinsics, size, model)?;
        Some(Freeing { contained, freed })
    })
}

/// What of the class this model could free.
fn freed(camera: &CameraOutcome, class: HeldClass, model: &'static Model) -> Option<Vec<usize>> {
    let own = camera.after.intrinsics.model();
    let is_moving = |param: &Param| {
        let mut moving = camera.free.iter().chain(&camera.at_bound).map(|&at| &own.params[at]);
        moving.any(|other| (other.class, other.shared_name) == (param.class, param.shared_name))
    };
    let places = |of: ParamClass| {
        let params = model.params.iter().enumerate();
        params.filter(move |(_, param)| param.class == of).map(|(place, _)| place)
    };
    let freed: Vec<usize> = match class {
        HeldClass::PrincipalPoint => {
            places(ParamClass::PrincipalPoint).filter(|&at| !is_moving(&model.params[at])).collect()
        }
        HeldClass::OneFocal => {
            let is_one = |&&at: &&usize| own.params[at].class == ParamClass::Focal;
            let count = own.params.iter().filter(|param| param.class == ParamClass::Focal).count();
            let moves = camera.free.iter().find(is_one).is_some() && count == 1;
            // The first follows the one that there was, and the second what is more.
            places(ParamClass::Focal).skip(1).filter(|_| moves).collect()
        }
        HeldClass::NextRadial => {
            let radial = places(ParamClass::Extra)
                .filter_map(|at| Some((radial_order(&model.params[at])?, at)))
                .filter(|(_, at)| !is_moving(&model.params[*at]));
            // A radial term that own model has and was held, else the first that it lacks.
            radial.min().map(|(_, at)| at).into_iter().collect()
        }
    };
    (!freed.is_empty()).then_some(freed)
}

/// The number of a radial term, of those that go by k and a number.
fn radial_order(param: &Param) -> Option<u32> {
    param.shared_name.strip_prefix('k')?.parse().ok()
}

/// How a pixel changes with each parameter, by x and by y; none where the point is not seen.
pub(super) fn derivatives(camera: &Intrinsics, point: &Vector3<f64>) -> Option<[Vec<f64>; 2]> {
    let seen = camera.linearize(point)?;
    let count = camera.params().len();
    Some([0, 1].map(|axis| seen.wrt_params.row(axis).iter().take(count).copied().collect()))
}
