//! How to adjust, as arguments of `refine` and `analyze`.

use std::fmt;
use std::fs;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

use super::limits;
use crate::bundle::{self, Bound, Loss, Options, Prior, Refine as Chosen, Which};
use crate::camera::ParamClass;
use crate::least_squares::{self, Stop};
use crate::scene::CameraId;
use crate::stability::RefinementOptions;

/// Which intrinsics move.
#[derive(Args)]
pub(super) struct Moving {
    /// Which intrinsics move: focal, principal-point, extra, all, none, or names; for one camera as in 1:fx,k1
    /// [default: focal,extra]
    #[arg(long, value_name = "[CAMERA:]WHICH,...", value_parser = Wish::parse)]
    refine: Vec<Wish>,
}

/// How to adjust.
#[derive(Args)]
#[command(next_help_heading = "How to refine")]
pub(super) struct Adjustment {
    #[command(flatten)]
    moving: Moving,

    /// What is known of an intrinsic beforehand, with its std, as in fx=800+-5; for one camera as in 1:fx=800+-5
    ///
    /// One more residual: of 1 px for each std that the parameter is off.
    #[arg(long, value_name = "[CAMERA:]NAME=MEAN+-STD", value_parser = limits::prior)]
    prior: Vec<Prior>,

    /// Between which values an intrinsic stays, as in k1=-0.5..0.5 or 1:k1=..0.5
    #[arg(long, value_name = "[CAMERA:]NAME=LEAST..MOST", value_parser = limits::bound)]
    bound: Vec<Bound>,

    /// What a residual costs: squared, or huber, soft-l1, cauchy with their scale in px, as in cauchy:1
    #[arg(long, value_name = "LOSS[:SCALE]", default_value = "squared", value_parser = parse_loss)]
    loss: Loss,

    /// What moves
    #[arg(long, value_enum, default_value = "self-calibration")]
    mode: Mode,

    /// When to stop
    #[arg(long, value_enum, value_name = "RULE", default_value = "decrement")]
    stop: Rule,
}

#[derive(Clone, Copy, ValueEnum)]
enum Mode {
    /// Poses, points and intrinsics
    SelfCalibration,
    /// Poses and points
    BundleAdjustment,
    /// Poses alone
    OnlyPose,
    /// Points alone
    OnlyLandmarks,
    /// Intrinsics alone
    OnlyIntrinsics,
}

#[derive(Clone, Copy, ValueEnum)]
enum Rule {
    /// When no intrinsic would move by a millionth of its standard deviation
    Decrement,
    /// COLMAP's: gradient_tolerance 1e-4, function_tolerance 0, parameter_tolerance 0
    Colmap,
}

/// What one `--refine` asks for.
#[derive(Debug, Clone)]
struct Wish {
    text: String,
    camera: Option<CameraId>,
    which: Vec<Which>,
}

impl fmt::Display for Wish {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Adjustment {
    /// The same for the library.
    pub(super) fn options(&self) -> Options {
        Options {
            mode: match self.mode {
                Mode::SelfCalibration => bundle::Mode::SelfCalibration,
                Mode::BundleAdjustment => bundle::Mode::BundleAdjustment,
                Mode::OnlyPose => bundle::Mode::OnlyPose,
                Mode::OnlyLandmarks => bundle::Mode::OnlyLandmarks,
                Mode::OnlyIntrinsics => bundle::Mode::OnlyIntrinsics,
            },
            refine: self.moving.chosen(),
            loss: self.loss,
            priors: self.prior.clone(),
            bounds: self.bound.clone(),
            stop: match self.stop {
                Rule::Decrement => least_squares::Options::default(),
                Rule::Colmap => {
                    let stop = Stop::Tolerances { function: 0.0, gradient: 1e-4, parameter: 0.0 };
                    least_squares::Options { stop, max_iterations: 100 }
                }
            },
            memory: available_memory(),
        }
    }

    /// Whether anything but the defaults was asked for.
    pub(super) fn is_asked_for(&self) -> bool {
        let is_default = self.moving.refine.is_empty()
            && self.loss == Loss::Squared
            && matches!((self.mode, self.stop), (Mode::SelfCalibration, Rule::Decrement));
        !is_default
    }

