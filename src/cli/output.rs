//! Files that appear whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use super::failure::Failure;

/// A file to be written: its path below the output folder, and its content.
pub(super) type OutputFile = (PathBuf, Vec<u8>);

/// Writes files below a folder, made if need be: each under another name first, and all renamed when all are written.
pub(super) fn write_files(folder: &Path, files: &[OutputFile]) -> Result<(), Failure> {
    let staged: Vec<(PathBuf, PathBuf)> = files
        .iter()
        .map(|(path, _)| {
            let path = folder.join(path);
            let mut temporary = path.clone().into_os_string();
            temporary.push(format!(".{}.tmp", std::process::id()));
            (PathBuf::from(temporary), path)
        })
        .collect();
    let written = write_and_rename(&staged, files);
    if written.is_err() {
        for (temporary, _) in &staged {
            // Most of them were never made.
            let _ = fs::remove_file(temporary);
        }
    }
    written
}

fn write_and_rename(staged: &[(PathBuf, PathBuf)], files: &[OutputFile]) -> Result<(), Failure> {
    let failed = |path: &Path, error| {
        Failure::Input(format!("{}: could not be written: {error}", path.display()))
    };
    for ((temporary, path), (_, content)) in staged.iter().zip(files) {
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(|error| failed(path, error))?;
        }
        fs::write(temporary, content).map_err(|error| failed(path, error))?;
    }
    for (temporary, path) in staged {
        fs::rename(temporary, path).map_err(|error| failed(path, error))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn when_one_file_cannot_be_written_none_appears() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("plots"), "a file where a folder should be").unwrap();
        let files = [(PathBuf::from("a.json"), vec![1]), (PathBuf::from("plots/b.svg"), vec![2])];
        assert!(write_files(folder.path(), &files).is_err());
        let left: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(left, ["plots"]);
    }

    #[test]
    fn files_appear_under_their_names_with_their_folders() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("new/report");
        write_files(&out, &[(PathBuf::from("plots/b.svg"), vec![2])]).unwrap();
        assert_eq!(fs::read(out.join("plots/b.svg")).unwrap(), [2]);
        assert_eq!(fs::read_dir(out.join("plots")).unwrap().count(), 1);
    }
}
