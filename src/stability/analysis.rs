//! The result of an analysis, as plain data: everything that a report shows, and nothing about how it is shown.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::spread::{Region, Spread};
use super::{AsLeft, Refinement, RefinementOptions};
use super::{Clusters, HeldTest, Overlap, Residuals, Verdict};
use super::{Components, GroupComparison, Prediction};

/// The version of the shape below; grows when a reader of older files would go wrong.
pub const SCHEMA_VERSION: u32 = 1;

/// How repeatable the cameras of some runs are.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Analysis {
    /// The version of this shape.
    pub schema_version: u32,
    /// What was analysed, by what, and how.
    pub provenance: Provenance,
    /// Every camera of every group, by camera, model, image size and group; each begins with its verdict.
    pub populations: Vec<Population>,
    /// Every run that was read, by group and name.
    pub runs: Vec<RunRecord>,
    /// Runs that could not be read and were skipped on request.
    pub skipped: Vec<Skipped>,
    /// Every camera that several groups have: which group is the more stable, and whether the runs can tell.
    pub comparisons: Vec<GroupComparison>,
    /// Every camera that several groups have under one model: how much of its variance comes from the groups.
    pub components: Vec<Components>,
    /// What a reader must know before believing the numbers.
    pub findings: Vec<Finding>,
}

/// What was analysed, by what, and how.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Provenance {
    /// The calibstab that made the analysis.
    pub calibstab_version: String,
    /// Options that bear on the result.
    pub options: Options,
}

/// Options that bear on the result. The first three say how the runs were gathered and are kept for the record.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct Options {
    /// The pattern that told group and run from a path; none: the folders did.
    pub group_by: Option<String>,
    /// The table that listed the runs, if one did.
    pub manifest: Option<InputFile>,
    /// Runs that cannot be read are left out.
    pub skip_bad: bool,
    /// How cameras of different runs are matched; none: by the first rule that decides.
    pub match_by: Option<MatchRule>,
    /// The cameras of a group's runs are samples of one physical camera.
    pub pool: bool,
    /// Runs that are flagged do not enter the statistics.
    pub exclude_flagged: bool,
    /// Which part of the image the spread is over; none: what was observed, where there are images, else all of it.
    pub region: Option<Region>,
    /// How runs with images and points were refined; none: they were taken as COLMAP left them.
    pub refinement: Option<RefinementOptions>,
}

/// A rule by which cameras of different runs are taken for the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MatchRule {
    /// They took images of the same names, or of the same folder, or of names alike.
    Images,
    /// They have the same CAMERA_ID.
    Id,
    /// Each run has only one.
    Single,
}

/// One run that was read.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RunRecord {
    /// The group it belongs to.
    pub group: String,
    /// Its name within the group.
    pub run: String,
    /// The files it was read from.
    pub files: Vec<InputFile>,
    /// Images registered; none when only cameras were given.
    pub image_count: Option<usize>,
    /// Points triangulated; none when only cameras were given.
    pub point_count: Option<usize>,
    /// Observations of those points; none when only cameras were given.
    pub observation_count: Option<usize>,
    /// The run of the same group whose cameras are the same to the last bit; it counts, this one does not.
    pub duplicate_of: Option<String>,
    /// Why the run is suspect; empty when it is not. The findings of these kinds say more.
    pub flags: Vec<FindingId>,
    /// Whether it entered the statistics.
    pub is_used: bool,
    /// How refining it went; none when it was not tried.
    pub refinement: Option<Refinement>,
}

/// A file that was read.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct InputFile {
    /// Its path as it was found from the paths given.
    pub path: String,
    /// SHA-256 of its content, in hexadecimal.
    pub sha256: String,
}

/// A run that could not be read.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Skipped {
    /// Its path.
    pub path: String,
    /// Why it could not be read.
    pub reason: String,
}

