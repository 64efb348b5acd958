//! What adjustments say of their stds if the errors of one image depend on each other, and when that is more than chance.

use schemars::JsonSchema;
use serde::Serialize;

use super::super::inside::MOST_P;
use super::super::remarks::{listed, of_camera};
use super::super::verdict::basis::{refined_camera, samples};
use super::super::{Finding, FindingId, Population, RunRecord, SampleState};
use crate::bundle::Clustered;
use crate::stats::{Sorted, std_interval_factors_of_degrees};

/// A covariance with the images of a camera as clusters, beside the plain one, which takes each observation's error for
/// independent.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ClusteredCovariance {
    /// How many images: the clusters.
    pub images: usize,
    /// The covariance: rows and columns as of the plain one.
    pub covariance: Vec<Vec<f64>>,
    /// The mean ratio of its variances to the plain ones, over all combinations of parameters.
    pub ratio: f64,
    /// 99.9 % of the adjustments whose errors do not depend on each other have a ratio between these.
    pub null_interval: [f64; 2],
}

impl ClusteredCovariance {
    /// With the interval that the ratio's degrees of freedom give; none where they give none.
    pub fn new(clustered: &Clustered) -> Option<Self> {
        let [low, high] = std_interval_factors_of_degrees(clustered.degrees, 1.0 - MOST_P)?;
        Some(Self {
            images: clustered.images,
            covariance: clustered.matrix.clone(),
            ratio: clustered.ratio,
            null_interval: [high.powi(-2), low.powi(-2)],
        })
    }

    /// Whether the ratio is more than chance, or less.
    pub fn stands_out(&self) -> bool {
        let [low, high] = self.null_interval;
        !(low..=high).contains(&self.ratio)
    }
}

/// A camera of which at least half of the runs have a ratio outside of its interval, on the same side. However much the runs
/// share, chance does that in no more than 0.2 % of all cases.
pub(in crate::stability) fn of_population(one: &Population, runs: &[RunRecord]) -> Option<Finding> {
    // What did not converge tells nothing.
    let told: Vec<(&str, &ClusteredCovariance)> = samples(one)
        .filter(|sample| sample.state != SampleState::Failed)
        .filter_map(|sample| {
            let camera = refined_camera(sample, &one.group, runs)?;
            Some((sample.run.as_str(), camera.clustered.as_ref()?))
        })
        .collect();
    let outside = |is_side: fn(f64) -> bool| {
        let mut outside = told.clone();
        outside.retain(|(_, one)| one.stands_out() && is_side(one.ratio));
        (2 * outside.len() >= told.len() && !outside.is_empty()).then_some(outside)
    };
    let outside = outside(|ratio| ratio > 1.0).or_else(|| outside(|ratio| ratio < 1.0))?;
    let ratio = Sorted::new(outside.iter().map(|(_, one)| one.ratio).collect())?.median();
    let names: Vec<String> = outside.iter().map(|(run, _)| (*run).to_owned()).collect();
    let [low, high] = outside[0].1.null_interval;
    let text = format!(
        "{}: in {} errors of one image depend on each other: with images as clusters the adjustments' stds are {:.2} times the plain \
         ones (median), where chance leaves them between {:.2} and {:.2}",
        one.camera,
        listed(&names),
        ratio.sqrt(),
        low.sqrt(),
        high.sqrt(),
    );
    Some(of_camera(FindingId::ClusteredErrors, one, names, text))
}
