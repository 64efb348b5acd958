//! The shape of `selection.json`.

use schemars::JsonSchema;
use serde::Serialize;

use super::sample::Sample;
use crate::stability::{InputFile, Statistics};

/// What an experiment found: which heuristic chooses the images that calibrate best.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Selection {
    /// Version of this format; raised when a field changes its meaning or goes.
    pub schema_version: u32,
    /// The calibstab that made it.
    pub calibstab_version: String,
    /// What was asked for.
    pub options: SelectionOptions,
    /// The models.
    pub models: Vec<ModelRecord>,
    /// What to know of how it went.
    pub remarks: Vec<String>,
    /// The heuristics in order: over all models and sizes first, then at each size, then of each model where there are several.
    pub rankings: Vec<Ranking>,
    /// How many images each heuristic needs for the error that was asked for.
    pub targets: Vec<Target>,
    /// How far the models agree; none for one.
    pub agreement: Option<Agreement>,
    /// Each heuristic at each size of each model.
    pub cells: Vec<Cell>,
    /// All choices and what came of them.
    pub samples: Vec<ScoredSample>,
}

/// What an experiment was asked to do, in the words of the command line.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SelectionOptions {
    /// The heuristics, and what each does.
    pub heuristics: Vec<(String, String)>,
    /// How many images or frames were chosen.
    pub sizes: Vec<usize>,
    /// How often, of each model and at each size.
    pub repeats: usize,
    /// The seed.
    pub seed: u64,
    /// From which part of the images.
    pub pool: String,
    /// Whether each repeat had noise of its own (redraw) or all had the measured one (keep).
    pub noise: String,
    /// What was chosen at a time: image or frame.
    pub unit: String,
    /// The camera that was aimed at; all if none.
    pub camera: Option<u32>,
    /// Which intrinsics moved.
    pub refine: Vec<String>,
    /// The error for which the smallest size was sought.
    pub target_px: Option<f64>,
    /// The known cameras with which calibrations were compared; the full reconstruction if none.
    pub truth: Option<InputFile>,
}

/// A model of the experiment.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ModelRecord {
    /// Its path.
    pub name: String,
    /// The files it was read from.
    pub files: Vec<InputFile>,
    /// Its images, by name; choices refer to their places here.
    pub images: Vec<String>,
    /// The camera of each image.
    pub image_cameras: Vec<u32>,
    /// From where each image was taken, along the two directions in which these places differ most, in a unit of their own.
    pub map: Vec<[f64; 2]>,
    /// The wanted cameras.
    pub cameras: Vec<CameraRecord>,
    /// Standard deviation of a pixel's coordinate, by the full reconstruction.
    pub sigma_px: f64,
    /// Images or frames that hang together.
    pub unit_count: usize,
    /// How many of them a pool has.
    pub pool_size: usize,
    /// The sizes that were tried: those up to the pool's.
    pub sizes: Vec<usize>,
}

/// A camera that is wanted.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CameraRecord {
    /// Its CAMERA_ID.
    pub camera_id: u32,
    /// Its model.
    pub model: String,
    /// Width of its images in px.
    pub width: u64,
    /// Height of its images in px.
    pub height: u64,
    /// The names of its parameters.
    pub parameters: Vec<String>,
    /// Their values in the full reconstruction.
    pub refined: Vec<f64>,
    /// The places of the parameters that moved.
    pub free: Vec<usize>,
    /// Columns and rows of the parts of its image that coverage counts.
    pub parts: [usize; 2],
}

/// The heuristics in order.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Ranking {
    /// The model; all of them if none.
    pub model: Option<usize>,
    /// The size; all of them if none.
    pub size: Option<usize>,
    /// The one that is shown to be better than every other: that one that is not says so happens once in twenty times at most.
    pub winner: Option<String>,
    /// Those to which none is shown to be better.
    pub first: Vec<String>,
    /// All that gave calibrations often enough, the least error first.
    pub rows: Vec<RankRow>,
    /// Those that are not ranked: somewhere they gave none in more than a tenth of the repeats, and more than once.
    pub unranked: Vec<String>,
}

