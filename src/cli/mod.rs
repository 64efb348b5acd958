//! The command line: arguments, progress, printing, exit codes; one file a subcommand.

mod adjustment;
mod analyze;
mod check;
mod compare;
mod convert;
mod copy;
mod explain;
mod failure;
mod grouping;
mod help;
mod inputs;
mod inspect;
mod limits;
mod model;
mod models;
mod output;
mod pools;
mod rank;
mod refine;
mod refine_runs;
mod refined;
mod resample;
mod select;
mod synth;

use std::io::Write;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use failure::Failure;

/// How repeatable is the camera calibration that COLMAP gave you?
///
/// Reconstruct the same camera several times (another seed, other images, another matcher), then ask how far the
/// calibrations disagree.
#[derive(Parser)]
#[command(name = "calibstab", version, max_term_width = 100, after_long_help = help::LONG)]
struct Cli {
    #[command(subcommand)]
    command: Command,

    /// Say nothing on stderr but errors: no progress, no list of files written
    #[arg(long, short, global = true)]
    quiet: bool,

    /// Threads to use; the result is the same for any number [default: one a core]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

#[derive(Subcommand)]
enum Command {
    Analyze(analyze::Analyze),
    Check(check::Check),
    Inspect(inspect::Inspect),
    Convert(convert::Convert),
    Models(models::Models),
    Compare(compare::Compare),
    Copy(copy::Copy),
    Synth(synth::Synth),
    Refine(refine::Refine),
    Select(select::Select),
    Rank(rank::Rank),
    Resample(resample::Resample),
    Explain(explain::Explain),
    Schema(help::Schema),
    Completions(help::Completions),
    Man(help::Man),
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => error.exit(),
    };
    let mut out = anstream::stdout().lock();
    let done = cli.run(&mut out).and_then(|()| Ok(out.flush()?));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

impl Cli {
    fn run(self, out: &mut impl Write) -> Result<(), Failure> {
        let threads = self.threads.unwrap_or(0).into();
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .map_err(|error| Failure::Input(error.to_string()))?;
        match self.command {
            Command::Analyze(command) => command.run(out, self.quiet),
            Command::Check(command) => command.run(out, self.quiet),
            Command::Inspect(command) => command.run(out),
            Command::Convert(command) => command.run(out, self.quiet),
            Command::Models(command) => command.run(out),
            Command::Compare(command) => command.run(out, self.quiet),
            Command::Copy(command) => command.run(self.quiet),
            Command::Synth(command) => command.run(self.quiet),
            Command::Refine(command) => command.run(out, self.quiet),
            Command::Select(command) => command.run(out, self.quiet),
            Command::Rank(command) => command.run(out, self.quiet),
            Command::Resample(command) => command.run(self.quiet),
            Command::Explain(command) => command.run(out),
            Command::Schema(command) => command.run(out),
            Command::Completions(command) => command.run(out),
            Command::Man(command) => command.run(out),
        }
    }
}
