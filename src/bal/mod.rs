//! Bundle Adjustment in the Large: a problem's text to and from a `Scene`.
//!
//! Each image has a camera of its own, which looks along -Z; pixels count from the image's centre, y upwards.
//! S. Agarwal, N. Snavely, S. Seitz, R. Szeliski, Bundle Adjustment in the Large, ECCV 2010.

mod error;
mod read;
mod rotation;
mod write;

pub use error::{ReadError, Why};
pub use read::{is_problem, parse, read};
pub use write::{WriteError, encode};
