//! What a user is told when a model cannot be written.

use std::io;
use std::path::PathBuf;

use super::super::Form;
use super::super::excerpt::escaped;
use crate::scene::{CameraId, ImageId};

/// A model that could not be written, and why. No file was changed, unless a file that was complete could not get its name.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The system would not write a file.
    #[error("{}: cannot be written: {source}", escaped(file.as_os_str().as_encoded_bytes()))]
    File {
        /// Which.
        file: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// A file that stands there already would be read as a part of this model.
    #[error(
        "{}: this file of another model would be read as a part of the new one; remove it, or write elsewhere",
        escaped(file.as_os_str().as_encoded_bytes())
    )]
    InTheWay {
        /// Which.
        file: PathBuf,
    },
    /// COLMAP's binary files name a camera model by its number, and this one has none.
    #[error(
        "camera {camera}: {model} is calibstab's own and has no number in COLMAP's binary files, only a name in text"
    )]
    NoModelId {
        /// The first such camera.
        camera: CameraId,
        /// The name of its model.
        model: &'static str,
    },
    /// A name that this form cannot hold.
    #[error(
        "image {image}: {} cannot hold the name `{}`, which {why}",
        form.adjective(),
        escaped(name.as_bytes())
    )]
    Name {
        /// The first such image.
        image: ImageId,
        /// Its name.
        name: String,
        /// The form.
        form: Form,
        /// What about the name it is.
        why: &'static str,
    },
    /// Something computed that is no number.
    #[error("{what} holds {value}, which is not a finite number")]
    NotFinite {
        /// The record.
        what: String,
        /// The value.
        value: f64,
    },
}
