//! `calibstab inspect`.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::Vector2;

use super::failure::Failure;
use crate::camera::{Intrinsics, ParamClass};
use crate::colmap::{self, ModelFiles};
use crate::scene::{Camera, CameraId};

/// Say what cameras see: field of view, where the lens folds, pixels without a ray
#[derive(Args)]
pub(super) struct Inspect {
    /// A cameras file, a model folder, or a run folder with sparse or sparse/0; its cameras alone are read
    cameras: PathBuf,
}

const HALF_PIXEL: &str =
    "Pixels follow COLMAP: the first one's centre is (0.5, 0.5). For OpenCV, Kalibr and mrcal, where it is (0, 0), subtract 0.5
from cx and cy.
";

impl Inspect {
    pub(super) fn run(&self, out: &mut impl Write) -> Result<(), Failure> {
        for (id, camera) in read_cameras(&self.cameras)? {
            let Camera { intrinsics, width, height } = camera;
            writeln!(out, "camera {id}  {}  {width} x {height}", intrinsics.model().name)?;
            writeln!(out, "{}", params(&intrinsics))?;
            for line in seen(&intrinsics, size(id, &camera)?) {
                writeln!(out, "  {line}")?;
            }
            writeln!(out)?;
        }
        Ok(out.write_all(HALF_PIXEL.as_bytes())?)
    }
}

/// The cameras of the one model at this path, without its images.
pub(super) fn read_cameras(path: &Path) -> Result<BTreeMap<CameraId, Camera>, Failure> {
    let read = colmap::find_one(path)
        .and_then(|model| ModelFiles::lone_cameras(model.cameras, model.form).read());
    Ok(read.map_err(|error| Failure::Input(error.to_string()))?.cameras)
}

/// The size of a camera's images, as far as it is one of images that exist.
pub(super) fn size(id: CameraId, camera: &Camera) -> Result<[u32; 2], Failure> {
    let size = |side: u64| {
        let too_large =
            || Failure::Input(format!("camera {id}: no image is {side} px wide or high"));
        u32::try_from(side).map_err(|_| too_large())
    };
    Ok([size(camera.width)?, size(camera.height)?])
}

/// The parameters on a line of their own.
pub(super) fn params(intrinsics: &Intrinsics) -> String {
    let named = intrinsics.model().params.iter().zip(intrinsics.params());
    named.map(|(param, value)| format!("  {} {value}", param.name)).collect()
}

/// What there is to know of a camera, line by line.
fn seen(camera: &Intrinsics, [width, height]: [u32; 2]) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(view) = camera.field_of_view(width.into(), height.into()) {
        let [wide, high, diagonal] =
            [view.horizontal, view.vertical, view.diagonal].map(f64::to_degrees);
        // A map of all directions has no axis that a diagonal could be measured from.
        let is_map = camera.model().params.iter().any(|p| p.class == ParamClass::Metadata);
        let diagonal = if is_map { String::new() } else { format!(", {diagonal:.1}° diagonal") };
        lines.push(format!("field of view {wide:.1}° wide, {high:.1}° high{diagonal}"));
    }
    lines.push(fold(camera, [width, height]));
    let share = camera.share_without_ray(width, height);
    lines.push(match (share > 0.0, camera.folds_inside(width, height)) {
        (false, false) => "every pixel has a ray".to_owned(),
        (false, true) => {
            "WARNING: folds inside the image, between its outermost pixels' centres and its corners"
                .to_owned()
        }
        (true, true) => {
            format!("WARNING: folds inside the image, {} of the pixels have no ray", percent(share))
        }
        (true, false) => {
            format!("{} of the pixels have no ray: the lens ends before them", percent(share))
        }
    });
    if let Err(error) = camera.validate() {
        lines.push(format!("WARNING: {error}"));
    }
    lines
}

/// Up to which angle the lens sees, and at which radius it folds.
fn fold(camera: &Intrinsics, [width, height]: [u32; 2]) -> String {
    let angle = camera.largest_angle().to_degrees();
    let Ok(centre) = camera.project(&camera.optical_axis()) else {
        return format!("sees up to {angle:.1}° from the optical axis");
    };
    let (right, bottom) = (f64::from(width), f64::from(height));
    let corners =
        [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)].map(|(x, y)| Vector2::new(x, y));
    let sides = [Vector2::x(), -Vector2::x(), Vector2::y(), -Vector2::y()];
    let folds = corners.iter().map(|corner| corner - centre).chain(sides);
    let radius = folds.filter_map(|towards| camera.fold_radius_px(&towards)).reduce(f64::min);
    let farthest = corners.iter().map(|corner| (corner - centre).norm()).fold(0.0, f64::max);
    // Where even the widest lens ends, that is no fold, however the pixel runs there.
    let is_widest = camera.largest_angle() > 0.999 * camera.model().widest_angle;
    match radius.filter(|radius| !is_widest || *radius < farthest) {
        None => format!("does not fold; sees up to {angle:.1}° from the optical axis"),
        Some(radius) => format!(
            "folds {angle:.1}° from the optical axis, {radius:.1} px from the principal point; the farthest corner is at {farthest:.1} px"
        ),
    }
}

/// A share of pixels, of which one in a million may be the news.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 0.1 { format!("{percent:.1} %") } else { format!("{percent:.4} %") }
}