    /// The same for the record.
    pub(super) fn record(&self) -> RefinementOptions {
        let name = |value: &dyn Fn() -> Option<PossibleValue>| {
            value().map_or_else(String::new, |value| value.get_name().to_owned())
        };
        RefinementOptions {
            mode: name(&|| self.mode.to_possible_value()),
            refine: self.moving.record(),
            priors: self.prior.iter().map(Prior::to_string).collect(),
            bounds: self.bound.iter().map(Bound::to_string).collect(),
            loss: match self.loss {
                Loss::Squared => "squared".to_owned(),
                Loss::Huber(px) => format!("huber:{px}"),
                Loss::SoftL1(px) => format!("soft-l1:{px}"),
                Loss::Cauchy(px) => format!("cauchy:{px}"),
            },
            stop: name(&|| self.stop.to_possible_value()),
        }
    }
}

impl Moving {
    /// The same for the record.
    pub(super) fn record(&self) -> Vec<String> {
        match self.refine.as_slice() {
            [] => vec!["focal".to_owned(), "extra".to_owned()],
            wishes => wishes.iter().map(Wish::to_string).collect(),
        }
    }

    /// The same for the library.
    pub(super) fn chosen(&self) -> Chosen {
        let mut chosen = Chosen::default();
        let for_others: Vec<&Wish> =
            self.refine.iter().filter(|wish| wish.camera.is_none()).collect();
        if !for_others.is_empty() {
            chosen.others = for_others.iter().flat_map(|wish| wish.which.clone()).collect();
        }
        for wish in &self.refine {
            if let Some(camera) = wish.camera {
                chosen.cameras.entry(camera).or_default().extend(wish.which.clone());
            }
        }
        chosen
    }
}

impl Wish {
    fn parse(text: &str) -> Result<Self, String> {
        let (camera, names) = match text.split_once(':') {
            Some((id, names)) => {
                let id =
                    id.trim().parse().map_err(|_| format!("`{id}` is not the id of a camera"))?;
                (Some(CameraId(id)), names)
            }
            None => (None, text),
        };
        let mut which = Vec::new();
        for name in names.split(',').map(str::trim) {
            let classes: &[ParamClass] = match name {
                "focal" => &[ParamClass::Focal],
                "principal-point" => &[ParamClass::PrincipalPoint],
                "extra" => &[ParamClass::Extra],
                "all" => &[ParamClass::Focal, ParamClass::PrincipalPoint, ParamClass::Extra],
                "none" => &[],
                "" => return Err("a name is missing".to_owned()),
                name => {
                    which.push(Which::Named(name.to_owned()));
                    continue;
                }
            };
            which.extend(classes.iter().map(|&class| Which::Class(class)));
        }
        Ok(Self { text: text.to_owned(), camera, which })
    }
}

fn parse_loss(text: &str) -> Result<Loss, String> {
    let (name, scale) = match text.split_once(':') {
        Some((name, scale)) => (name, Some(scale)),
        None => (text, None),
    };
    let px = scale.unwrap_or("1").parse::<f64>().ok().filter(|px| *px > 0.0 && px.is_finite());
    let px = px.ok_or_else(|| format!("`{}` is not a scale in px", scale.unwrap_or_default()))?;
    match name {
        "squared" if scale.is_none() => Ok(Loss::Squared),
        "squared" => Err("the squared loss has no scale".to_owned()),
        "huber" => Ok(Loss::Huber(px)),
        "soft-l1" => Ok(Loss::SoftL1(px)),
        "cauchy" => Ok(Loss::Cauchy(px)),
        _ => Err(format!("there is no loss `{name}`: squared, huber, soft-l1, cauchy")),
    }
}

/// What Linux says can be taken without driving others out; elsewhere nobody is asked.
fn available_memory() -> Option<usize> {
    let page = fs::read_to_string("/proc/meminfo").ok()?;
    let line = page.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: usize = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wishes_for_one_camera_leave_the_others_at_the_default() {
        let wish = |text: &str| Wish::parse(text).unwrap();
        let moving = Moving { refine: vec![wish("1:fx,fy"), wish("2:none"), wish("1:k1")] };
        let chosen = moving.chosen();
        let named = |name: &str| Which::Named(name.to_owned());
        assert_eq!(chosen.of(CameraId(1)), [named("fx"), named("fy"), named("k1")]);
        assert_eq!(chosen.of(CameraId(2)), []);
        assert_eq!(chosen.of(CameraId(3)), Chosen::default().others);
    }

    #[test]
    fn what_is_no_wish_and_no_loss_is_refused() {
        for text in ["", "fx,,fy", "x:fx", ":fx"] {
            assert!(Wish::parse(text).is_err(), "{text}");
        }
        for text in ["", "squared:1", "huber:0", "huber:-1", "cauchy:x", "cauchy:inf", "tukey:1"] {
            assert!(parse_loss(text).is_err(), "{text}");
        }
        assert_eq!(parse_loss("cauchy:2.5"), Ok(Loss::Cauchy(2.5)));
        assert_eq!(parse_loss("huber"), Ok(Loss::Huber(1.0)));
    }
}
