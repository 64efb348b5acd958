//! What a user is told when a problem cannot be read.

use std::io;
use std::path::PathBuf;

/// A problem that could not be read, and where reading stopped.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file would not open.
    #[error("{}: cannot be read: {source}", file.display())]
    Open {
        /// Which.
        file: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Its content made no sense.
    #[error("{}:{line}:{column}: {why}", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The character of the line, from 1.
        column: usize,
        /// The reason.
        why: Why,
    },
}

/// Why a problem could not be read. Text from the file comes clipped and without control characters.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs)] // what a reason is, its message says
pub enum Why {
    #[error("the file ends before {0}")]
    Missing(String),
    #[error("{field} is `{text}`, not a number")]
    NotANumber { field: String, text: String },
    #[error("{field} is `{text}`, not a finite number")]
    NotFinite { field: String, text: String },
    #[error("{field} is `{text}`, not a whole number from 0 to {}", u32::MAX)]
    NotWhole { field: String, text: String },
    #[error("{field} is {count}, more than the {left} bytes that are left can hold")]
    CountTooLarge { field: String, count: u32, left: usize },
    #[error("{field} is {index}: there are {count}, counted from 0")]
    OutOfRange { field: String, index: u32, count: u32 },
    #[error("there is no camera in the file")]
    NoCamera,
    #[error("unexpected `{0}` after the last point")]
    Trailing(String),
}
