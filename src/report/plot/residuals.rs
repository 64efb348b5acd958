//! The residuals that one figure shows: a camera's, group by group.

use super::font::Font;
use super::labels::labels;
use super::marker::Style;
use super::notes::suspect;
use super::spreads::MOST_ON_A_PAGE;
use super::subject::{Member, Subject};
use crate::stability::Residuals;

/// Of normal means, 95 % are within so many standard errors of zero.
pub const REACH_95: f64 = 1.96;

/// A camera's mean residuals.
#[derive(Clone)]
pub struct ResidualMaps<'a> {
    /// The camera, in words.
    pub camera: String,
    /// Width and height of its images, in px.
    pub size: [u64; 2],
    pub members: Vec<ResidualsOf<'a>>,
    /// Which runs the figure leaves out, or are suspect.
    pub runs_in_words: Vec<String>,
}

/// Those of one group.
#[derive(Clone)]
pub struct ResidualsOf<'a> {
    /// The group; empty where there is only one without a name.
    pub label: String,
    pub style: Style,
    pub residuals: &'a Residuals,
}

impl<'a> ResidualMaps<'a> {
    pub fn new(subject: &Subject<'a>, font: &Font) -> Self {
        let of = |(member, label): (&Member<'a>, String)| {
            let residuals = member.population.residuals.as_ref()?;
            Some(ResidualsOf { label, style: member.style, residuals })
        };
        Self {
            camera: subject.words(),
            size: [subject.width, subject.height],
            members: subject.members.iter().zip(labels(subject, font)).filter_map(of).collect(),
            runs_in_words: suspect(subject),
        }
    }

    /// The same, so many groups at a time as a page holds.
    pub fn pages(&self) -> Vec<Self> {
        let page = |members: &[ResidualsOf<'a>]| Self { members: members.to_vec(), ..self.clone() };
        self.members.chunks(MOST_ON_A_PAGE).map(page).collect()
    }
}
