//! The one model of a command that works on one: COLMAP's, or a Bundle Adjustment in the Large problem.

use std::path::Path;

use super::failure::Failure;
use crate::scene::Scene;
use crate::{bal, colmap};
use colmap::Form;

/// What is at this path, in which form it would be written, and what the user should know of how it was read.
pub(super) fn read(path: &Path) -> Result<(Scene, Form, Vec<String>), Failure> {
    let failed = |error: &dyn std::error::Error| Failure::Input(error.to_string());
    if bal::is_problem(path) {
        let scene = bal::read(path).map_err(|error| failed(&error))?;
        return Ok((scene, Form::Text, Vec::new()));
    }
    let model = colmap::find_one(path).map_err(|error| failed(&error))?;
    let scene = model.read().map_err(|error| failed(&error))?;
    Ok((scene, model.form, model.remarks))
}
