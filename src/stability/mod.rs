//! Runs to samples to summaries: how far repeated calibrations disagree.
//!
//! Knows nothing of files or of how its results are shown.

mod analysis;
mod analyze;
mod between;
mod components;
mod deviations;
mod identity;
mod image_effect;
mod names;
mod partition;
mod physical;
mod remarks;
mod run;
mod screen;
pub mod spread;
mod summary;
#[cfg(test)]
mod testing;

pub use analysis::*;
pub use analyze::analyze;
pub use between::{Comparison, PairTest, ParameterTest, RankedGroup, TestMethod};
pub use components::{Components, ImageComponents, ParameterComponents, VarianceComponents};
pub use identity::MatchError;
pub use run::Run;
