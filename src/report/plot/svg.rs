//! A drawing as SVG: text stays text, and a title says to a screen reader what is seen.

use plotters::backend::{DrawingBackend, SVGBackend};

use super::PlotError;
use super::drawing::Drawing;
use super::font::Font;
use super::render::{View, render};

/// Units of the SVG in a CSS pixel: plotters counts in whole units, and dots placed in whole pixels look uneven.
const SCALE: u32 = 10;

pub fn to_svg(drawing: &Drawing, font: &Font, title: &str) -> Result<String, PlotError> {
    let mut body = String::new();
    let mut backend = SVGBackend::with_string(&mut body, (0, 0));
    let view = View { scale: SCALE, rows: [0.0, drawing.height] };
    render(drawing, font, view, &mut backend).map_err(PlotError::svg)?;
    backend.present().map_err(PlotError::svg)?;
    drop(backend);
    // plotters gives a picture one size: ours has one for the page and a finer one for its coordinates.
    let shapes = body.split_once('\n').map_or("", |(_head, shapes)| shapes);
    // What goes without saying is a tenth of a map.
    let shapes = shapes.replace(" opacity=\"1\"", "").replace(" \"/>", "\"/>");
    let (width, height) = (drawing.width, drawing.height);
    let (fine_width, fine_height) = (width * f64::from(SCALE), height * f64::from(SCALE));
    let title = escape(title);
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {fine_width} {fine_height}\" role=\"img\">\n<title>{title}</title>\n{shapes}"
    ))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
