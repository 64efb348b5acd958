//! Commands about calibstab itself: schema, completions, manual page.

use std::io::Write;

use clap::{Args, CommandFactory, ValueEnum};

use super::Cli;
use super::failure::Failure;
use crate::report;

pub(super) const LONG: &str = "\
Examples:
  calibstab analyze runs/*/cameras.txt
      the runs of one folder are one group: how far do they disagree, refined and as COLMAP left them?
  calibstab analyze experiments
      every model below experiments; runs of one parent folder are a group
  calibstab analyze a/sparse/0 b/sparse/0 --out report --format json,md,svg
      the same, and a report in files
  calibstab analyze 'data/*/*/sparse' --group-by '{session}/{run}/sparse'
      groups named by a part of the path
  calibstab analyze runs --refine all --loss cauchy:1
      with the principal points free too, and a loss by which outliers count less
  calibstab inspect run/sparse/0
      what its cameras see: field of view, folds, pixels without a ray
  calibstab convert run/sparse/0 --to EUCM --out cameras_eucm.txt
      its cameras in another model, with the error in px
  calibstab compare a/cameras.txt b/cameras.txt
      two calibrations of one camera, of whatever models: how far apart in px?
  calibstab compare --reference known/cameras.txt runs/*/cameras.txt
      how far is each, and is their mean, off a known calibration?
  calibstab copy run/sparse/0 run/text --text
      a binary model as text
  calibstab synth --repeats 6 --out room && calibstab analyze room
      six reconstructions of a synthetic room, each with its truth beside it, to try things on
  calibstab check report/analysis.json --max-spread-px 0.5 --max-relative-std f=1% --verdict repeatable
      in a CI job: exit code 1 when a camera does not keep the limits
  calibstab refine run/sparse/0 --out refined --refine all --loss cauchy:1
      adjust poses, points and all intrinsics together; outliers count less
  calibstab select run/sparse/0 --size 20 --out images.txt
      the 20 images that tell most of the intrinsics, each with the reason; COLMAP reads the list
  calibstab rank run/sparse/0 --sizes 8,12,20 --repeats 30 --out ranking
      which rule chooses images that calibrate best, and is it certain?
  calibstab resample run/sparse/0 --by image:0.5 --out samples && calibstab analyze samples
      from one reconstruction: how far do calibrations from half of its images disagree?

Exit codes: 0 fine; 1 a limit of `check` was exceeded; 2 bad usage or input; 3 too little data to tell. Results go to stdout, all else to stderr.";

/// Print the JSON schema of analysis.json, or of selection.json
#[derive(Args)]
pub(super) struct Schema {
    /// Of which file
    #[arg(value_enum, default_value = "analysis")]
    of: Document,
}

#[derive(Clone, Copy, ValueEnum)]
enum Document {
    /// What `analyze` writes
    Analysis,
    /// What `rank` writes
    Selection,
}

impl Schema {
    pub(super) fn run(&self, out: &mut impl Write) -> Result<(), Failure> {
        let schema = match self.of {
            Document::Analysis => report::schema_json(),
            Document::Selection => report::selection_schema_json(),
        };
        let schema = schema.map_err(|error| Failure::Input(error.to_string()))?;
        Ok(out.write_all(schema.as_bytes())?)
    }
}

/// Print completions for a shell, to be sourced by it
#[derive(Args)]
pub(super) struct Completions {
    /// The shell
    shell: clap_complete::Shell,
}

impl Completions {
    pub(super) fn run(&self, out: &mut impl Write) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "calibstab", &mut script);
        Ok(out.write_all(&script)?)
    }
}

/// Print the manual page, of calibstab or of one of its commands
#[derive(Args)]
pub(super) struct Man {
    /// The command
    command: Option<String>,
}

impl Man {
    pub(super) fn run(&self, out: &mut impl Write) -> Result<(), Failure> {
        let mut whole = Cli::command();
        whole.build();
        let page = match &self.command {
            None => whole,
            Some(name) => whole
                .find_subcommand(name)
                .cloned()
                .ok_or_else(|| Failure::Input(format!("calibstab has no command `{name}`")))?,
        };
        let mut text = Vec::new();
        clap_mangen::Man::new(page).render(&mut text)?;
        Ok(out.write_all(&text)?)
    }
}
