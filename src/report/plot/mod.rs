//! Plots of an analysis or a comparison, as SVG and PNG in memory.
//!
//! Draws what the analysis carries and computes nothing but where it goes on the page. Same analysis, same bytes.

mod arrows;
mod axis;
mod boxes;
mod centres;
mod choice_boxes;
mod choices;
mod color;
mod columns;
mod contour;
mod correlations;
mod coverage;
mod deviation;
mod drawing;
mod font;
mod frame;
mod heat;
mod labels;
mod learning;
mod legend;
mod marker;
mod notes;
mod number;
mod page;
mod panels;
mod plane;
mod png;
mod profile;
mod ramp;
mod range;
mod render;
mod residual_map;
mod residual_profile;
#[cfg(test)]
mod residual_tests;
mod residuals;
mod runs;
mod scatter;
#[cfg(test)]
mod spread_tests;
mod spreads;
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

use crate::selection::experiment::Selection;
use crate::stability::{Analysis, ComparedCamera, Comparison};

use choices::Choices;
use drawing::Drawing;
use font::Font;
use residuals::ResidualMaps;
use spreads::Spreads;
use stem::Stems;
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
    /// How all parameters went with each other.
    Correlations,
    /// The spread over the image, and where the runs observed.
    Spread,
    /// The spread by distance from the image's centre.
    Profile,
    /// Where the run that is furthest off deviates.
    Deviation,
    /// Where the residuals of the runs lean to.
    Residuals,
    /// How far they lean outward and along the tangent, by distance from the principal point.
    ResidualProfile,
    /// The error of each heuristic by the number of images.
    Learning,
    /// From where the images were taken, and which of them each heuristic chose.
    Centres,
    /// Where in the image those chosen see something.
    Coverage,
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

const KINDS: [(FigureKind, Draw); 4] = [
    (FigureKind::Boxes, boxes::draw),
    (FigureKind::Runs, runs::draw),
    (FigureKind::Compensation, scatter::draw),
    (FigureKind::Correlations, correlations::draw),
];

type DrawSpreads = fn(&Spreads, &Font) -> Option<Drawing>;

const SPREAD_KINDS: [(FigureKind, DrawSpreads); 3] = [
    (FigureKind::Spread, heat::draw),
    (FigureKind::Profile, profile::draw),
    (FigureKind::Deviation, deviation::draw),
];

/// The figures of an analysis: for each camera, model and image size up to one of each kind, with all groups that have
/// it; maps of many groups go on in further figures. A camera whose parameters were all held has none.
pub fn figures(analysis: &Analysis) -> Result<Vec<Figure>, PlotError> {
    let font = Font::load()?;
    let mut stems = Stems::default();
    let mut figures = Vec::new();
    for subject in subject::subjects(analysis) {
        let Subject { camera, model, width, height, .. } = &subject;
        let stem = stems.of(&[(camera, "camera"), (model, "model")], [*width, *height]);
        for (kind, draw) in KINDS {
            let drawing = draw(&subject, &font);
            figures.extend(
                drawing.map(|drawing| Figure::new(kind, &stem, &subject.words(), drawing, &font)),
            );
        }
        figures.extend(spread_figures(&Spreads::of_subject(&subject, &font), &stem, &font));
        figures.extend(residual_figures(&ResidualMaps::new(&subject, &font), &stem, &font));
    }
    Ok(figures)
}

/// The figures of a comparison: of each camera, where two calibrations or more have a spread.
pub fn comparison_figures(comparison: &Comparison) -> Result<Vec<Figure>, PlotError> {
    let font = Font::load()?;
    let mut stems = Stems::default();
    let of_camera = |compared: &ComparedCamera| {
        let stem = stems.of(&[(&compared.camera, "camera")], [compared.width, compared.height]);
        spread_figures(&Spreads::of_compared(compared), &stem, &font)
    };
    Ok(comparison.cameras.iter().flat_map(of_camera).collect())
}

