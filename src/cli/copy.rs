//! `calibstab copy`.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::failure::Failure;
use super::model;
use crate::colmap::{self, Form};

/// Write a model anew, as text or binary, with every number as it was
///
/// The files appear all at once, when all of them are written. What calibstab itself does not use is copied too: colours,
/// errors, cameras that took no image, keypoints that belong to no point.
#[derive(Args)]
pub(super) struct Copy {
    /// A cameras file, a model folder, a run folder with sparse or sparse/0, or a Bundle Adjustment in the Large problem
    model: PathBuf,

    /// The folder to write into; files of the same names are replaced
    #[arg(value_name = "FOLDER")]
    out: PathBuf,

    /// Write cameras.txt, images.txt, ...
    #[arg(long, required_unless_present = "binary")]
    text: bool,

    /// Write cameras.bin, images.bin, ...
    #[arg(long, conflicts_with = "text")]
    binary: bool,
}

impl Copy {
    pub(super) fn run(&self, quiet: bool) -> Result<(), Failure> {
        let form = if self.binary { Form::Binary } else { Form::Text };
        let (scene, _, remarks) = model::read(&self.model)?;
        let written = colmap::write(&scene, &self.out, form)
            .map_err(|error| Failure::Input(error.to_string()))?;
        let mut talk = anstream::stderr();
        for remark in remarks.iter().chain(&written.remarks) {
            writeln!(talk, "remark: {remark}")?;
        }
        if !quiet {
            writeln!(talk, "{} files written to {}", written.files.len(), self.out.display())?;
        }
        Ok(())
    }
}
