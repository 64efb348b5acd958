//! Self-calibration bundle adjustment: poses, points and the intrinsics that images share, to the least sum of (robust) squares.
//!
//! A scene becomes a `Problem` once: points in chunks, unknowns in order. `linearize` alone knows camera models; `eliminate` takes
//! each point out on the fly, `schur` solves what is left. Knows nothing of files or of repeated runs.

mod cholesky;
mod chunk;
mod clustered;
mod covariance;
mod determined;
mod eliminate;
mod error;
mod follow;
mod frame;
mod gauge;
mod limits;
mod linearize;
mod loss;
mod optimum;
mod options;
mod order;
mod outcome;
mod pairs;
mod point;
mod probe;
mod problem;
mod products;
mod resection;
mod rows;
mod schur;
mod sensitivity;
mod shape;
mod solver;
mod subsets;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;
mod tiles;
mod write_back;

pub use clustered::Clustered;
pub use covariance::{Covariance, FreeParam, OpenDirection};
pub use error::BundleError;
pub use loss::Loss;
pub use optimum::{Observation, Optimum, Widened};
pub use options::{Bound, Mode, Of, Options, Prior, Refine, Which};
pub use outcome::{Adjusted, CameraOutcome, Outcome, adjust, adjust_to_optimum};
pub use probe::{Entry, Probe};
pub use problem::Dropped;
pub use resection::{Bystander, Seen};
pub use sensitivity::{Sensed, Sensitivities};
pub use subsets::{Refit, Sight, Subsets};

pub(crate) use cholesky::Dense;
pub(crate) use sensitivity::eliminator;
