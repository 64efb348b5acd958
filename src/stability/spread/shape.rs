//! The shape of a spread in `analysis.json`.

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use super::Region;

/// How far the calibrations of one camera disagree, in pixels, over the image.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Spread {
    /// How many calibrations.
    pub n: usize,
    /// Which part of the image was asked for.
    pub region: Region,
    /// Cells in a row of the image.
    pub columns: usize,
    /// Cells in a column of the image.
    pub rows: usize,
    /// The cells that were compared, counted row by row from the top left: those of the region where all calibrations have a
    /// ray. Every map below has their order.
    pub cells: Vec<usize>,
    /// Their share of the image.
    pub cell_share: f64,
    /// The cells of the region that were not compared: there some calibration has no ray.
    pub masked_cells: Vec<usize>,
    /// Of every cell of the image, the observations in it, of all calibrations that were compared together; none unless all have
    /// images.
    pub observation_counts: Option<Vec<usize>>,
    /// The calibrations as they are.
    pub raw: SpreadMeasure,
    /// Each turned onto the others, as the poses of a reconstruction would absorb it.
    pub rotated: SpreadMeasure,
    /// Degrees of freedom of that: n - 1 times the independent columns of the deviations (Box 1954).
    pub degrees: f64,
    /// 95 % confidence interval of its RMS in px (chi-square: normal samples).
    pub rotated_interval_95: [f64; 2],
    /// Each turned and moved onto the others; only where points tell how far away the scene was.
    pub moved: Option<MovedSpread>,
    /// Every calibration that was compared, rotation-aligned.
    pub runs: Vec<RunDeviation>,
    /// Calibrations that were set aside: they have no ray where the others have.
    pub set_aside: Vec<SetAside>,
    /// The calibration with the greatest deviation, and where it deviates.
    pub worst: DeviationField,
    /// The spread by distance from the image's centre.
    pub radial_profile: Vec<Ring>,
    /// RMS distance in px between any two calibrations over the cells, rotation-aligned, in the order of `runs`; none for more
    /// than 50 of them.
    pub distances_px: Option<Vec<Vec<f64>>>,
}

impl Spread {
    /// Columns and rows of the image's cells.
    pub fn grid(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    /// The observations in each cell of the image, mean over the calibrations.
    pub fn mean_observations(&self) -> Option<Vec<f64>> {
        let mean = |count: &usize| *count as f64 / self.n as f64;
        Some(self.observation_counts.as_ref()?.iter().map(mean).collect())
    }
}

/// A spread in numbers: sqrt(sum over the runs of |deviation|^2 / (n - 1)) in each cell.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SpreadMeasure {
    /// Root of the mean square over the cells.
    pub rms_px: f64,
    /// 95th percentile over the cells (type 7).
    pub p95_px: f64,
    /// The greatest.
    pub max_px: f64,
    /// The pixel where it is greatest.
    pub max_at: [f64; 2],
    /// The same as angles: root of the mean square.
    pub rms_deg: f64,
    /// 95th percentile of the angles.
    pub p95_deg: f64,
    /// The greatest angle.
    pub max_deg: f64,
    /// RMS over the cells of what the spread would be without outliers: the median distance from the median, scaled to be the
    /// spread of normal deviations (1 / sqrt(ln 2)).
    pub median_based_px: f64,
    /// The spread in each cell, in px; written in single precision.
    #[serde(serialize_with = "in_single_precision")]
    pub map_px: Vec<f64>,
}

/// The spread after turning and moving.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct MovedSpread {
    /// The depths that were compared jointly, as multiples of the median distance from the camera to the points it observed:
    /// 10, 50 and 90 % quantiles, median over the runs.
    pub depths: [f64; 3],
    /// Over cells and depths.
    pub measure: SpreadMeasure,
}

/// How far one calibration is off the consensus of all.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RunDeviation {
    /// The run.
    pub run: String,
    /// The camera's CAMERA_ID in it.
    pub camera_id: u32,
    /// Rotation-aligned: root of the mean square over the cells.
    pub rms_px: f64,
    /// The same as it is.
    pub raw_rms_px: f64,
    /// The greatest deviation, rotation-aligned.
    pub max_px: f64,
    /// The pixel where it is greatest.
    pub max_at: [f64; 2],
    /// How far it was turned.
    pub rotation_deg: f64,
}

/// A calibration that was not compared.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SetAside {
    /// The run.
    pub run: String,
    /// The camera's CAMERA_ID in it.
    pub camera_id: u32,
    /// Share of the cells where the others have a ray and it has none.
    pub without_ray: f64,
}

/// Where one calibration deviates from the consensus, rotation-aligned.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DeviationField {
    /// The run.
    pub run: String,
    /// The camera's CAMERA_ID in it.
    pub camera_id: u32,
    /// How many cells apart, along rows and columns, those are that are told: so far that some hundreds remain, as arrows are drawn.
    pub pitch: usize,
    /// Those cells.
    pub cells: Vec<usize>,
    /// In px, in each of them: from where the consensus's ray should be seen to where it is; written in single precision.
    #[serde(serialize_with = "pairs_in_single_precision")]
    pub px: Vec<[f64; 2]>,
}

/// The cells of a ring about the image's centre.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Ring {
    /// Middle of the ring, in px from the centre.
    pub radius_px: f64,
    /// Cells whose centres lie in it.
    pub cell_count: usize,
    /// RMS of their spread as it is.
    pub raw_rms_px: f64,
    /// RMS of their spread, rotation-aligned.
    pub rms_px: f64,
}

/// Maps are most of an analysis, and no one reads more of a cell than seven digits.
pub(in crate::stability) fn in_single_precision<S: Serializer>(
    map: &[f64],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(map.iter().copied().map(single))
}

fn pairs_in_single_precision<S: Serializer>(
    map: &[[f64; 2]],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(map.iter().map(|pair| pair.map(single)))
}

#[allow(clippy::cast_possible_truncation)] // rounds
fn single(value: f64) -> f32 {
    value as f32
}
