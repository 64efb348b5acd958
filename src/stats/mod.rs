//! Statistics of small samples: functions on plain numbers, with the definition of each named.
//!
//! Knows nothing of cameras or runs.

mod chi_square;
mod contrast;
mod correlation;
mod fisher;
#[cfg(test)]
mod levels;
mod one_way;
mod repeats;
mod sorted;
mod spread_interval;
#[cfg(test)]
mod testing;
mod variance_tests;

pub use chi_square::{chi_square_quantile, chi_square_tail};
pub use contrast::{Contrast, Pair, concordance, rms_interval};
pub use correlation::pearson;
pub use fisher::upper_tail as f_tail;
pub use one_way::{OneWay, one_way};
pub use repeats::{Repeats, degrees_of_distances};
pub use sorted::{BoxPlot, Sorted};
pub use spread_interval::{std_interval_factors, std_interval_factors_of_degrees};
pub use variance_tests::{
    VarianceTest, brown_forsythe, f_test, f_test_power, holm, samples_needed,
};
