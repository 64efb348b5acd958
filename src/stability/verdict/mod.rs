//! The verdict on a camera: what to make of its runs, before any number. A finding says why it is not better.

pub(super) mod basis;
#[cfg(test)]
mod tests;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Finding, FindingId, Population};
pub(super) use basis::calibration_count;

/// What to make of a camera's calibrations. Never that they are right: only a reference could tell.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct Verdict {
    /// What it is.
    pub kind: VerdictKind,
    /// How many calibrations it is about.
    pub n: usize,
    /// How far one calibration lies from the next in the image: the spread, RMS in px, rotation-aligned; that of independent runs
    /// where what the runs share tells it. None where there is no spread.
    pub spread_px: Option<f64>,
    /// 95 % confidence interval of it, by the spread's degrees of freedom (chi-square: normal samples).
    pub spread_interval_95: Option<[f64; 2]>,
    /// Why it is not better, what weighs most first; empty when it is repeatable.
    pub reasons: Vec<Reason>,
}

/// The kinds of verdict, the best first.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum VerdictKind {
    /// Calibrations repeat to the spread's pixels, and nothing speaks against it.
    Repeatable,
    /// There is a spread or a covariance, and a reason not to rely on it.
    Doubtful,
    /// The runs do not tell how well they determine the camera, or do not determine it.
    #[default]
    NotDetermined,
}

/// A finding that keeps a verdict from being better.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Reason {
    /// What kind of finding it is; `calibstab explain` says more of it.
    pub id: FindingId,
    /// The finding, in one sentence.
    pub text: String,
}

impl VerdictKind {
    /// All of them, the best first.
    pub const ALL: [Self; 3] = [Self::Repeatable, Self::Doubtful, Self::NotDetermined];

    /// Its name, as in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Repeatable => "repeatable",
            Self::Doubtful => "doubtful",
            Self::NotDetermined => "not-determined",
        }
    }
}

impl FindingId {
    /// The best verdict on a camera about which there is such a finding.
    pub fn at_best(self) -> VerdictKind {
        match self {
            Self::OpenDirection | Self::NoEstimate | Self::NotRepeated => {
                VerdictKind::NotDetermined
            }
            Self::DuplicateRuns
            | Self::LostRuns
            | Self::OutlierRun
            | Self::Clusters
            | Self::Birge
            | Self::HeldParameter
            | Self::ResidualPattern
            | Self::SharedObservations
            | Self::NoSpread
            | Self::SmallRegion
            | Self::Fold
            | Self::FewRuns => VerdictKind::Doubtful,
            Self::SkippedRun
            | Self::BogusCamera
            | Self::FewImages
            | Self::MissingCamera
            | Self::HeavyTails
            | Self::RefinementFailed
            | Self::NotRefined
            | Self::UnusedCamera
            | Self::MixedCameras
            | Self::MixedStates
            | Self::CameraPerImage
            | Self::CameraMatch
            | Self::ClusteredErrors
            | Self::Refinement
            | Self::NoRay
            | Self::Reading => VerdictKind::Repeatable,
        }
    }

    /// Whether it says that the runs are too few, and more of them could better the verdict.
    pub fn is_lack_of_runs(self) -> bool {
        matches!(self, Self::NotRepeated | Self::FewRuns)
    }
}

/// The verdict on a population about which these findings are.
pub(super) fn verdict(one: &Population, findings: &[Finding]) -> Verdict {
    let against = findings.iter().filter(|finding| finding.id.at_best() > VerdictKind::Repeatable);
    let mut against: Vec<&Finding> = against.collect();
    against.sort_by_key(|finding| (std::cmp::Reverse(finding.id.at_best()), finding.id));
    let kind = against.iter().map(|finding| finding.id.at_best()).max();
    let of_camera = format!("{}: ", one.camera);
    let reason = |finding: &&Finding| {
        let text = finding.text.strip_prefix(&of_camera).unwrap_or(&finding.text).to_owned();
        Reason { id: finding.id, text }
    };
    let n = calibration_count(one);
    // Calibrations of which nothing was estimated are equal because they were held so.
    let spread = one.spread.as_ref().filter(|_| n > 1);
    let independent = one.overlap.as_ref().and_then(|overlap| overlap.independent_factor);
    let factor = independent.unwrap_or(1.0);
    Verdict {
        kind: kind.unwrap_or(VerdictKind::Repeatable),
        n,
        spread_px: spread.map(|spread| factor * spread.rotated.rms_px),
        spread_interval_95: spread.map(|spread| spread.rotated_interval_95.map(|px| factor * px)),
        reasons: against.iter().map(reason).collect(),
    }
}
