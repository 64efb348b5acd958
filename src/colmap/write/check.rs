//! What a form cannot hold, and what COLMAP will not read back, found before any file is made.

use std::collections::BTreeMap;

use super::super::Form;
use super::WriteError;
use crate::scene::{CameraId, Geometry, Image, ImageId, Mounting, Pose, Scene};

/// Refuses what would not come back, and remarks on what would not come back through COLMAP.
pub fn check(scene: &Scene, form: Form) -> Result<Vec<String>, WriteError> {
    let mut remarks = own_models(scene, form)?;
    for (id, camera) in &scene.cameras {
        finite(camera.intrinsics.params(), || format!("camera {id}"))?;
    }
    if let Some(geometry) = &scene.geometry {
        for (&id, image) in &geometry.images {
            hold_name(id, image, form)?;
        }
        every_number_is_finite(geometry)?;
        if form == Form::Text {
            remarks.extend(names_with_blanks(geometry));
            remarks.extend(large_point_ids(geometry));
        }
    }
    Ok(remarks)
}

/// One remark a model, however many cameras have it.
fn own_models(scene: &Scene, form: Form) -> Result<Vec<String>, WriteError> {
    let mut own: BTreeMap<&str, Vec<CameraId>> = BTreeMap::new();
    for (&camera, found) in &scene.cameras {
        let model = found.intrinsics.model();
        match (model.colmap_id, form) {
            (Some(_), _) => {}
            (None, Form::Binary) => {
                return Err(WriteError::NoModelId { camera, model: model.name });
            }
            (None, Form::Text) => own.entry(model.name).or_default().push(camera),
        }
    }
    let remark = |(model, cameras): (&str, Vec<CameraId>)| {
        let whose = match cameras.as_slice() {
            [camera] => format!("camera {camera}"),
            [first, others @ ..] => format!("camera {first} and {} more", others.len()),
            [] => return None,
        };
        Some(format!("{whose}: {model} is calibstab's own, COLMAP will not read this model"))
    };
    Ok(own.into_iter().filter_map(remark).collect())
}

/// Whether the name comes back: in text it is all that is left of a line, in binary all before a zero byte.
fn hold_name(image: ImageId, found: &Image, form: Form) -> Result<(), WriteError> {
    let name = &found.name;
    let why = match form {
        Form::Text if name.is_empty() => "is empty",
        Form::Text if name.contains('\n') => "holds a line end",
        Form::Text if name.trim_ascii() != name => "begins or ends with a blank",
        Form::Binary if name.contains('\0') => "holds a zero byte",
        Form::Text | Form::Binary => return Ok(()),
    };
    Err(WriteError::Name { image, name: name.clone(), form, why })
}

fn names_with_blanks(geometry: &Geometry) -> Option<String> {
    /// What C++ takes for the end of a word.
    const BLANKS: [char; 5] = [' ', '\t', '\r', '\u{b}', '\u{c}'];
    let mut cut =
        geometry.images.values().map(|image| &image.name).filter(|name| name.contains(BLANKS));
    let first = cut.next()?.escape_debug();
    let others = match cut.count() {
        0 => String::new(),
        count => format!(" and {count} more"),
    };
    Some(format!("COLMAP reads names only up to the first blank: `{first}`{others}"))
}

/// COLMAP reads a keypoint's point as a signed number.
fn large_point_ids(geometry: &Geometry) -> Option<String> {
    let large = geometry.points.iter().find(|point| i64::try_from(point.id.0).is_err())?;
    Some(format!("COLMAP reads no point id above {} from text: point {}", i64::MAX, large.id))
}

fn every_number_is_finite(geometry: &Geometry) -> Result<(), WriteError> {
    for (id, image) in &geometry.images {
        let what = || format!("image {id}");
        finite_pose(&image.cam_from_world, what)?;
        image.keypoints.iter().try_for_each(|keypoint| finite(&keypoint.xy, what))?;
    }
    for point in geometry.points.iter() {
        let [x, y, z] = point.xyz;
        finite(&[x, y, z, point.error_px], || format!("point {}", point.id))?;
    }
    let Some(Mounting { rigs, frames }) = &geometry.mounting else { return Ok(()) };
    for (id, rig) in rigs {
        let mut poses = rig.sensors.values().flatten();
        poses.try_for_each(|pose| finite_pose(pose, || format!("rig {id}")))?;
    }
    frames
        .iter()
        .try_for_each(|(id, frame)| finite_pose(&frame.rig_from_world, || format!("frame {id}")))
}

fn finite_pose(pose: &Pose, what: impl Fn() -> String) -> Result<(), WriteError> {
    finite(&pose.quaternion, &what)?;
    finite(&pose.translation, &what)
}

fn finite(values: &[f64], what: impl Fn() -> String) -> Result<(), WriteError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(WriteError::NotFinite { what: what(), value }),
        None => Ok(()),
    }
}
