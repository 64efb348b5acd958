//! `calibstab models`.

use std::io::Write;

use clap::Args;

use super::failure::Failure;
use crate::camera::{MODELS, Model, ParamClass};

/// List the camera models: name, COLMAP's id, angle, parameters
#[derive(Args)]
pub(super) struct Models {}

const NOTES: &str = "
id     COLMAP's number; models without one are calibstab's own, COLMAP does not read them
angle  what the lens sees, from the optical axis; `calibstab inspect` says where the lens of a camera ends or folds
*      focal length   + principal point   = fixed description; the others are distortion
";

impl Models {
    pub(super) fn run(&self, out: &mut impl Write) -> Result<(), Failure> {
        let width = MODELS.iter().map(|model| model.name.len()).max().unwrap_or(0);
        writeln!(out, "{:<width$}  id  {:<21}  parameters, in file order", "model", "angle")?;
        for model in MODELS {
            let id = model.colmap_id.map_or("-".to_owned(), |id| id.to_string());
            let (angle, params) = (angle(model), params(model));
            writeln!(out, "{:<width$}  {id:>2}  {angle:<21}  {params}", model.name)?;
        }
        Ok(out.write_all(NOTES.as_bytes())?)
    }
}

/// What is known of the angle without the parameters.
fn angle(model: &Model) -> String {
    let widest = model.widest_angle.to_degrees();
    let plain: Vec<f64> = model.params.iter().map(|param| param.neutral).collect();
    let plain = model.with_params(&plain).map_or(0.0, |plain| plain.largest_angle());
    // Without distortion the lens is narrower than with some: its parameters decide.
    let is_fixed = plain > 0.999 * model.widest_angle;
    format!("{}below {widest:.0}°", if is_fixed { "" } else { "by params, " })
}

fn params(model: &Model) -> String {
    let shown = model.params.iter().map(|param| match param.class {
        ParamClass::Focal => format!("{}*", param.name),
        ParamClass::PrincipalPoint => format!("{}+", param.name),
        ParamClass::Extra => param.name.to_owned(),
        ParamClass::Metadata => format!("{}=", param.name),
    });
    shown.collect::<Vec<_>>().join(" ")
}
