//! `calibstab synth`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;

use super::failure::Failure;
use crate::camera::Model;
use crate::colmap::{self, Form};
use crate::scene::{Camera, Scene};
use crate::synth::{self, Options, Synthetic};

/// Make reconstructions of a synthetic room, with known truth
///
/// Images are taken all round a room of 10 m, looking across it, the camera rolled. A run holds their pixels with noise, and
/// estimates that are off as before a last bundle adjustment; beside it, in truth, is the same without any error. The same
/// arguments give the same files.
#[derive(Args)]
pub(super) struct Synth {
    /// The folder to write into; with --repeats, into run1, run2, ... in it
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,

    /// A camera model, with its parameters in COLMAP's order or a usual lens; several cameras take the images in turn
    #[arg(long, value_name = "MODEL[:PARAM,...]", default_value = "OPENCV")]
    camera: Vec<Lens>,

    /// Width and height of the images, in px
    #[arg(long, value_name = "WxH", default_value = "1280x960")]
    size: Size,

    /// How many images are taken
    #[arg(long, value_name = "N", default_value_t = Options::default().image_count, value_parser = clap::value_parser!(u32).range(1..))]
    images: u32,

    /// How many points there are in the room
    #[arg(long, value_name = "N", default_value_t = Options::default().point_count)]
    points: u32,

    /// How many points an image sees at most
    #[arg(long, value_name = "N", default_value_t = Options::default().most_per_image)]
    per_image: u32,

    /// Degrees off the axis beyond which no camera sees
    #[arg(long, value_name = "DEGREES", default_value_t = Options::default().widest_degrees)]
    max_angle: f64,

    /// Standard deviation of x and of y, in px
    #[arg(long, value_name = "PX", default_value_t = Options::default().noise_px)]
    noise: f64,

    /// How far off a run is: focal lengths and distortion by this share of themselves, places by as many m, rotations by as
    /// many tenths of a radian
    #[arg(long, value_name = "SHARE", default_value_t = Options::default().start_off)]
    start_off: f64,

    /// Another seed gives another room
    #[arg(long, value_name = "N", default_value_t = Options::default().seed)]
    seed: u64,

    /// Make so many runs of the same cameras in the same room, each with images, noise and start of its own
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    repeats: Option<u32>,

    /// Give all runs the same images: only their noise and start differ
    #[arg(long, requires = "repeats")]
    same_views: bool,

    /// Write cameras.bin, images.bin, ... instead of text
    #[arg(long)]
    binary: bool,
}

/// A camera model as typed.
#[derive(Clone)]
struct Lens {
    model: &'static Model,
    params: Option<Vec<f64>>,
}

#[derive(Clone, Copy)]
struct Size {
    width: u32,
    height: u32,
}

impl Synth {
    pub(super) fn run(&self, quiet: bool) -> Result<(), Failure> {
        let form = if self.binary { Form::Binary } else { Form::Text };
        let cameras =
            self.camera.iter().map(|lens| lens.camera(self.size)).collect::<Result<Vec<_>, _>>()?;
        let folders: Vec<PathBuf> = match self.repeats {
            Some(count) => {
                (1..=count).map(|number| self.out.join(format!("run{number}"))).collect()
            }
            None => vec![self.out.clone()],
        };
        nothing_else_is_there(&self.out, &folders)?;
        let mut talk = anstream::stderr();
        for (folder, run) in folders.iter().zip(0..) {
            let made = synth::make(&self.options(&cameras, run));
            let Synthetic { truth, run, remarks } =
                made.map_err(|error| Failure::Input(error.to_string()))?;
            let of_form = write(&run, folder, form)?;
            write(&truth, &folder.join("truth"), form)?;
            for remark in remarks.iter().chain(&of_form) {
                writeln!(talk, "remark: {}: {remark}", folder.display())?;
            }
        }
        if !quiet {
            let (count, out) = (folders.len(), self.out.display());
            let runs = if count == 1 { "run" } else { "runs" };
            writeln!(
                talk,
                "{count} {runs} written to {out}, each with its truth in its folder truth"
            )?;
        }
        Ok(())
    }

    fn options(&self, cameras: &[Camera], run: u32) -> Options {
        Options {
            cameras: cameras.to_vec(),
            image_count: self.images,
            point_count: self.points,
            most_per_image: self.per_image,
            widest_degrees: self.max_angle,
            noise_px: self.noise,
            start_off: self.start_off,
            seed: self.seed,
            run,
            own_views: !self.same_views,
            ..Options::default()
        }
    }
}

/// What an earlier call left would be taken for a run of this one.
pub(super) fn nothing_else_is_there(out: &Path, folders: &[PathBuf]) -> Result<(), Failure> {
    if !out.exists() {
        return Ok(());
    }
    let found = match colmap::find(out) {
        Ok(found) => found,
        Err(colmap::ReadError::NoModel { .. }) => return Ok(()),
        Err(error) => return Err(Failure::Input(error.to_string())),
    };
    match found.iter().find(|model| !folders.iter().any(|folder| folder == model.folder())) {
        None => Ok(()),
        Some(other) => Err(Failure::Input(format!(
            "{}: this model would be taken for one of the new runs; remove it, or write elsewhere",
            other.folder().display()
        ))),
    }
}

pub(super) fn write(scene: &Scene, folder: &Path, form: Form) -> Result<Vec<String>, Failure> {
    match colmap::write(scene, folder, form) {
        Ok(written) => Ok(written.remarks),
        Err(error) => Err(Failure::Input(error.to_string())),
    }
}

impl Lens {
    fn camera(&self, size: Size) -> Result<Camera, Failure> {
        let (width, height) = (size.width.into(), size.height.into());
        let Some(params) = &self.params else {
            let no_lens = || {
                Failure::Input(format!(
                    "no usual lens is known for {}: give its parameters",
                    self.model.name
                ))
            };
            return synth::camera(self.model, width, height).ok_or_else(no_lens);
        };
        let intrinsics = self.model.with_params(params);
        let intrinsics = intrinsics.map_err(|error| Failure::Input(error.to_string()))?;
        Ok(Camera { intrinsics, width, height })
    }
}

impl FromStr for Lens {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, params) = match text.split_once(':') {
            Some((name, params)) => (name, Some(params)),
            None => (text, None),
        };
        let model = Model::named(name).map_err(|error| error.to_string())?;
        let number = |text: &str| {
            text.trim().parse::<f64>().map_err(|_| format!("`{text}` is not a number"))
        };
        let params = params.map(|params| params.split(',').map(number).collect()).transpose()?;
        Ok(Self { model, params })
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides = text.split_once('x').map(|(width, height)| (width.parse(), height.parse()));
        match sides {
            Some((Ok(width), Ok(height))) if width > 0 && height > 0 => Ok(Self { width, height }),
            _ => Err("expected width and height in px, such as 1280x960".to_owned()),
        }
    }
}
