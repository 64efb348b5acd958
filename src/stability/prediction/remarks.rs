//! What a prediction tells, as a finding.

use super::super::remarks::of_camera;
use super::super::{Finding, FindingId, Population};

/// A Birge ratio above this convicts (DESIGN section 6).
pub const MOST_BIRGE: f64 = 1.5;

/// Runs that differ by more than their covariances allow.
pub(in crate::stability) fn of_population(population: &Population) -> Option<Finding> {
    let consistency = population.prediction.as_ref()?.consistency.as_ref()?;
    let (ratio, corrected) = match consistency.independent {
        Some(ratio) => (ratio, ", corrected for what they share"),
        None => (consistency.found, ""),
    };
    let text = format!(
        "{}: the runs differ {:.1} times as much as their adjustments predict (Birge ratio{corrected}; T on {} degrees): \
         more than the noise of the keypoints varies between them",
        population.camera, ratio.birge, consistency.degrees
    );
    (ratio.birge > MOST_BIRGE).then(|| of_camera(FindingId::Birge, population, Vec::new(), text))
}
