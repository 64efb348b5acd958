//! Files that appear whole or not at all.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::failure::Failure;
use crate::colmap::Staged;
use crate::report::plot::{Figure, PlotError};

/// A file to be written: its path below the output folder, and its content.
pub(super) type OutputFile = (PathBuf, Vec<u8>);

/// The figures as files in `plots`.
pub(super) fn plot_files(
    figures: &[Figure],
    wants_svg: bool,
    wants_png: bool,
) -> Result<Vec<OutputFile>, Failure> {
    let failed = |error: PlotError| Failure::Input(format!("the report failed: {error}"));
    let draw = |figure: &Figure| {
        let path = |ending: &str| format!("plots/{}.{ending}", figure.stem).into();
        let mut drawn: Vec<OutputFile> = Vec::new();
        if wants_svg {
            drawn.push((path("svg"), figure.to_svg().map_err(failed)?.into_bytes()));
        }
        if wants_png {
            drawn.push((path("png"), figure.to_png().map_err(failed)?));
        }
        Ok(drawn)
    };
    let drawn: Vec<_> = figures.par_iter().map(draw).collect::<Result<_, Failure>>()?;
    Ok(drawn.concat())
}

/// Writes files below a folder, made if need be.
pub(super) fn write_files(folder: &Path, files: &[OutputFile]) -> Result<(), Failure> {
    let failed = |path: &Path, error: io::Error| {
        Failure::Input(format!("{}: could not be written: {error}", path.display()))
    };
    let mut staged = Staged::default();
    for (path, content) in files {
        let path = folder.join(path);
        let written = staged
            .create(&path)
            .and_then(|mut file| file.write_all(content).and_then(|()| file.flush()));
        written.map_err(|error| failed(&path, error))?;
    }
    staged.publish().map_err(|(path, error)| failed(&path, error))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

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
