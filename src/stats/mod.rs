//! Statistics of small samples: functions on plain numbers, with the definition of each named.
//!
//! Knows nothing of cameras or runs.

mod correlation;
mod sorted;
mod spread_interval;

pub use correlation::pearson;
pub use sorted::{BoxPlot, Sorted};
pub use spread_interval::std_interval_factors;
