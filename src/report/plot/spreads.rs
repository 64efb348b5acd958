//! The spreads that one figure shows: a camera's, group by group.

use super::font::{Font, clean};
use super::labels::labels;
use super::marker::Style;
use super::notes::suspect;
use super::subject::Subject;
use crate::stability::spread::Spread;
use crate::stability::{ComparedCamera, PredictedSpread};

/// A page with more groups than this would be taller than anyone scrolls; they go on in another figure.
pub const MOST_ON_A_PAGE: usize = 4;

/// A camera's spreads.
#[derive(Clone)]
pub struct Spreads<'a> {
    /// The camera, in words.
    pub camera: String,
    /// Width and height of its images, in px.
    pub size: [u64; 2],
    pub members: Vec<SpreadOf<'a>>,
    /// Which runs the figure leaves out, or are suspect.
    pub runs_in_words: Vec<String>,
}

/// The spread of one group.
#[derive(Clone)]
pub struct SpreadOf<'a> {
    /// The group; empty where there is only one without a name.
    pub label: String,
    pub style: Style,
    pub spread: &'a Spread,
    /// What the adjustments predict of it.
    pub predicted: Option<&'a PredictedSpread>,
}

impl<'a> Spreads<'a> {
    pub fn of_subject(subject: &Subject<'a>, font: &Font) -> Self {
        let members = subject.members.iter().zip(labels(subject, font));
        let spread = |(member, label): (&super::subject::Member<'a>, String)| {
            let spread = member.population.spread.as_ref()?;
            let prediction = member.population.prediction.as_ref();
            let predicted = prediction.and_then(|prediction| prediction.spread.as_ref());
            Some(SpreadOf { label, style: member.style, spread, predicted })
        };
        Self {
            camera: subject.words(),
            size: [subject.width, subject.height],
            members: members.filter_map(spread).collect(),
            runs_in_words: suspect(subject),
        }
    }

    pub fn of_compared(camera: &'a ComparedCamera) -> Self {
        let ComparedCamera { width, height, spread, .. } = camera;
        let style = Style::of_group(0);
        let members = spread.iter();
        Self {
            camera: format!("{}, {width} × {height} px", clean(&camera.camera)),
            size: [*width, *height],
            members: members
                .map(|spread| SpreadOf { label: String::new(), style, spread, predicted: None })
                .collect(),
            runs_in_words: Vec::new(),
        }
    }

    /// The same, so many groups at a time as a page holds.
    pub fn pages(&self) -> Vec<Self> {
        let page = |members: &[SpreadOf<'a>]| Self { members: members.to_vec(), ..self.clone() };
        self.members.chunks(MOST_ON_A_PAGE).map(page).collect()
    }
}

impl SpreadOf<'_> {
    /// The group, how many runs, and over what.
    pub fn heading(&self) -> String {
        let Spread { n, region, cell_share, .. } = self.spread;
        let label = if self.label.is_empty() { String::new() } else { format!("{}: ", self.label) };
        format!("{label}{n} runs over {:.0} % of the image (region {region})", 100.0 * cell_share)
    }
}
