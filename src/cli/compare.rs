//! `calibstab compare`.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::analyze::Match;
use super::failure::Failure;
use super::inputs::{Inputs, named_in_full, read_one};
use super::output::{OutputFile, plot_files, write_files};
use crate::report::{self, plot};
use crate::stability::spread::Region;
use crate::stability::{self, Comparison};

/// Compare calibrations of the same cameras, or set them against a known one
///
/// Two: the difference from one to the other and back, in px, as they are and with one turned onto the other. More: their
/// spread, and the distances between them. With --reference: how far each is off, and their mean. The camera models need not
/// be the same, the image sizes must.
#[derive(Args)]
pub(super) struct Compare {
    #[command(flatten)]
    inputs: Inputs,

    /// A known calibration: a cameras file or a model folder
    #[arg(long, value_name = "PATH")]
    reference: Option<PathBuf>,

    /// How cameras are matched [default: the only one of each, else by the images they took, else by CAMERA_ID]
    #[arg(long = "match", value_enum, value_name = "RULE")]
    match_by: Option<Match>,

    /// Over which part of the image: observed, all, or center:0.8 (that share of width and height)
    #[arg(long, value_name = "REGION")]
    region: Option<Region>,

    /// Write the comparison into this folder
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,

    /// What is written [default: all]
    #[arg(long, value_enum, value_delimiter = ',', requires = "out", value_name = "FORMAT,...")]
    format: Vec<Format>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// comparison.json: everything, maps in single precision
    Json,
    /// plots/*.svg
    Svg,
    /// plots/*.png
    Png,
}

impl Compare {
    pub(super) fn run(self, out: &mut impl Write, quiet: bool) -> Result<(), Failure> {
        let failed = |error: &dyn std::error::Error| Failure::Input(error.to_string());
        let (runs, skipped) = self.inputs.read(quiet)?;
        for skipped in skipped {
            writeln!(anstream::stderr(), "skipped: {}", skipped.reason)?;
        }
        let reference = match &self.reference {
            Some(path) => Some(read_one(path, "the reference")?),
            None => None,
        };
        let rule = self.match_by.map(Match::rule);
        let runs = runs.into_iter().map(named_in_full).collect();
        let comparison = stability::compare(runs, reference, rule, self.region)
            .map_err(|error| failed(&error))?;
        if let Some(folder) = &self.out {
            let formats =
                if self.format.is_empty() { Format::value_variants() } else { &self.format };
            let files = comparison_files(&comparison, formats)?;
            write_files(folder, &files)?;
            if !quiet {
                let (count, folder) = (files.len(), folder.display());
                let files = if count == 1 { "file" } else { "files" };
                writeln!(anstream::stderr(), "{count} {files} written to {folder}")?;
            }
        }
        Ok(out.write_all(report::comparison_text(&comparison).as_bytes())?)
    }
}

fn comparison_files(
    comparison: &Comparison,
    formats: &[Format],
) -> Result<Vec<OutputFile>, Failure> {
    let failed = |error: &dyn std::error::Error| Failure::Input(error.to_string());
    let wants = |format| formats.contains(&format);
    let mut files: Vec<OutputFile> = Vec::new();
    if wants(Format::Json) {
        let json = report::comparison_json(comparison).map_err(|error| failed(&error))?;
        files.push(("comparison.json".into(), json.into_bytes()));
    }
    if wants(Format::Svg) || wants(Format::Png) {
        let figures = plot::comparison_figures(comparison).map_err(|error| failed(&error))?;
        files.extend(plot_files(&figures, wants(Format::Svg), wants(Format::Png))?);
    }
    Ok(files)
}