/// One camera of one group, with one model and image size.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Population {
    /// The group.
    pub group: String,
    /// The physical camera.
    pub camera: String,
    /// Its camera model, under its name in a cameras.txt.
    pub model: String,
    /// Width of its images, in px.
    pub width: u64,
    /// Height of its images, in px.
    pub height: u64,
    /// What to make of it, before all numbers.
    pub verdict: Verdict,
    /// Share of the image, in cells of a grid of 60 columns, that has a ray in the mean camera: each parameter at the mean of
    /// its statistics, or of all its values where it has none. Only a mean beyond doubles has no share.
    pub ray_share: Option<f64>,
    /// Whether the lens of the mean camera folds inside the image; none where there is no mean, or no such image.
    pub folds: Option<bool>,
    /// Its parameters, in file order.
    pub parameters: Vec<Parameter>,
    /// How distortion went with the focal length across the runs.
    pub compensation: Vec<Compensation>,
    /// How all parameters went with each other across the runs.
    pub correlations: Correlations,
    /// How the adjustments say that parameters go with each other: by the mean of their covariances. None unless the population is
    /// refined and each of its samples has a covariance of the same parameters.
    pub predicted_correlations: Option<Correlations>,
    /// What the adjustments say of the spread; none where none has a covariance.
    pub prediction: Option<Prediction>,
    /// What freeing each class of held parameters would do; empty where nothing was refined with a squared loss.
    pub held: Vec<HeldTest>,
    /// What the adjustments left of the observations; none where nothing was refined with a squared loss, or too little was observed.
    pub residuals: Option<Residuals>,
    /// How far the calibrations disagree in the image; none with fewer than two.
    pub spread: Option<Spread>,
    /// Why two calibrations or more have no spread.
    pub without_spread: Option<String>,
    /// The parts that the runs fall into, with statistics of each; none when all agree.
    pub clusters: Option<Clusters>,
    /// What the runs share; none where a run has no images.
    pub overlap: Option<Overlap>,
    /// The same runs as COLMAP left them, where all else is about refined values; none where nothing was refined.
    pub as_left: Option<AsLeft>,
}

/// How the parameters went with each other across the runs.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct Correlations {
    /// The parameters that have statistics.
    pub parameters: Vec<String>,
    /// Pearson's correlation of any two, over the runs that estimated both; none with fewer than three or without variation.
    pub matrix: Vec<Vec<Option<f64>>>,
}

/// One parameter of one population.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Parameter {
    /// Its name in the camera model.
    pub name: String,
    /// What it does.
    pub class: ParameterClass,
    /// The unit of its values, such as `px`; empty where they have none.
    pub unit: String,
    /// One a run, in the order of the runs; with pooled cameras, one a camera of a run.
    pub samples: Vec<Sample>,
    /// Over the samples that were estimated; none with fewer than two of them.
    pub statistics: Option<Statistics>,
    /// The std that the adjustments predict: RMS of the samples' `predicted_std`. None unless all that were estimated have one.
    pub predicted_std: Option<f64>,
}

/// What a parameter does: COLMAP's classes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ParameterClass {
    /// A focal length, in px (FTHETA: px/rad).
    Focal,
    /// A coordinate of the principal point, in px.
    PrincipalPoint,
    /// Distortion and all else that is estimated.
    Extra,
    /// Part of the camera's description, never estimated.
    Metadata,
}

/// One parameter in one run.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Sample {
    /// The run.
    pub run: String,
    /// The camera's CAMERA_ID in that run; none when the run lacks the camera.
    pub camera_id: Option<u32>,
    /// What is known about how the value came about.
    pub state: SampleState,
    /// The value; none when the run lacks the camera, or refining it failed.
    pub value: Option<f64>,
    /// Its std by the covariance of the run's adjustment; none where it was not refined, or that has no covariance.
    pub predicted_std: Option<f64>,
    /// Whether it lies beyond the whiskers of the box plot.
    pub is_outlier: bool,
}

/// What is known about how a sample came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SampleState {
    /// It was estimated in this run.
    Estimated,
    /// Our own refinement held it.
    Held,
    /// It was not refined, as far as can be told: bit-equal between runs that differ otherwise, or a principal point
    /// exactly at the image centre in all of them.
    PresumedHeld,
    /// One run alone cannot tell.
    Unknown,
    /// The run did not reconstruct this camera, or refining it failed.
    Failed,
}

/// Statistics of the estimated samples of one parameter.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Statistics {
    /// How many samples.
    pub n: usize,
    /// Arithmetic mean.
    pub mean: f64,
    /// Sample standard deviation, with n - 1.
    pub std: f64,
    /// How far one std of this parameter alone moves the image: RMS in px, to first order, at the population's mean camera,
    /// over the cells of the whole image that have a ray there (its `ray_share`). None where none has.
    pub std_px: Option<f64>,
    /// std / |mean|, where the mean is far from zero.
    pub relative_std: Option<f64>,
    /// 95 % confidence interval of the standard deviation (chi-square: normal samples).
    pub std_interval_95: [f64; 2],
    /// Least sample.
    pub min: f64,
    /// First quartile, type 7 of Hyndman and Fan (numpy's default).
    pub q1: f64,
    /// Median.
    pub median: f64,
    /// Third quartile, type 7.
    pub q3: f64,
    /// Greatest sample.
    pub max: f64,
    /// 1.4826 times the median absolute deviation from the median.
    pub mad_std: f64,
    /// Furthest samples within 1.5 interquartile ranges of the quartiles.
    pub whiskers: [f64; 2],
}

