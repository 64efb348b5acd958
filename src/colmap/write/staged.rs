//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

/// Files written under other names until all of them are.
#[derive(Default)]
pub(crate) struct Staged {
    /// The name for now, and the one to come.
    files: Vec<(PathBuf, PathBuf)>,
}

impl Staged {
    /// A new file that will have this path, its folder made if need be.
    pub(crate) fn create(&mut self, path: &Path) -> io::Result<BufWriter<File>> {
        if path.is_dir() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut temporary = path.to_owned().into_os_string();
        temporary.push(format!(".{}.tmp", std::process::id()));
        let temporary = PathBuf::from(temporary);
        let file = File::create(&temporary)?;
        self.files.push((temporary, path.to_owned()));
        Ok(BufWriter::new(file))
    }

    /// Gives all files their names, which they have in the order of their making; an error names the file.
    pub(crate) fn publish(mut self) -> Result<Vec<PathBuf>, (PathBuf, io::Error)> {
        for (temporary, path) in &self.files {
            fs::rename(temporary, path).map_err(|error| (path.clone(), error))?;
        }
        Ok(std::mem::take(&mut self.files).into_iter().map(|(_, path)| path).collect())
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        for (temporary, _) in &self.files {
            // Those that were renamed are no longer there.
            let _ = fs::remove_file(temporary);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn files_appear_with_their_folders_and_nothing_else_does() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/deeper/a.txt");
        let mut staged = Staged::default();
        staged.create(&path).unwrap().write_all(b"a").unwrap();
        assert!(!path.exists());
        assert_eq!(staged.publish().unwrap().len(), 1);
        assert_eq!(fs::read(&path).unwrap(), b"a");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn files_that_were_not_published_leave_no_trace_and_what_was_there_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "before").unwrap();
        fs::create_dir(folder.path().join("b.txt")).unwrap();
        let mut staged = Staged::default();
        staged.create(&path).unwrap().write_all(b"after").unwrap();
        assert!(staged.create(&folder.path().join("b.txt")).is_err());
        drop(staged);
        assert_eq!(fs::read(&path).unwrap(), b"before");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
