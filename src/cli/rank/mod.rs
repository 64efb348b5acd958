//! `calibstab rank`.

mod journal;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::adjustment::Moving;
use super::failure::Failure;
use super::inputs::{input_file, progress_bar, read_all};
use super::output::{OutputFile, plot_files, write_files};
use super::pools::{on_pools, pools};
use super::select::{Aim, heuristics};
use crate::report::{self, plot};
use crate::selection::experiment::{Draw, Experiment, Input, Plan, Pool, Sample, Selection, Told};
use crate::selection::{HEURISTICS, Heuristic, experiment};
use crate::{colmap, stability};
use journal::Journal;

/// Find out which rule chooses the images that calibrate best
///
/// From each model, again and again: draws a pool of its images, and noise for all pixels; lets every rule choose from the same
/// pool; adjusts what was chosen; and compares the intrinsics with those of the full reconstruction. Tells the error of each rule
/// at each size, which is better than which, and whether that is certain. Repeats of one scene are ranked together.
#[derive(Args)]
pub(super) struct Rank {
    /// A model folder, a run folder with sparse or sparse/0, a folder of any of these, or a quoted glob
    #[arg(value_name = "PATH", required = true)]
    models: Vec<PathBuf>,

    /// How many images are chosen
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "8,12,20,30", value_parser = clap::value_parser!(u32).range(2..))]
    sizes: Vec<u32>,

    /// How often, of each model and at each size
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(2..))]
    repeats: u32,

    /// Another seed draws other pools, noise and starts
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    /// From what is chosen: a share of the images by chance, as random:0.5, or so many in a row, as window:100
    #[arg(long, value_name = "random:SHARE|window:N", default_value = "random:0.5")]
    pool: Pool,

    /// Whether repeats differ by their noise too
    #[arg(long, value_enum, default_value = "redraw")]
    noise: Noise,

    /// Which rules [default: all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = heuristics())]
    heuristics: Vec<&'static Heuristic>,

    #[command(flatten)]
    aim: Aim,

    /// What is known of the cameras, by CAMERA_ID: a cameras file or a model folder [default: the full reconstruction]
    #[arg(long, value_name = "PATH")]
    truth: Option<PathBuf>,

    /// The error for which the smallest size is sought
    #[arg(long, value_name = "PX")]
    target_px: Option<f64>,

    #[command(flatten)]
    moving: Moving,

    /// Write the report into this folder
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,

    /// Go on with what was interrupted
    #[arg(long)]
    resume: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Noise {
    /// Each repeat sees the real geometry with noise of its own
    Redraw,
    /// All see what was measured
    Keep,
}

impl Rank {
    pub(super) fn run(self, out: &mut impl Write, quiet: bool) -> Result<(), Failure> {
        let mut talk = anstream::stderr();
        let models = self.models(quiet)?;
        for model in &models {
            for remark in &model.remarks {
                writeln!(talk, "remark: {}: {remark}", model.name)?;
            }
        }
        let inputs = self.inputs(models)?;
        let experiment = Experiment::new(self.plan(), inputs)
            .map_err(|(name, error)| Failure::Input(format!("{name}: {error}")))?;
        for remark in experiment.skipped() {
            writeln!(talk, "remark: {remark}")?;
        }
        let told = self.told()?;
        let draws = experiment.draws();
        if draws.is_empty() {
            return Err(Failure::Input("no size is left: there is nothing to try".to_owned()));
        }
        let (journal, done) =
            Journal::open(&self.out, &experiment.fingerprint(&told), self.resume)?;
        let samples = run(&experiment, &draws, &journal, done, quiet)?;
        let selection = experiment.result(samples, told);
        let files = files(&selection)?;
        write_files(&self.out, &files)?;
        journal.close()?;
        if !quiet {
            writeln!(talk, "{} files written to {}", files.len(), self.out.display())?;
        }
        Ok(out.write_all(report::ranking_text(&selection).as_bytes())?)
    }

    fn models(&self, quiet: bool) -> Result<Vec<stability::Run>, Failure> {
        read_all(self.models.clone(), quiet)
    }