/// A heuristic in a ranking.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RankRow {
    /// Its name.
    pub heuristic: String,
    /// One more than the number of those that are shown to be better: the interval of the ratio excludes 1, of all pairs together
    /// with 95 % (Bonferroni).
    pub rank: usize,
    /// RMS error in px, geometric mean over models and sizes.
    pub rms_px: f64,
    /// Its error over that of the first; the intervals of all pairs hold together with 95 %.
    pub to_first: Option<Ratio>,
    /// Its error over that of images chosen by chance; each interval by itself.
    pub to_random: Option<Ratio>,
}

/// A ratio of errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Ratio {
    /// The ratio.
    pub ratio: f64,
    /// Its 95 % interval; none where repeats are not independent.
    pub interval_95: Option<[f64; 2]>,
}

/// How many images a heuristic needs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Target {
    /// The heuristic.
    pub heuristic: String,
    /// The smallest size tried whose RMS error is no larger than asked for, in every model; none where none is.
    pub size: Option<usize>,
    /// The smallest size tried at which the upper end of its interval is no larger either.
    pub certain_size: Option<usize>,
}

/// How far models agree.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Agreement {
    /// Kendall's W of the orders of the heuristics: 1 where all are the same, near 0 where they have nothing in common.
    pub concordance: Option<f64>,
    /// The heuristic with the least error, of each model.
    pub best: Vec<String>,
}

/// A heuristic at a size of a model.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Cell {
    /// The model, by its place.
    pub model: usize,
    /// How many images or frames were chosen.
    pub size: usize,
    /// The heuristic.
    pub heuristic: String,
    /// How many calibrations there are.
    pub n: usize,
    /// How many repeats gave none.
    pub failures: usize,
    /// RMS error: bias and spread together, each calibration turned onto what it is compared with. Over cameras the root of the
    /// mean square, as all below.
    pub error: Option<ErrorParts>,
    /// 95 % interval of the RMS error.
    pub interval_95: Option<[f64; 2]>,
    /// The same of the calibrations as they are.
    pub raw: Option<ErrorParts>,
    /// The median distance in px by which points are seen off in the images that were not chosen; median over the repeats.
    pub held_out_px: Option<f64>,
    /// The share of their images that two repeats have in common, mean over all pairs.
    pub overlap: Option<f64>,
    /// The same camera by camera.
    pub cameras: Vec<CameraCell>,
    /// How often each image was chosen, by its place among the model's.
    pub chosen: Vec<usize>,
    /// Why repeats gave none: reasons and how often.
    pub reasons: Vec<(String, usize)>,
}

/// A camera in a cell.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CameraCell {
    /// Its CAMERA_ID.
    pub camera_id: u32,
    /// Turned onto what it is compared with.
    pub error: ErrorParts,
    /// As it is.
    pub raw: ErrorParts,
    /// With a truth: the bias from the full reconstruction.
    pub bias_from_full_px: Option<f64>,
    /// The parameters that moved, over the repeats.
    pub parameters: Vec<(String, Statistics)>,
    /// In each part of the image, row by row from the top left: how many of the images chosen see something there, mean over the
    /// repeats.
    pub coverage: Vec<f64>,
}

/// An error over the image and its parts, in px.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct ErrorParts {
    /// Root of the mean square over the image and the repeats.
    pub rms_px: f64,
    /// RMS over the image of the mean of the repeats.
    pub bias_px: f64,
    /// RMS over the image of their deviations from that, with n - 1; none for one.
    pub spread_px: Option<f64>,
}

/// A choice, what came of it, and how far off that is.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ScoredSample {
    /// The choice and what came of it.
    #[serde(flatten)]
    pub sample: Sample,
    /// RMS over the image of the difference from what it is compared with, turned onto it, in px; over cameras the root of the mean square.
    pub error_px: Option<f64>,
    /// The same as it is.
    pub raw_error_px: Option<f64>,
}
