//! What a user is told when a model cannot be read: the place, the reason, and the line itself.

use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use super::block::Block;
use super::excerpt::{Excerpt, escaped};
use super::source::Fault;
use super::text::BYTE_ORDER_MARK;
use super::{Form, Why};

/// A model that could not be found or read, and where reading stopped.
#[derive(Debug)]
pub enum ReadError {
    /// Nothing has this path.
    Absent {
        /// The path.
        path: PathBuf,
    },
    /// Something has this path, but no model is in it.
    NoModel {
        /// The path.
        path: PathBuf,
    },
    /// One model was asked for, and several are there.
    ManyModels {
        /// Where they are.
        path: PathBuf,
        /// How many.
        count: usize,
    },
    /// A file of a model stands without another that it needs.
    Incomplete {
        /// The file that is there.
        file: PathBuf,
        /// The name of the file that is not.
        missing: String,
    },
    /// A file or folder would not open.
    Open {
        /// Which.
        file: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A line made no sense.
    Line {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The character of the line, from 1.
        column: usize,
        /// The line itself.
        text: Excerpt,
        /// The reason.
        why: Why,
    },
    /// Binary data made no sense.
    Byte {
        /// The file.
        file: PathBuf,
        /// Bytes from the start of the file.
        offset: usize,
        /// The reason.
        why: Why,
    },
    /// A file as a whole made no sense.
    File {
        /// The file.
        file: PathBuf,
        /// The reason.
        why: Why,
    },
}

impl ReadError {
    /// The fault, with the place that its byte is in this file.
    pub(super) fn at(file: &Path, form: Form, block: &Block, fault: Fault) -> Self {
        let why = *fault.why;
        match form {
            Form::Binary => Self::Byte { file: file.to_owned(), offset: fault.at, why },
            Form::Text => match Place::of(file, block, fault.at) {
                Ok(Place { line, column, text }) => {
                    Self::Line { file: file.to_owned(), line, column, text, why }
                }
                Err(source) => Self::could_not_open(file, source),
            },
        }
    }

    /// What the system said when this file should be read.
    pub(super) fn could_not_open(file: &Path, source: io::Error) -> Self {
        Self::Open { file: file.to_owned(), source }
    }

    /// A file that was not the same when it was read again.
    pub(super) fn changed(file: &Path) -> Self {
        Self::could_not_open(file, io::Error::other("it changed while it was read"))
    }

    /// The reason, apart from its place, when it lies in a file's content.
    pub fn why(&self) -> Option<&Why> {
        match self {
            Self::Line { why, .. } | Self::Byte { why, .. } | Self::File { why, .. } => Some(why),
            Self::Absent { .. }
            | Self::NoModel { .. }
            | Self::ManyModels { .. }
            | Self::Incomplete { .. }
            | Self::Open { .. } => None,
        }
    }
}

/// A byte of a text file, as an editor would call it.
struct Place {
    line: usize,
    column: usize,
    text: Excerpt,
}

impl Place {
    /// Where this byte of the file is, which lies in the block. The lines before the block are counted in the file.
    fn of(file: &Path, block: &Block, at: usize) -> io::Result<Self> {
        let bytes = &block.bytes;
        let at = at - block.offset;
        let (before, after) = bytes.split_at(at.min(bytes.len()));
        let earlier = lines_before(file, block.offset)?;
        let line = 1 + earlier + before.iter().filter(|&&byte| byte == b'\n').count();
        let mut start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        if line == 1 && before.starts_with(BYTE_ORDER_MARK) {
            start = BYTE_ORDER_MARK.len();
        }
        let end = at + after.iter().position(|&byte| byte == b'\n').unwrap_or(after.len());
        let whole = bytes[start..end].trim_ascii_end();
        let at = (at - start).min(whole.len());
        let column = 1 + String::from_utf8_lossy(&whole[..at]).chars().count();
        Ok(Self { line, column, text: Excerpt::of(whole, at) })
    }
}

/// How many lines end before this byte.
fn lines_before(file: &Path, at: usize) -> io::Result<usize> {
    let mut lines = 0;
    if at > 0 {
        let start = BufReader::new(File::open(file)?.take(at as u64));
        for byte in start.bytes() {
            lines += usize::from(byte? == b'\n');
        }
    }
    Ok(lines)
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Absent { path } => write!(
                f,
                "{}: there is no such file or folder; expected a cameras file, a model folder, a run with sparse/0, \
                 or a folder of these",
                Shown(path)
            ),
            Self::NoModel { path } => write!(
                f,
                "{}: no COLMAP model found; looked for cameras.txt and cameras.bin in it, in its sparse/ and sparse/0, \
                 and in every folder below",
                Shown(path)
            ),
            Self::ManyModels { path, count } => {
                write!(f, "{}: expected one model, found {count}", Shown(path))
            }
            Self::Incomplete { file, missing } => {
                write!(f, "{}: {missing} must stand beside it, and does not", Shown(file))
            }
            Self::Open { file, source } => write!(f, "{}: cannot be read: {source}", Shown(file)),
            Self::Byte { file, offset, why } => write!(f, "{}: byte {offset}: {why}", Shown(file)),
            Self::File { file, why } => write!(f, "{}: {why}", Shown(file)),
            Self::Line { file, line, column, text, why } => {
                writeln!(f, "{}:{line}:{column}: {why}", Shown(file))?;
                let margin = line.to_string().len();
                writeln!(f, "  {line} | {}", text.text)?;
                write!(f, "  {:margin$} | {:caret$}^", "", "", caret = text.caret)
            }
        }
    }
}

impl std::error::Error for ReadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Open { source, .. } => Some(source),
            _ => None,
        }
    }
}

/// A path, safe to print on a terminal.
struct Shown<'a>(&'a Path);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&escaped(self.0.as_os_str().as_encoded_bytes()))
    }
}
