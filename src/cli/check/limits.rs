//! Limits, as options and a TOML file give them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::str::FromStr;

use clap::ValueEnum;
use serde::{Deserialize, Deserializer, de};

use crate::stability::VerdictKind;

/// Limits of all cameras, and those of some.
#[derive(Debug, PartialEq)]
pub(super) struct Rules {
    pub general: Limits,
    /// Where several fit a camera, the last one that says something of a matter decides it.
    pub of_cameras: Vec<CameraRule>,
}

/// The limits of the cameras that these names fit; none: any name.
#[derive(Debug, PartialEq)]
pub(super) struct CameraRule {
    pub group: Option<Pattern>,
    pub camera: Option<Pattern>,
    pub limits: Limits,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Limits {
    pub verdict: Option<Wanted>,
    pub max_spread_px: Option<Positive>,
    /// By the name of a parameter, or `f`.
    pub max_relative_std: BTreeMap<String, Share>,
}

impl Limits {
    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A verdict that can be wanted: anything is better than the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Wanted {
    /// Nothing speaks against it
    Repeatable,
    /// Anything but not determined
    Doubtful,
}

impl Wanted {
    pub(super) fn kind(self) -> VerdictKind {
        match self {
            Self::Repeatable => VerdictKind::Repeatable,
            Self::Doubtful => VerdictKind::Doubtful,
        }
    }
}

/// A number above zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Positive(pub f64);

impl FromStr for Positive {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = text.trim().parse().map_err(|_| format!("`{text}` is not a number"))?;
        Self::new(number)
    }
}

impl Positive {
    fn new(number: f64) -> Result<Self, String> {
        let is_limit = number > 0.0 && number.is_finite();
        is_limit
            .then_some(Self(number))
            .ok_or(format!("{number} is no limit: wanted a number above 0"))
    }
}

/// A share of one, written as such or as percent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Share(pub f64);

impl FromStr for Share {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim().strip_suffix('%') {
            Some(percent) => Ok(Self(percent.parse::<Positive>()?.0 / 100.0)),
            None => Ok(Self(text.parse::<Positive>()?.0)),
        }
    }
}

/// `f=1%`
pub(super) fn named_share(text: &str) -> Result<(String, Share), String> {
    let (name, share) =
        text.split_once('=').ok_or_else(|| format!("`{text}` is not NAME=SHARE"))?;
    let name = name.trim();
    if name.is_empty() {
        return Err("the name of a parameter is missing".to_owned());
    }
    Ok((name.to_owned(), share.parse()?))
}

/// A name, or a pattern with * and ?.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pattern {
    pub text: String,
    /// Of a text that is no pattern only itself is meant.
    glob: Option<glob::Pattern>,
}

impl Pattern {
    fn new(text: String) -> Self {
        Self { glob: glob::Pattern::new(&text).ok(), text }
    }

    pub(super) fn fits(&self, name: &str) -> bool {
        self.text == name || self.glob.as_ref().is_some_and(|glob| glob.matches(name))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct File {
    verdict: Option<Wanted>,
    max_spread_px: Option<Positive>,
    #[serde(default)]
    max_relative_std: BTreeMap<String, Share>,
    #[serde(default)]
    camera: Vec<Table>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Table {
    group: Option<String>,
    camera: Option<String>,
    verdict: Option<Wanted>,
    max_spread_px: Option<Positive>,
    #[serde(default)]
    max_relative_std: BTreeMap<String, Share>,
}

impl<'de> Deserialize<'de> for Positive {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::new(f64::deserialize(from)?).map_err(de::Error::custom)
    }
}

impl<'de> Deserialize<'de> for Share {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "a share such as 0.01 or \"1%\" was wanted")]
        enum Written {
            Number(f64),
            Text(String),
        }
        let share = match Written::deserialize(from)? {
            Written::Number(number) => Positive::new(number).map(|Positive(share)| Self(share)),
            Written::Text(text) => text.parse(),
        };
        share.map_err(de::Error::custom)
    }
}

