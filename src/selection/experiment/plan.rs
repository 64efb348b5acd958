//! What an experiment is asked to do.

use std::fmt;
use std::str::FromStr;

use super::super::{Heuristic, Unit};
use crate::bundle::Refine;
use crate::scene::CameraId;

/// What an experiment is asked to do.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The heuristics that are compared.
    pub heuristics: Vec<&'static Heuristic>,
    /// How many images or frames they are to choose, ascending.
    pub sizes: Vec<usize>,
    /// How often each chooses, of each model and at each size.
    pub repeats: usize,
    /// Another seed draws other pools, noise and starts.
    pub seed: u64,
    /// From what they choose.
    pub pool: Pool,
    /// What differs between repeats beside the pool.
    pub noise: Noise,
    /// Which intrinsics move.
    pub refine: Refine,
    /// What is chosen at a time.
    pub unit: Unit,
    /// The camera whose intrinsics are wanted; all of a model if none.
    pub camera: Option<CameraId>,
    /// The error for which the smallest size is sought.
    pub target_px: Option<f64>,
}

/// From which part of the images heuristics choose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pool {
    /// This share of them, drawn by chance among those that hang together.
    Random(f64),
    /// So many in a row, from a start of chance: a stretch of a drive.
    Window(usize),
}

/// What differs between repeats beside the pool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Noise {
    /// The noise of all pixels: each repeat sees the real geometry anew.
    Redraw,
    /// Nothing: all repeats share the noise that was measured.
    Keep,
}

impl fmt::Display for Pool {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Random(share) => write!(f, "random:{share}"),
            Self::Window(count) => write!(f, "window:{count}"),
        }
    }
}

impl FromStr for Pool {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let of = |prefix: &str| text.strip_prefix(prefix);
        let share = of("random:").and_then(|share| share.parse().ok());
        let count = of("window:").and_then(|count| count.parse().ok());
        match (share, count) {
            (Some(share), _) if share > 0.0 && share <= 1.0 => Ok(Self::Random(share)),
            (_, Some(count)) if count >= 2 => Ok(Self::Window(count)),
            _ => Err(format!(
                "`{text}` is no pool: wanted random: and a share of the images up to 1, as in random:0.5, or window: and a number of images, as in window:100"
            )),
        }
    }
}

impl fmt::Display for Noise {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Redraw => "redraw",
            Self::Keep => "keep",
        })
    }
}

impl Pool {
    /// How many of so many images or frames it holds.
    pub fn size(self, count: usize) -> usize {
        match self {
            // The nearest whole number, halves upwards.
            Self::Random(share) => {
                (1..=count).filter(|&size| size as f64 <= share * count as f64 + 0.5).count()
            }
            Self::Window(size) => size.min(count),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pools_read_as_they_are_written_and_nonsense_is_refused() {
        for text in ["random:0.5", "random:1", "window:100", "window:2"] {
            assert_eq!(text.parse::<Pool>().unwrap().to_string(), text);
        }
        for text in ["", "random", "random:0", "random:1.1", "random:nan", "window:1", "all"] {
            assert!(text.parse::<Pool>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_pool_is_a_share_of_the_images_or_what_there_is_of_a_window() {
        let sizes = [Pool::Random(0.5), Pool::Random(1.0), Pool::Window(20), Pool::Window(40)];
        assert_eq!(sizes.map(|pool| pool.size(31)), [16, 31, 20, 31]);
    }
}
