//! Runs to samples to summaries: how far repeated calibrations disagree.
//!
//! Knows nothing of files or of how its results are shown.

mod analysis;
mod analyze;
mod between;
mod clusters;
mod compare;
mod components;
mod deviations;
mod disagreement;
mod explain;
mod group;
mod identity;
mod image_effect;
mod inside;
mod names;
mod overlap;
mod partition;
mod physical;
mod populations;
mod prediction;
mod refinement;
mod remarks;
mod run;
mod screen;
pub mod spread;
mod summary;
#[cfg(test)]
mod testing;
mod verdict;
mod view;

pub use analysis::*;
pub use analyze::analyze;
pub use between::{GroupComparison, PairTest, ParameterTest, RankedGroup, TestMethod};
pub use clusters::{Clusters, Part, PartParameter};
pub use compare::{CompareError, ComparedCamera, Comparison, ToReference, compare};
pub use components::{Components, ImageComponents, ParameterComponents, VarianceComponents};
pub use explain::Explanation;
pub use identity::MatchError;
pub use inside::{
    CellMean, FreedParameter, HeldClass, HeldInRun, HeldTest, Inside, Mean, ResidualMap, Residuals,
    ResidualsInRun, RingMean, RunHeld, RunResiduals, Tails,
};
pub use overlap::Overlap;
pub use prediction::remarks::MOST_BIRGE;
pub use prediction::{Consistency, Direction, PredictedSpread, Prediction, Ratio, RunPrediction};
pub use refinement::{
    Adjustment, AsLeft, ClusteredCovariance, LeftSpread, RefinedCamera, Refinement,
    RefinementOptions, Stopped, failure_of_refit, failure_of_sample,
};
pub use remarks::p_in_words;
pub use run::Run;
pub use verdict::{Reason, Verdict, VerdictKind};
pub use view::views;
