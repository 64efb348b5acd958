//! COLMAP's models on disk, text and binary, from 3.x to 4.x, to and from a `Scene`.
//!
//! [`find`] locates models, [`ModelFiles::read`] reads one, [`read`] does both; [`write()`] writes one.
//! [`ModelFiles::for_each_image`] and [`ModelFiles::for_each_point`] read models larger than memory. What a record holds is
//! said once, for both forms, in `cameras`, `images`, `points` and `mounting`, and in `write/records` for the way back; `text`
//! and `binary` know only how a field is written. Images and points are read in blocks, by all threads. What is read is
//! checked to the last number; nothing here knows what the numbers are for.

mod binary;
mod block;
mod cameras;
mod digits;
mod error;
mod excerpt;
mod files;
mod find;
mod geometry;
mod images;
mod model;
mod mounting;
mod points;
mod sightings;
mod source;
mod stream;
mod text;
mod why;
mod workers;
mod write;

use std::path::Path;

pub use block::{Open, Opened};
pub use error::ReadError;
pub use excerpt::Excerpt;
pub use files::{Form, ModelFiles};
pub use find::find;
pub use points::ReadPoint;
pub use why::Why;
pub(crate) use write::Staged;
pub use write::{WriteError, Written, encode, write, write_cameras};

use crate::scene::Scene;

/// Reads the one model at this path: a cameras file, a model folder, or a run with `sparse/0`.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// # let folder = folder.path();
/// std::fs::write(folder.join("cameras.txt"), "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1")?;
/// let scene = calibstab::colmap::read(folder)?;
/// assert_eq!(scene.cameras.len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(path: &Path) -> Result<Scene, ReadError> {
    find_one(path)?.read()
}

/// The one model at this path; several are an error.
pub fn find_one(path: &Path) -> Result<ModelFiles, ReadError> {
    let mut models = find(path)?;
    match models.pop() {
        Some(model) if models.is_empty() => Ok(model),
        _ => Err(ReadError::ManyModels { path: path.to_owned(), count: models.len() + 1 }),
    }
}
