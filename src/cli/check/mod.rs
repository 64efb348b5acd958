//! `calibstab check`: an analysis held against limits, as a CI job does.

mod gate;
mod judged;
mod limits;

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::failure::Failure;
use gate::{Breach, judge};
use judged::judged_cameras;
use limits::{Limits, Positive, Rules, Share, Wanted};

/// Hold an analysis against limits: exit code 1 when one is exceeded, with the reasons, one a line
///
/// Reads what `calibstab analyze --out FOLDER` wrote. Exit code 0: within all limits; 1: a limit is exceeded; 2: bad usage or
/// input, or a limit that is about no camera; 3: the runs cannot tell. When some limits are exceeded and of others the runs
/// cannot tell, 1.
#[derive(Args)]
pub(super) struct Check {
    /// analysis.json, or the folder that it is in
    analysis: PathBuf,

    /// The most that calibrations may spread: RMS in px, rotation-aligned, corrected for shared observations; as in the verdict
    #[arg(long, value_name = "PX")]
    max_spread_px: Option<Positive>,

    /// The most that the std of a parameter may be of its mean: f=1% or k1=0.05
    ///
    /// f stands for every focal length of a model, also for fx and fy.
    #[arg(long, value_delimiter = ',', value_name = "NAME=SHARE,...", value_parser = limits::named_share)]
    max_relative_std: Vec<(String, Share)>,

    /// The least that the verdict must be
    #[arg(long, value_enum, value_name = "VERDICT")]
    verdict: Option<Wanted>,

    /// Limits in a TOML file, for all cameras and for some
    ///
    /// Keys as the options above: `verdict = "repeatable"`, `max-spread-px = 0.5`, `max-relative-std = { f = "1%" }`. A table
    /// [[camera]] has limits of its own for the cameras that its `group` and `camera` fit, exact names or patterns with *.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["max_spread_px", "max_relative_std", "verdict"])]
    limits: Option<PathBuf>,

    /// Exit code 3 also when the 95 % interval of a spread or std has its limit within
    #[arg(long)]
    strict: bool,
}

impl Check {
    pub(super) fn run(self, out: &mut impl Write, quiet: bool) -> Result<(), Failure> {
        let path = match self.analysis.is_dir() {
            true => self.analysis.join("analysis.json"),
            false => self.analysis.clone(),
        };
        let rules = self.rules()?;
        let cameras = judged_cameras(&path)?;
        let found = judge(&cameras, &rules, self.strict);
        let found =
            found.map_err(|error| Failure::Input(format!("{}: {error}", path.display())))?;
        let lines =
            found.breaches.iter().try_for_each(|Breach { text, .. }| writeln!(out, "{text}"));
        // Whoever closes the pipe early must not take a breach for its absence.
        if found.breaches.iter().any(|breach| breach.is_certain) {
            return Err(Failure::Exceeded);
        }
        if !found.breaches.is_empty() {
            return Err(Failure::TooLittle);
        }
        lines?;
        if !quiet {
            let (count, all) = (found.limited, cameras.len());
            let rest = if count < all {
                format!(" of {all}, the others have none")
            } else {
                String::new()
            };
            writeln!(anstream::stderr(), "within all limits: {count} cameras{rest}")?;
        }
        Ok(())
    }

    /// The limits of the file or of the options.
    fn rules(&self) -> Result<Rules, Failure> {
        let rules = match &self.limits {
            Some(file) => limits::read(file).map_err(Failure::Input)?,
            None => {
                let max_relative_std = self.max_relative_std.iter().cloned().collect();
                let Self { max_spread_px, verdict, .. } = *self;
                let general = Limits { verdict, max_spread_px, max_relative_std };
                Rules { general, of_cameras: Vec::new() }
            }
        };
        if rules.general.is_empty() && rules.of_cameras.is_empty() {
            let how =
                "--max-spread-px, --max-relative-std, --verdict or --limits with a limit in it";
            return Err(Failure::Input(format!("no limit is given: {how} does")));
        }
        Ok(rules)
    }
}
