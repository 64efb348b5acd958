//! `calibstab resample`.

use std::io::Write;
use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use rayon::prelude::*;

use super::adjustment::Moving;
use super::failure::Failure;
use super::model;
use super::synth::{nothing_else_is_there, write};
use crate::bundle::{self, Options};
use crate::least_squares::Reason;
use crate::scene::Scene;
use crate::selection::{Candidates, RANDOM, Request, SIGMA_PX, SelectionError, Unit};
use crate::synth::with_redrawn_noise;

/// Make samples out of one reconstruction, for `analyze` to read like runs
///
/// By image: each sample has a part of the images, drawn by chance among those that shared points hold together, with every
/// camera. Samples of one half share half of their images; `analyze` says what that hides. By noise: the model is refined and
/// taken for the truth, and each sample has all its observations with new noise, as large as what the refinement left: this
/// tells how far noise alone moves the calibration, and nothing of a lens model that does not fit.
#[derive(Args)]
pub(super) struct Resample {
    /// A model folder, a run folder with sparse or sparse/0, or a Bundle Adjustment in the Large problem
    model: PathBuf,

    /// What differs between samples: image:SHARE, as in image:0.5, or noise
    #[arg(long, value_name = "image:SHARE|noise")]
    by: By,

    /// The folder to write into: run1, run2, ... in it
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,

    /// How many samples
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(2..))]
    repeats: u32,

    /// Another seed gives other samples
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    #[command(flatten)]
    moving: Moving,
}

/// What differs between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
enum By {
    /// The images: this share of all.
    Image(f64),
    /// The noise.
    Noise,
}

impl FromStr for By {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let share = text.strip_prefix("image:").map(str::parse::<f64>);
        match share {
            Some(Ok(share)) if share > 0.0 && share < 1.0 => Ok(Self::Image(share)),
            None if text == "noise" => Ok(Self::Noise),
            _ => Err("expected noise, or a share of the images such as image:0.5".to_owned()),
        }
    }
}

/// What samples are made of.
enum Source {
    /// A scene of whose images so many are drawn.
    Images { scene: Scene, candidates: Box<Candidates>, size: usize },
    /// A scene that is taken for the truth, and the noise of its pixels.
    Noise { truth: Scene, sigma_px: f64 },
}

impl Resample {
    pub(super) fn run(&self, quiet: bool) -> Result<(), Failure> {
        let (scene, form, mut remarks) = model::read(&self.model)?;
        let failed = |text: String| Failure::Input(format!("{}: {text}", self.model.display()));
        let source = self.source(scene).map_err(failed)?;
        let width = self.repeats.to_string().len();
        let folders: Vec<PathBuf> =
            (1..=self.repeats).map(|run| self.out.join(format!("run{run:0width$}"))).collect();
        nothing_else_is_there(&self.out, &folders)?;
        let sample = |(run, folder): (u32, &PathBuf)| {
            let made = source.sample(self.seed, run.into());
            write(&made.map_err(|error| failed(error.to_string()))?, folder, form)
        };
        let numbered: Vec<(u32, &PathBuf)> = (0..).zip(&folders).collect();
        let written: Vec<Vec<String>> =
            numbered.into_par_iter().map(sample).collect::<Result<_, Failure>>()?;
        remarks.extend(written.concat());
        remarks.sort();
        remarks.dedup();
        let mut talk = anstream::stderr();
        for remark in remarks {
            writeln!(talk, "remark: {remark}")?;
        }
        if !quiet {
            writeln!(talk, "{} runs written to {}", self.repeats, self.out.display())?;
        }
        Ok(())
    }

    fn source(&self, scene: Scene) -> Result<Source, String> {
        let refine = self.moving.chosen();
        match self.by {
            By::Image(share) => {
                let candidates = Candidates::new(&scene, refine, SIGMA_PX);
                let candidates = candidates.map_err(|error| error.to_string())?;
                let count = candidates.image_count();
                let wanted = share * count as f64;
                let size = (1..=count).filter(|&size| size as f64 <= wanted + 0.5).count();
                Ok(Source::Images { scene, candidates: Box::new(candidates), size })
            }
            By::Noise => {
                let options = Options { refine, ..Options::default() };
                let adjusted = bundle::adjust(scene, &options, &mut |_| {});
                let adjusted = adjusted.map_err(|error| error.to_string())?;
                let outcome = adjusted.outcome;
                if !matches!(outcome.reason, Reason::Converged | Reason::Rounding) {
                    return Err("its refinement does not converge: there is no truth".to_owned());
                }
                let sigma_px = outcome.sigma_px;
                let sigma_px = sigma_px.ok_or("no residual is left over: no noise is known")?;
                Ok(Source::Noise { truth: adjusted.scene, sigma_px })
            }
        }
    }
}

impl Source {
    fn sample(&self, seed: u64, run: u64) -> Result<Scene, SelectionError> {
        match self {
            Self::Images { scene, candidates, size } => {
                let pool: Vec<usize> = (0..candidates.image_count()).collect();
                // So that the samples of one seed are not those of the next, one later.
                let seed = seed.wrapping_shl(32).wrapping_add(run);
                let request =
                    Request { pool: &pool, size: *size, seed, unit: Unit::Image, camera: None };
                let chosen = RANDOM.choose(candidates, &request)?;
                let images = chosen.iter().flat_map(|choice| &choice.images);
                Ok(scene.with_images(&images.map(|&image| candidates.image(image)).collect()))
            }
            Self::Noise { truth, sigma_px } => {
                Ok(with_redrawn_noise(truth.clone(), *sigma_px, seed, run))
            }
        }
    }
}