    fn inputs(&self, models: Vec<stability::Run>) -> Result<Vec<Input>, Failure> {
        let truth = match &self.truth {
            None => BTreeMap::new(),
            Some(path) => {
                colmap::read(path).map_err(|error| Failure::Input(error.to_string()))?.cameras
            }
        };
        let input = |run: stability::Run| {
            let stability::Run { name, files, scene, .. } = run;
            Input { name, files, scene, truth: truth.clone() }
        };
        Ok(models.into_iter().map(input).collect())
    }

    fn plan(&self) -> Plan {
        let mut sizes: Vec<usize> = self.sizes.iter().map(|&size| size as usize).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let mut heuristics: Vec<&'static Heuristic> = HEURISTICS.iter().collect();
        if !self.heuristics.is_empty() {
            let is_wanted =
                |own: &&Heuristic| self.heuristics.iter().any(|wanted| wanted.name == own.name);
            heuristics.retain(is_wanted);
        }
        Plan {
            heuristics,
            sizes,
            repeats: self.repeats as usize,
            seed: self.seed,
            pool: self.pool,
            noise: match self.noise {
                Noise::Redraw => experiment::Noise::Redraw,
                Noise::Keep => experiment::Noise::Keep,
            },
            refine: self.moving.chosen(),
            unit: self.aim.unit(),
            camera: self.aim.camera(),
            target_px: self.target_px,
        }
    }

    fn told(&self) -> Result<Told, Failure> {
        let cameras_file = |path: &Path| {
            let model = colmap::find_one(path).map_err(|error| error.to_string())?;
            input_file(&model.cameras)
        };
        let truth = self.truth.as_deref().map(cameras_file).transpose().map_err(Failure::Input)?;
        Ok(Told { refine: self.moving.record(), truth })
    }
}

/// All samples: those that were done before, and those of the draws that are left, written down as they come.
fn run(
    experiment: &Experiment,
    draws: &[Draw],
    journal: &Journal,
    done: Vec<Vec<Sample>>,
    quiet: bool,
) -> Result<Vec<Sample>, Failure> {
    let is_done = |draw: &&Draw| done.iter().any(|samples| samples[0].draw == **draw);
    let mut left: Vec<Draw> = draws.iter().filter(|draw| !is_done(draw)).copied().collect();
    // The longest first, so that none is left over for one thread at the end.
    left.sort_by_key(|draw| std::cmp::Reverse(draw.size));
    let weight = |draws: &[Draw]| draws.iter().map(|draw| draw.size).sum::<usize>();
    let progress = progress_bar("calibrating", weight(draws), quiet);
    progress.set_position((weight(draws) - weight(&left)) as u64);
    progress.reset_eta();
    let threads = rayon::current_num_threads();
    let new = on_pools(pools(threads, threads)?, &left, |&draw| {
        let samples = experiment.run(draw);
        progress.inc(draw.size as u64);
        journal.add(&samples).map(|()| samples)
    });
    progress.finish_and_clear();
    let new: Vec<Vec<Sample>> = new.into_iter().collect::<Result<_, Failure>>()?;
    Ok(done.into_iter().chain(new).flatten().collect())
}

fn files(selection: &Selection) -> Result<Vec<OutputFile>, Failure> {
    let failed =
        |error: &dyn std::error::Error| Failure::Input(format!("the report failed: {error}"));
    let json = report::selection_json(selection).map_err(|error| failed(&error))?;
    let cells = report::cells_csv(selection).map_err(|error| failed(&error))?;
    let choices = report::choices_csv(selection).map_err(|error| failed(&error))?;
    let figures = plot::selection_figures(selection).map_err(|error| failed(&error))?;
    let picture = |it: &plot::Figure| (format!("plots/{}.svg", it.stem), it.title.clone());
    let pictures: Vec<(String, String)> = figures.iter().map(picture).collect();
    let markdown = report::ranking_markdown(selection, &pictures);
    let mut files: Vec<OutputFile> = vec![
        ("selection.json".into(), json.into_bytes()),
        ("cells.csv".into(), cells),
        ("choices.csv".into(), choices),
        ("report.md".into(), markdown.into_bytes()),
    ];
    files.extend(plot_files(&figures, true, true)?);
    Ok(files)
}
