//! Which group's calibrations of a camera repeat better, and whether so few runs can tell.

mod compare;
#[cfg(test)]
mod tests;

pub(super) use compare::comparisons;

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;

/// How the groups that have one camera compare.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct GroupComparison {
    /// The physical camera. A group in which it shares one model with others takes part with that.
    pub camera: String,
    /// Width of its images, in px.
    pub width: u64,
    /// Height of its images, in px.
    pub height: u64,
    /// Share of the image that all runs of all groups see: the spreads are over that. None when they see no part in common.
    pub image_share: Option<f64>,
    /// The groups, that of the least spread first; those without one last.
    pub ranking: Vec<RankedGroup>,
    /// Every pair of groups with spreads, tested; p is corrected by Holm over these. Empty where the groups are too many.
    pub spreads: Vec<PairTest>,
    /// Every parameter of every pair of groups of one camera model, tested; p is corrected by Holm over all of these.
    pub parameters: Vec<ParameterTest>,
}

/// A group among those that have a camera.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RankedGroup {
    /// The group.
    pub group: String,
    /// What the camera is called there.
    pub camera: String,
    /// Its camera model there.
    pub model: String,
    /// How many calibrations.
    pub n: usize,
    /// How far their pixels spread: RMS over the image of the std, with n - 1, of the pixel that a ray meets, in px, after the
    /// group's cameras were rotated onto each other, as poses absorb a rotation. None with fewer than two calibrations.
    pub spread_px: Option<f64>,
    /// The same without rotating them, for the mean rays that they give a pixel.
    pub raw_spread_px: Option<f64>,
    /// 95 % confidence interval of it (chi-square: normal samples).
    pub spread_interval_95: Option<[f64; 2]>,
    /// Its degrees of freedom: n - 1 times the independent columns of the pixels' deviations (Box 1954).
    pub degrees: Option<f64>,
}

/// The test of one parameter.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ParameterTest {
    /// The parameter.
    pub parameter: String,
    /// Its std, compared.
    #[serde(flatten)]
    pub test: PairTest,
}

/// Two groups, compared by how far their calibrations vary.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PairTest {
    /// The groups, that of the greater std first.
    pub groups: [String; 2],
    /// Their camera models.
    pub models: [String; 2],
    /// How many samples each has.
    pub n: [usize; 2],
    /// Their std; of a spread in px.
    pub std: [f64; 2],
    /// The greater over the lesser.
    pub ratio: f64,
    /// The test: Brown and Forsythe's with ten samples or more in both groups, else F, for normal samples.
    pub method: TestMethod,
    /// What the test came to: an F.
    pub f: f64,
    /// Its degrees of freedom, numerator first.
    pub degrees: [f64; 2],
    /// How often groups that vary alike give so extreme an F.
    pub p: f64,
    /// The same, corrected for the number of tests (Holm 1979).
    pub p_holm: f64,
    /// How often the F test at 5 % finds a ratio of 2 with as many normal samples.
    pub power_at_2: f64,
    /// Samples in each group with which it would find a ratio of 2 in 80 % of cases.
    pub n_for_2: Option<usize>,
    /// Samples in each group with which it would find the ratio that was seen in 80 % of cases; none when ten thousand would not.
    pub n_for_ratio: Option<usize>,
}

/// A test of equal variances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TestMethod {
    /// F, two-sided: normal samples.
    F,
    /// Levene's test about the medians (Brown and Forsythe 1974): any samples.
    BrownForsythe,
}

/// The cameras of several groups that are one physical camera, or share a model with it: group and what it is called there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SameCamera {
    pub camera: String,
    pub members: BTreeSet<(String, String)>,
}