/// The limits of a file; an error says where in it.
pub(super) fn read(path: &Path) -> Result<Rules, String> {
    let failed = |why: String| format!("{}{why}", path.display());
    let text = fs::read_to_string(path).map_err(|e| failed(format!(": could not be read: {e}")))?;
    rules(&text).map_err(failed)
}

fn rules(text: &str) -> Result<Rules, String> {
    let file: File = toml::from_str(text).map_err(|error| {
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or(text);
        let (line, start) =
            (before.matches('\n').count() + 1, before.rfind('\n').map_or(0, |at| at + 1));
        let column = before[start..].chars().count() + 1;
        format!(":{line}:{column}: {}", error.message().replace('\n', "; "))
    })?;
    let File { verdict, max_spread_px, max_relative_std, camera } = file;
    let general = Limits { verdict, max_spread_px, max_relative_std };
    let of_cameras: Vec<CameraRule> = camera
        .into_iter()
        .map(|Table { group, camera, verdict, max_spread_px, max_relative_std }| CameraRule {
            group: group.map(Pattern::new),
            camera: camera.map(Pattern::new),
            limits: Limits { verdict, max_spread_px, max_relative_std },
        })
        .collect();
    match of_cameras.iter().position(|rule| rule.limits.is_empty()) {
        Some(at) => Err(format!(": [[camera]] number {} sets no limit", at + 1)),
        None => Ok(Rules { general, of_cameras }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_says_what_the_options_say_and_more_of_some_cameras() {
        let read = rules(
            r#"
            verdict = "repeatable"
            max-spread-px = 1
            max-relative-std = { f = "1 %", k1 = 0.05 }
            [[camera]]
            group = "few_*"
            max-spread-px = 2.5
            "#,
        );
        let read = read.unwrap();
        let shares: Vec<(String, Share)> =
            ["f=1%", "k1 = 0.05"].iter().map(|text| named_share(text).unwrap()).collect();
        let want = Limits {
            verdict: Some(Wanted::Repeatable),
            max_spread_px: Some("1".parse().unwrap()),
            max_relative_std: shares.into_iter().collect(),
        };
        assert_eq!(read.general, want);
        let [rule] = &read.of_cameras[..] else { panic!("one table") };
        assert!(rule.group.as_ref().unwrap().fits("few_images") && rule.camera.is_none());
        assert_eq!(rule.limits.max_spread_px, Some(Positive(2.5)));
    }

    #[test]
    fn what_a_file_should_not_say_is_refused_with_its_place() {
        for (text, want) in [
            ("\nmax-spread = 1", ":2:1: unknown field `max-spread`"),
            ("[[camera]]\ngrup = \"a\"", ":2:1: unknown field `grup`"),
            ("max-spread-px = -1", ":1:17: -1 is no limit"),
            ("max-spread-px = nan", "is no limit"),
            ("verdict = \"accurate\"", ":1:11: unknown variant `accurate`"),
            ("max-relative-std = { f = \"one\" }", "`one` is not a number"),
            ("max-relative-std = { f = true }", "a share such as 0.01"),
            ("max-spread-px = ", ":1:"),
            ("[[camera]]\ngroup = \"a\"", ": [[camera]] number 1 sets no limit"),
        ] {
            let error = rules(text).unwrap_err();
            assert!(error.contains(want), "{text}: {error}");
            assert!(!error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn options_without_sense_are_refused() {
        for text in ["f", "=1%", "f=", "f=%", "f=0", "f=-1%", "f=nan", "f=inf"] {
            assert!(named_share(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_pattern_fits_itself_whatever_it_holds() {
        for name in ["camera 1 (*_cam0.jpg)", "[a", "a/b"] {
            assert!(Pattern::new(name.to_owned()).fits(name));
        }
        assert!(Pattern::new("a*".to_owned()).fits("a/b"));
        assert!(!Pattern::new("camera 1".to_owned()).fits("camera 12"));
    }
}
