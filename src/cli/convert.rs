//! `calibstab convert`.

use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::failure::Failure;
use super::inspect::{read_cameras, size};
use crate::camera::Model;
use crate::colmap::{self, Form};
use crate::convert::{Converted, Folds, How, convert};
use crate::scene::{Camera, CameraId};

/// Write cameras in another model, and say how well that says the same
///
/// A model that contains the camera's own takes its parameters over: exact, no pixel of the image moves. Any other is fitted to
/// the rays of the image by least squares, and the error stated in px. What would mean nothing is refused: a lens that folds
/// inside its image, an angle that the model cannot see.
#[derive(Args)]
pub(super) struct Convert {
    /// A cameras file, a model folder, or a run folder with sparse or sparse/0; its cameras alone are read
    cameras: PathBuf,

    /// The model to write (see `calibstab models`)
    #[arg(long, value_name = "MODEL", value_parser = Model::named)]
    to: &'static Model,

    /// The file to write, .txt or .bin
    #[arg(long, value_name = "FILE", value_parser = CamerasFile::parse)]
    out: CamerasFile,

    /// Convert these cameras alone, the others stay as they are
    #[arg(long, value_name = "ID,...", value_delimiter = ',')]
    camera: Vec<u32>,

    /// Of a lens that folds inside its image, fit what has a ray, and leave out the rest
    #[arg(long)]
    allow_fold: bool,
}

/// A cameras file to be written, whose ending tells its form.
#[derive(Debug, Clone)]
struct CamerasFile {
    path: PathBuf,
    form: Form,
}

impl CamerasFile {
    fn parse(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase);
        let form = match ending.as_deref() {
            Some("txt") => Form::Text,
            Some("bin") => Form::Binary,
            _ => return Err("the name must end in .txt or .bin".to_owned()),
        };
        Ok(Self { path, form })
    }
}

impl Convert {
    pub(super) fn run(self, out: &mut impl Write, quiet: bool) -> Result<(), Failure> {
        let mut cameras = read_cameras(&self.cameras)?;
        for id in &self.camera {
            if !cameras.contains_key(&CameraId(*id)) {
                let at = self.cameras.display();
                return Err(Failure::Input(format!("{at}: there is no camera {id}")));
            }
        }
        let folds = if self.allow_fold { Folds::LeftOut } else { Folds::Refused };
        let (mut said, mut refused) = (String::new(), String::new());
        for (id, camera) in &mut cameras {
            if !self.camera.is_empty() && !self.camera.contains(&id.0) {
                continue;
            }
            let from = camera.intrinsics.model().name;
            match convert(&camera.intrinsics, size(*id, camera)?, self.to, folds) {
                Ok(converted) => {
                    camera.intrinsics = converted.intrinsics;
                    let _ = writeln!(said, "camera {id}  {from} -> {}", told(&converted, camera));
                }
                Err(error) => {
                    let _ = writeln!(refused, "camera {id}  {from} -> {}: {error}", self.to.name);
                }
            }
        }
        if !refused.is_empty() {
            let hint =
                "nothing is written; --camera chooses cameras, --allow-fold fits what has a ray";
            return Err(Failure::Input(refused + hint));
        }
        let written = colmap::write_cameras(&cameras, &self.out.path, self.out.form)
            .map_err(|error| Failure::Input(error.to_string()))?;
        let mut talk = anstream::stderr();
        for remark in &written.remarks {
            writeln!(talk, "remark: {remark}")?;
        }
        if !quiet {
            writeln!(talk, "{} camera(s) written to {}", cameras.len(), self.out.path.display())?;
        }
        Ok(out.write_all(said.as_bytes())?)
    }
}

/// How well it says the same, and what it says.
fn told(converted: &Converted, camera: &Camera) -> String {
    let model = camera.intrinsics.model();
    let how = match converted.how {
        How::Exact => "exact".to_owned(),
        How::Fitted(fit) => format!(
            "fitted, rms {} px, max {} px, over {:.1} % of the image, up to {:.1}° from the axis",
            px(fit.rms_px),
            px(fit.max_px),
            100.0 * fit.seen_share,
            fit.largest_angle.to_degrees()
        ),
    };
    format!("{}: {how}\n{}", model.name, super::inspect::params(&camera.intrinsics))
}

/// Three digits: 12.3, 0.0123, 1.23e-6.
fn px(value: f64) -> String {
    if value >= 100.0 {
        return format!("{value:.0}");
    }
    match value {
        10.0.. => format!("{value:.1}"),
        1.0.. => format!("{value:.2}"),
        0.1.. => format!("{value:.3}"),
        0.01.. => format!("{value:.4}"),
        0.001.. => format!("{value:.5}"),
        _ => format!("{value:.2e}"),
    }
}