/// The figures of an experiment on heuristics: the error by size of all models; of each model, at each size, which images were
/// chosen, and of each camera its parameters, and where those images see something.
pub fn selection_figures(selection: &Selection) -> Result<Vec<Figure>, PlotError> {
    let font = Font::load()?;
    let figure = |kind, stem: &str, of: &str, drawing: Option<Drawing>| {
        drawing.map(|drawing| Figure::new(kind, stem, of, drawing, &font))
    };
    let learning = learning::draw(selection, &font);
    let mut figures: Vec<Figure> = Vec::new();
    figures.extend(figure(FigureKind::Learning, "heuristics", "all heuristics", learning));
    for choices in Choices::all(selection) {
        let (stem, model, size) = (choices.stem(), choices.of_model(), choices.size);
        let of = format!("{model}of {size}");
        figures.extend(figure(FigureKind::Centres, &stem, &of, centres::draw(&choices, &font)));
        for camera in &choices.model.cameras {
            let id = camera.camera_id;
            let (stem, of) =
                (format!("{stem}-camera-{id}"), format!("{model}camera {id}, of {size}"));
            let boxes = choice_boxes::draw(&choices, camera, &font);
            figures.extend(figure(FigureKind::Boxes, &stem, &of, boxes));
            let coverage = coverage::draw(&choices, camera, &font);
            figures.extend(figure(FigureKind::Coverage, &stem, &of, coverage));
        }
    }
    Ok(figures)
}

fn spread_figures(spreads: &Spreads, stem: &str, font: &Font) -> Vec<Figure> {
    let mut figures = Vec::new();
    for (kind, draw) in SPREAD_KINDS {
        let pages =
            if kind == FigureKind::Profile { vec![spreads.clone()] } else { spreads.pages() };
        for (number, page) in (1..).zip(&pages) {
            let Some(drawing) = draw(page, font) else { continue };
            let figure = Figure::new(kind, stem, &spreads.camera, drawing, font);
            figures.push(if number == 1 { figure } else { figure.continued(number) });
        }
    }
    figures
}

fn residual_figures(maps: &ResidualMaps, stem: &str, font: &Font) -> Vec<Figure> {
    let figure = |kind, drawing| Figure::new(kind, stem, &maps.camera, drawing, font);
    let mut figures = Vec::new();
    for (number, page) in (1..).zip(&maps.pages()) {
        let Some(drawing) = residual_map::draw(page, font) else { continue };
        let map = figure(FigureKind::Residuals, drawing);
        figures.push(if number == 1 { map } else { map.continued(number) });
    }
    let profile = residual_profile::draw(maps, font);
    figures.extend(profile.map(|drawing| figure(FigureKind::ResidualProfile, drawing)));
    figures
}

impl Figure {
    fn new(kind: FigureKind, stem: &str, of: &str, drawing: Drawing, font: &Font) -> Self {
        let title = format!("{}: {of}", kind.words());
        Self { kind, stem: format!("{stem}-{}", kind.name()), title, drawing, font: font.clone() }
    }

    /// The figure as one of a row that share a kind.
    fn continued(self, number: usize) -> Self {
        let (stem, title) =
            (format!("{}-{number}", self.stem), format!("{}, {number}", self.title));
        Self { stem, title, ..self }
    }

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
            Self::Correlations => "correlations",
            Self::Spread => "spread",
            Self::Profile => "profile",
            Self::Deviation => "deviation",
            Self::Residuals => "residuals",
            Self::ResidualProfile => "residual-profile",
            Self::Learning => "learning",
            Self::Centres => "centres",
            Self::Coverage => "coverage",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Boxes => "box plots of the parameters",
            Self::Runs => "parameters by run",
            Self::Compensation => "distortion against focal length",
            Self::Correlations => "correlations of the parameters",
            Self::Spread => "spread over the image",
            Self::Profile => "spread by distance from the centre",
            Self::Deviation => "deviation of the run furthest off",
            Self::Residuals => "mean residuals over the image",
            Self::ResidualProfile => "mean residuals by distance from the principal point",
            Self::Learning => "error by number of images",
            Self::Centres => "places of the images chosen",
            Self::Coverage => "coverage of the image plane",
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
