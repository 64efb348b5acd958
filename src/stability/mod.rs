//! Runs to samples to summaries: how far repeated calibrations disagree.
//!
//! Knows nothing of files or of how its results are shown.

mod analysis;

pub use analysis::*;
