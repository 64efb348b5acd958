//! Plots of an analysis, as SVG and PNG in memory: three figures a camera.
//!
//! Draws what the analysis carries and computes nothing but where it goes on the page. Same analysis, same bytes.

mod axis;
mod boxes;
mod color;
mod columns;
mod drawing;
mod font;
mod frame;
mod labels;
mod legend;
mod marker;
mod notes;
mod number;
mod page;
mod png;
mod range;
mod render;
mod runs;
mod scatter;
mod stem;
mod subject;
mod svg;
#[cfg(test)]
pub(super) mod test_data;
#[cfg(test)]
mod test_svg;
#[cfg(test)]
mod tests;

use std::fmt;

use crate::stability::Analysis;

use drawing::Drawing;
use font::Font;
use subject::Subject;

/// One picture.
#[derive(Debug, Clone)]
pub struct Figure {
    /// What it shows.
    pub kind: FigureKind,
    /// A name for its file, without extension: safe on every file system, unique within the analysis.
    pub stem: String,
    /// What it shows, in one line for those who do not see it.
    pub title: String,
    drawing: Drawing,
    font: Font,
}

/// What a figure shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FigureKind {
    /// Each parameter's samples and quartiles, group beside group.
    Boxes,
    /// Each parameter against the position of the run in its group.
    Runs,
    /// Distortion against focal length.
    Compensation,
}

/// A figure that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The built-in font is no font: a fault of the build.
    #[error("the built-in font of the plots is damaged")]
    Font,
    /// The drawing library refused.
    #[error("SVG could not be drawn: {0}")]
    Svg(String),
    /// The drawing library or the encoder refused.
    #[error("PNG could not be drawn: {0}")]
    Png(String),
}

type Draw = fn(&Subject, &Font) -> Option<Drawing>;

const KINDS: [(FigureKind, Draw); 3] = [
    (FigureKind::Boxes, boxes::draw),
    (FigureKind::Runs, runs::draw),
    (FigureKind::Compensation, scatter::draw),
];

/// The figures of an analysis: for each camera, model and image size up to one of each kind, with all groups that have
/// it. A camera whose parameters were all held has none.
pub fn figures(analysis: &Analysis) -> Result<Vec<Figure>, PlotError> {
    let font = Font::load()?;
    let subjects = subject::subjects(analysis);
    let mut figures = Vec::new();
    for (subject, stem) in subjects.iter().zip(stem::stems(&subjects)) {
        for (kind, draw) in KINDS {
            let Some(drawing) = draw(subject, &font) else { continue };
            let title = format!("{}: {}", kind.words(), subject.words());
            let stem = format!("{stem}-{}", kind.name());
            figures.push(Figure { kind, stem, title, drawing, font: font.clone() });
        }
    }
    Ok(figures)
}

impl Figure {
    /// The figure as an SVG document.
    pub fn to_svg(&self) -> Result<String, PlotError> {
        svg::to_svg(&self.drawing, &self.font, &self.title)
    }

    /// The figure as a PNG file, two pixels to a CSS pixel of the SVG.
    pub fn to_png(&self) -> Result<Vec<u8>, PlotError> {
        png::to_png(&self.drawing, &self.font, &self.title)
    }
}

impl FigureKind {
    /// The last part of a figure's stem.
    pub fn name(self) -> &'static str {
        match self {
            Self::Boxes => "boxes",
            Self::Runs => "runs",
            Self::Compensation => "compensation",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Boxes => "box plots of the parameters",
            Self::Runs => "parameters by run",
            Self::Compensation => "distortion against focal length",
        }
    }
}

impl PlotError {
    fn svg(error: impl fmt::Display) -> Self {
        Self::Svg(error.to_string())
    }

    fn png(error: impl fmt::Display) -> Self {
        Self::Png(error.to_string())
    }
}
