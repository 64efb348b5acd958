//! How repeatable is the camera calibration that COLMAP gave you?
//!
//! ```text
//! files -colmap-> scene -stability-> analysis -report-> table, CSV, JSON, Markdown, plots
//! ```
//!
//! Each arrow is a function from plain data to plain data. The library never prints, exits, or panics on input; `cli` does
//! the first two.

pub mod bal;
pub mod bundle;
pub mod camera;
pub mod cli;
pub mod colmap;
pub mod convert;
pub mod least_squares;
pub mod report;
pub mod scene;
pub mod selection;
pub mod stability;
pub mod stats;
pub mod synth;
