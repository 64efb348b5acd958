//! Where in the image plane the images that each heuristic chose see something: a panel a heuristic.

use super::choices::Choices;
use super::drawing::{Drawing, Point};
use super::font::Font;
use super::page::{MARGIN, Page};
use super::panels::Panels;
use super::plane::Plane;
use super::ramp::{BAR_HEIGHT, Ramp};
use crate::selection::experiment::{CameraCell, CameraRecord, Cell};

const WIDTH: f64 = 240.0;

/// The figure of a camera; none where it saw nothing.
pub fn draw(choices: &Choices<'_>, camera: &CameraRecord, font: &Font) -> Option<Drawing> {
    let own = |cell: &'_ Cell| -> Option<(String, CameraCell)> {
        let of_camera = cell.cameras.iter().find(|it| it.camera_id == camera.camera_id)?;
        Some((cell.heuristic.clone(), of_camera.clone()))
    };
    let (captions, cells): (Vec<String>, Vec<CameraCell>) = choices.cells().filter_map(own).unzip();
    let most = cells.iter().flat_map(|cell| &cell.coverage).copied().reduce(f64::max);
    let ramp = Ramp::heat(most.filter(|most| *most > 0.0)?);
    let plane = Plane::new(font, [camera.width, camera.height], camera.parts, WIDTH);
    let CameraRecord { camera_id, model, .. } = camera;
    let panels = Panels {
        title: &format!(
            "{}camera {camera_id}, {model}: coverage of the image plane, {} at a time",
            choices.of_model(),
            choices.size
        ),
        subtitle: "How many of the images chosen see something in each part, mean over the repeats",
        captions: &captions,
        size: [plane.width, plane.height],
    };
    let panel = |page: &mut Page, at: usize, corner: Point| {
        let place = plane.placed(corner);
        let steps: Vec<(usize, usize)> =
            cells[at].coverage.iter().map(|count| ramp.step(*count)).enumerate().collect();
        place.cells(&mut page.drawing, &steps, |step| ramp.color(step));
        place.border(page);
    };
    let below = |page: &mut Page| {
        ramp.bar(page, ("images", ""), [MARGIN, page.y], WIDTH);
        page.y += BAR_HEIGHT + 8.0;
    };
    Some(panels.draw(font, panel, below, &[]))
}
