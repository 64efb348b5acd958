//! `calibstab refine`.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget};

use super::adjustment::Adjustment;
use super::failure::Failure;
use super::{model, refined};
use crate::bundle;
use crate::colmap;
use crate::least_squares::Trial;

/// Adjust a reconstruction: intrinsics, poses and points together, to the optimum
///
/// Reads a model with images and points, minimises the reprojection error, and writes the refined model in the form in which
/// it came. The points' stored errors are computed anew. Results come back in the frame of the model.
#[derive(Args)]
pub(super) struct Refine {
    /// A model folder, a run folder with sparse or sparse/0, or a Bundle Adjustment in the Large problem
    model: PathBuf,

    /// The folder to write the refined model into
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,

    #[command(flatten)]
    how: Adjustment,

    /// Print a line for each step, on stderr
    #[arg(long)]
    verbose: bool,

    /// Print the result as JSON, at full precision
    #[arg(long)]
    json: bool,
}

impl Refine {
    pub(super) fn run(&self, out: &mut impl Write, quiet: bool) -> Result<(), Failure> {
        let failed = |error: &dyn std::error::Error| Failure::Input(error.to_string());
        let (scene, form, remarks) = model::read(&self.model)?;
        let mut talk = anstream::stderr();
        for remark in &remarks {
            writeln!(talk, "remark: {remark}")?;
        }
        let target = if quiet || self.verbose {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(None, target);
        if self.verbose {
            writeln!(talk, "{}", refined::STEP_HEAD)?;
        }
        let mut watch = |trial: &Trial| {
            let line = refined::step(trial);
            if self.verbose {
                // Nobody is left to be told when stderr is closed; the adjustment goes on.
                let _ = writeln!(anstream::stderr(), "{line}");
            }
            bar.set_message(line);
            bar.tick();
        };
        let options = self.how.options();
        let adjusted = bundle::adjust(scene, &options, &mut watch)
            .map_err(|error| Failure::Input(format!("{}: {error}", self.model.display())))?;
        bar.finish_and_clear();
        let written = colmap::write(&adjusted.scene, &self.out, form);
        let written = written.map_err(|error| failed(&error))?;
        for remark in written.remarks.iter().chain(&refined::remarks(&adjusted.outcome)) {
            writeln!(talk, "remark: {remark}")?;
        }
        let said = if self.json {
            refined::json(&adjusted.outcome)
        } else {
            refined::summary(&adjusted.outcome)
        };
        write!(out, "{said}")?;
        if !quiet {
            writeln!(talk, "{} files written to {}", written.files.len(), self.out.display())?;
        }
        Ok(())
    }
}
