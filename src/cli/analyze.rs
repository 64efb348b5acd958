//! `calibstab analyze`.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use terminal_size::{Width, terminal_size_of};

use super::adjustment::Adjustment;
use super::failure::Failure;
use super::inputs::Inputs;
use super::output::{OutputFile, plot_files, write_files};
use super::refine_runs;
use crate::report::{self, plot};
use crate::stability::spread::Region;
use crate::stability::{self, Analysis, MatchRule, Options};

/// Report how far the calibrations of repeated reconstructions disagree
///
/// Reads the runs, refines those that have images and points to the optimum, finds out which cameras of different runs are the
/// same, and prints mean, standard deviation and more of every parameter of each camera in each group of runs: as refined, and
/// beside that as COLMAP left them.
#[derive(Args)]
pub(super) struct Analyze {
    #[command(flatten)]
    inputs: Inputs,

    /// How cameras of different runs are matched [default: by the images they took, else by CAMERA_ID]
    #[arg(long = "match", value_enum, value_name = "RULE")]
    match_by: Option<Match>,

    /// Take all cameras of a run for one physical camera (COLMAP's one camera for each image)
    #[arg(long, conflicts_with = "match_by")]
    pool: bool,

    /// Leave runs out of the statistics that are flagged: impossible cameras, far fewer images than the others
    #[arg(long)]
    exclude_flagged: bool,

    /// Over which part of the image the spread is: observed, all, or center:0.8 (that share of width and height)
    ///
    /// By default what at least half of the runs observed; without images, the whole image.
    #[arg(long, value_name = "REGION")]
    region: Option<Region>,

    /// Take the parameters as COLMAP left them, also where images and points would let them be refined
    #[arg(long, conflicts_with_all = ["refine", "prior", "bound", "loss", "mode", "stop"])]
    no_refine: bool,

    /// Write a report into this folder
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,

    /// What the report consists of [default: all]
    #[arg(long, value_enum, value_delimiter = ',', requires = "out", value_name = "FORMAT,...")]
    format: Vec<Format>,

    #[command(flatten)]
    how: Adjustment,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Match {
    /// By image names in common, else a common folder, else a common pattern of names
    Images,
    /// By CAMERA_ID
    Id,
    /// The only camera of each run
    Single,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// analysis.json: everything, maps in single precision, all else in full (see `calibstab schema`)
    Json,
    /// runs.csv, samples.csv, statistics.csv, spread.csv, prediction.csv, held.csv, residuals.csv and others
    Csv,
    /// report.md
    Md,
    /// plots/*.svg
    Svg,
    /// plots/*.png
    Png,
}

impl Analyze {
    pub(super) fn run(self, out: &mut impl Write, quiet: bool) -> Result<(), Failure> {
        let options = Options {
            match_by: self.match_by.map(Match::rule),
            pool: self.pool,
            exclude_flagged: self.exclude_flagged,
            region: self.region,
            refinement: (!self.no_refine).then(|| self.how.record()),
            ..self.inputs.options()?
        };
        let (mut runs, skipped) = self.inputs.read(quiet)?;
        if !self.no_refine {
            let count = refine_runs::refine(&mut runs, &self.how.options(), self.region, quiet)?;
            if count == 0 && self.how.is_asked_for() {
                let why = "no group has images and points in all of its runs";
                writeln!(anstream::stderr(), "remark: nothing was refined: {why}")?;
            }
        }
        let analysis = stability::analyze(runs, skipped, options)
            .map_err(|error| Failure::Input(error.to_string()))?;
        if let Some(folder) = &self.out {
            let formats =
                if self.format.is_empty() { Format::value_variants() } else { &self.format };
            let files = report_files(&analysis, formats)?;
            write_files(folder, &files)?;
            if !quiet {
                writeln!(
                    anstream::stderr(),
                    "{} files written to {}",
                    files.len(),
                    folder.display()
                )?;
            }
        }
        let width = terminal_size_of(std::io::stdout()).map(|(Width(width), _)| width.into());
        Ok(out.write_all(report::terminal(&analysis, width).as_bytes())?)
    }
}

impl Match {
    pub(super) fn rule(self) -> MatchRule {
        match self {
            Self::Images => MatchRule::Images,
            Self::Id => MatchRule::Id,
            Self::Single => MatchRule::Single,
        }
    }
}

type CsvTable = fn(&Analysis) -> csv::Result<Vec<u8>>;

const CSV_TABLES: [(&str, CsvTable); 10] = [
    ("comparisons.csv", report::comparisons_csv),
    ("components.csv", report::components_csv),
    ("runs.csv", report::runs_csv),
    ("samples.csv", report::samples_csv),
    ("statistics.csv", report::statistics_csv),
    ("spread.csv", report::spread_csv),
    ("prediction.csv", report::prediction_csv),
    ("held.csv", report::held_csv),
    ("residuals.csv", report::residuals_csv),
    ("run_deviations.csv", report::run_deviations_csv),
];

/// The files of a report.
fn report_files(analysis: &Analysis, formats: &[Format]) -> Result<Vec<OutputFile>, Failure> {
    let failed =
        |error: &dyn std::error::Error| Failure::Input(format!("the report failed: {error}"));
    let mut files: Vec<OutputFile> = Vec::new();
    let wants = |format| formats.contains(&format);
    if wants(Format::Json) {
        let json = report::analysis_json(analysis).map_err(|error| failed(&error))?;
        files.push(("analysis.json".into(), json.into_bytes()));
    }
    if wants(Format::Csv) {
        for (name, table) in CSV_TABLES {
            files.push((name.into(), table(analysis).map_err(|error| failed(&error))?));
        }
    }
    let figures = if wants(Format::Svg) || wants(Format::Png) {
        plot::figures(analysis).map_err(|error| failed(&error))?
    } else {
        Vec::new()
    };
    let pictures: Vec<(String, String)> = figures
        .iter()
        .map(|figure| {
            let ending = if wants(Format::Svg) { "svg" } else { "png" };
            (format!("plots/{}.{ending}", figure.stem), figure.title.clone())
        })
        .collect();
    if wants(Format::Md) {
        files.push(("report.md".into(), report::markdown(analysis, &pictures).into_bytes()));
    }
    files.extend(plot_files(&figures, wants(Format::Svg), wants(Format::Png))?);
    Ok(files)
}
