//! What an experiment has done so far, a line for each draw: what is left when it is interrupted.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use super::super::failure::Failure;
use crate::selection::experiment::Sample;

const NAME: &str = "unfinished.jsonl";

/// The file, open at its end.
pub(super) struct Journal {
    path: PathBuf,
    file: Mutex<File>,
}

impl Journal {
    /// The journal of the experiment that this line tells, in its output folder, and what it holds when one goes on with it.
    pub(super) fn open(
        folder: &Path,
        fingerprint: &str,
        is_resumed: bool,
    ) -> Result<(Self, Vec<Vec<Sample>>), Failure> {
        let path = folder.join(NAME);
        let failed = |error: io::Error| Failure::Input(format!("{}: {error}", path.display()));
        let said = |what: &str| Failure::Input(format!("{}: {what}", path.display()));
        let held = match fs::read_to_string(&path) {
            Ok(_) if !is_resumed => {
                return Err(said(
                    "what is left of an interrupted experiment: --resume goes on with it; remove the file to begin anew",
                ));
            }
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(failed(error)),
        };
        // A line without its end was interrupted itself.
        let whole = &held[..held.rfind('\n').map_or(0, |end| end + 1)];
        let mut lines = whole.lines();
        let is_new = match lines.next() {
            None => true,
            Some(first) if first == fingerprint => false,
            Some(_) => {
                return Err(said(
                    "it is of another experiment: of other models, options or version of calibstab",
                ));
            }
        };
        let read = |line: &str| -> Result<Vec<Sample>, String> {
            let samples: Vec<Sample> =
                serde_json::from_str(line).map_err(|error| error.to_string())?;
            if samples.is_empty() { Err("nothing in it".to_owned()) } else { Ok(samples) }
        };
        let done: Vec<Vec<Sample>> = lines
            .enumerate()
            .map(|(at, line)| read(line).map_err(|why| said(&format!("line {}: {why}", at + 2))))
            .collect::<Result<_, Failure>>()?;
        fs::create_dir_all(folder).map_err(failed)?;
        let mut file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .write(true)
            .open(&path)
            .map_err(failed)?;
        file.set_len(whole.len() as u64).map_err(failed)?;
        io::Seek::seek(&mut file, io::SeekFrom::End(0)).map_err(failed)?;
        if is_new {
            writeln!(file, "{fingerprint}").map_err(failed)?;
        }
        Ok((Self { path, file: Mutex::new(file) }, done))
    }

    /// Writes down what came of a draw.
    pub(super) fn add(&self, samples: &[Sample]) -> Result<(), Failure> {
        let failed =
            |why: &dyn std::fmt::Display| Failure::Input(format!("{}: {why}", self.path.display()));
        let line = serde_json::to_string(samples).map_err(|error| failed(&error))? + "\n";
        let mut file = self.file.lock().map_err(|error| failed(&error))?;
        file.write_all(line.as_bytes()).map_err(|error| failed(&error))
    }

    /// All is done: the report has it.
    pub(super) fn close(self) -> Result<(), Failure> {
        let failed = |error: io::Error| Failure::Input(format!("{}: {error}", self.path.display()));
        drop(self.file);
        fs::remove_file(&self.path).map_err(failed)
    }
}