/// How one distortion parameter went with one focal length across the runs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Compensation {
    /// Name of the focal length.
    pub focal: String,
    /// Name of the distortion parameter.
    pub distortion: String,
    /// How many runs estimated both.
    pub n: usize,
    /// Pearson's correlation over them; none with fewer than three or without variation.
    pub correlation: Option<f64>,
}

/// What a reader must know before believing the numbers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Finding {
    /// What kind of thing it is.
    pub id: FindingId,
    /// The group it is about; none: about all.
    pub group: Option<String>,
    /// The camera it is about; none: about all of the group.
    pub camera: Option<String>,
    /// The runs it is about; empty: about all of the group.
    pub runs: Vec<String>,
    /// The thing itself, in one sentence.
    pub text: String,
}

/// The kinds of finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, JsonSchema)]
#[schemars(rename_all = "kebab-case")]
pub enum FindingId {
    /// The observations leave a combination of the camera's parameters open.
    OpenDirection,
    /// No parameter of the camera was estimated.
    NoEstimate,
    /// One calibration, and nothing that says how well its run determines it.
    NotRepeated,
    /// Runs could not be read and were left out.
    SkippedRun,
    /// Runs have the same cameras to the last bit.
    DuplicateRuns,
    /// A run has a camera that no real lens could be.
    BogusCamera,
    /// A run registered far fewer images than its group.
    FewImages,
    /// A run lacks a camera that others have.
    MissingCamera,
    /// Some runs gave no calibration of a camera that they have.
    LostRuns,
    /// Refining a run or a camera of it came to nothing: it is no sample.
    RefinementFailed,
    /// A group stays as COLMAP left it, since not all of its runs have images and points.
    NotRefined,
    /// A camera took no image: its values are no estimates and do not enter.
    UnusedCamera,
    /// Cameras of one group differ in model or image size.
    MixedCameras,
    /// A run lies alone, far from all others, or has no ray where they have.
    OutlierRun,
    /// The runs fall into parts that disagree by more than chance.
    Clusters,
    /// The runs differ by more than their adjustments predict.
    Birge,
    /// Errors of one image depend on each other, and stds are not what they seem.
    ClusteredErrors,
    /// What was held wants to move, and moves the lens.
    HeldParameter,
    /// The residuals have a pattern over the image.
    ResidualPattern,
    /// Some points fit far worse than most.
    HeavyTails,
    /// The runs share nearly all of their observations.
    SharedObservations,
    /// Two calibrations or more could not be compared in the image.
    NoSpread,
    /// A parameter was held in some runs and estimated in others.
    MixedStates,
    /// Every image has a camera of its own.
    CameraPerImage,
    /// By which rule the cameras of different runs were matched.
    CameraMatch,
    /// How the runs were refined, and what did not take part.
    Refinement,
    /// Less of the image was compared than a calibration is for.
    SmallRegion,
    /// The lens of the mean camera folds inside the image.
    Fold,
    /// Part of the image has no ray in the mean camera of the runs, as its lens ends before.
    NoRay,
    /// What so few runs can tell.
    FewRuns,
    /// Something about how the files were read.
    Reading,
}

impl FindingId {
    /// Its name, as in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenDirection => "open-direction",
            Self::NoEstimate => "no-estimate",
            Self::NotRepeated => "not-repeated",
            Self::SkippedRun => "skipped-run",
            Self::DuplicateRuns => "duplicate-runs",
            Self::BogusCamera => "bogus-camera",
            Self::FewImages => "few-images",
            Self::MissingCamera => "missing-camera",
            Self::LostRuns => "lost-runs",
            Self::RefinementFailed => "refinement-failed",
            Self::NotRefined => "not-refined",
            Self::UnusedCamera => "unused-camera",
            Self::MixedCameras => "mixed-cameras",
            Self::OutlierRun => "outlier-run",
            Self::Clusters => "clusters",
            Self::Birge => "birge",
            Self::ClusteredErrors => "clustered-errors",
            Self::HeldParameter => "held-parameter",
            Self::ResidualPattern => "residual-pattern",
            Self::HeavyTails => "heavy-tails",
            Self::SharedObservations => "shared-observations",
            Self::NoSpread => "no-spread",
            Self::MixedStates => "mixed-states",
            Self::CameraPerImage => "camera-per-image",
            Self::CameraMatch => "camera-match",
            Self::Refinement => "refinement",
            Self::SmallRegion => "small-region",
            Self::Fold => "fold",
            Self::NoRay => "no-ray",
            Self::FewRuns => "few-runs",
            Self::Reading => "reading",
        }
    }
}

impl Serialize for FindingId {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_knows_findings_by_their_names() {
        let schema = serde_json::to_value(schemars::schema_for!(FindingId)).unwrap().to_string();
        for id in FindingId::all() {
            assert!(schema.contains(&format!("\"{}\"", id.name())), "{id:?} in {schema}");
        }
    }
}
