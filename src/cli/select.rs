//! `calibstab select`.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use super::adjustment::Moving;
use super::failure::Failure;
use super::model;
use super::output::write_files;
use crate::scene::{CameraId, ImageId};
use crate::selection::{self, Candidates, HEURISTICS, Heuristic, RECOMMENDED, Request, SIGMA_PX};
use crate::{colmap, report};

/// Choose the images that calibrate a camera best
///
/// Reads a model with images and points and chooses a part of its images by a rule, each with the reason. Whatever the rule,
/// shared points hold those chosen together, and every camera whose intrinsics are wanted is among them.
#[derive(Args)]
pub(super) struct Select {
    /// A model folder, a run folder with sparse or sparse/0, or a Bundle Adjustment in the Large problem
    model: PathBuf,

    /// How many to choose
    #[arg(long, value_name = "N")]
    size: usize,

    /// By which rule
    #[arg(long, value_name = "NAME", default_value = RECOMMENDED, value_parser = heuristics())]
    heuristic: &'static Heuristic,

    #[command(flatten)]
    aim: Aim,

    /// Another seed gives another start or draw, where the rule has one
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    #[command(flatten)]
    moving: Moving,

    /// Write the names of the images into this file, one a line, as COLMAP's image list has them
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Write the images with what they see into this folder, as a model
    #[arg(long, value_name = "FOLDER")]
    write_model: Option<PathBuf>,
}

/// What is chosen, and for which camera.
#[derive(Args)]
pub(super) struct Aim {
    /// What is chosen and counted
    #[arg(long, value_enum, default_value = "image")]
    unit: Unit,

    /// The camera whose intrinsics are wanted, by its CAMERA_ID [default: all cameras]
    #[arg(long, value_name = "ID")]
    camera: Option<u32>,
}

impl Aim {
    pub(super) fn unit(&self) -> selection::Unit {
        match self.unit {
            Unit::Image => selection::Unit::Image,
            Unit::Frame => selection::Unit::Frame,
        }
    }

    pub(super) fn camera(&self) -> Option<CameraId> {
        self.camera.map(CameraId)
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum Unit {
    /// Images
    Image,
    /// All images that a rig took at once
    Frame,
}

pub(super) fn heuristics() -> impl TypedValueParser<Value = &'static Heuristic> {
    let value = |it: &Heuristic| PossibleValue::new(it.name).help(it.summary);
    PossibleValuesParser::new(HEURISTICS.iter().map(value))
        .try_map(|name| Heuristic::named(&name).ok_or(format!("no rule is called {name}")))
}

impl Select {
    pub(super) fn run(self, out: &mut impl Write, quiet: bool) -> Result<(), Failure> {
        let failed = |error: &dyn std::error::Error| {
            Failure::Input(format!("{}: {error}", self.model.display()))
        };
        let (scene, form, remarks) = model::read(&self.model)?;
        let mut talk = anstream::stderr();
        for remark in &remarks {
            writeln!(talk, "remark: {remark}")?;
        }
        let candidates = Candidates::new(&scene, self.moving.chosen(), SIGMA_PX)
            .map_err(|error| failed(&error))?;
        let pool: Vec<usize> = (0..candidates.image_count()).collect();
        let request = Request {
            pool: &pool,
            size: self.size,
            seed: self.seed,
            unit: self.aim.unit(),
            camera: self.aim.camera(),
        };
        let choices =
            self.heuristic.choose(&candidates, &request).map_err(|error| failed(&error))?;
        let chosen = || choices.iter().flat_map(|choice| choice.images.iter().copied());
        if let Some(path) = &self.out {
            let names: String =
                chosen().map(|image| format!("{}\n", candidates.name(image))).collect();
            write_files("".as_ref(), &[(path.clone(), names.into_bytes())])?;
        }
        if let Some(folder) = &self.write_model {
            let kept: BTreeSet<ImageId> = chosen().map(|image| candidates.image(image)).collect();
            let written = colmap::write(&scene.with_images(&kept), folder, form);
            let written = written.map_err(|error| Failure::Input(error.to_string()))?;
            for remark in &written.remarks {
                writeln!(talk, "remark: {remark}")?;
            }
            if !quiet {
                let count = written.files.len();
                writeln!(talk, "{count} files written to {}", folder.display())?;
            }
        }
        Ok(out.write_all(report::selection_text(&candidates, &choices).as_bytes())?)
    }
}
