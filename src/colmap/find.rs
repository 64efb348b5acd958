//! Where models are: in a cameras file, a folder, a run's `sparse/0`, or anywhere below a folder.

use std::fs;
use std::path::Path;

use walkdir::{DirEntry, WalkDir};

use super::{ModelFiles, ReadError};

/// The models at this path, at least one, in the order of their paths.
///
/// The path may be a cameras file of any name (`.bin` means binary), a model's folder, a run with its model in `sparse`
/// or `sparse/0`, or a folder of these at any depth. Links are followed, hidden folders are not entered.
pub fn find(path: &Path) -> Result<Vec<ModelFiles>, ReadError> {
    match fs::metadata(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            Err(ReadError::Absent { path: path.to_owned() })
        }
        Err(source) => Err(ReadError::Open { file: path.to_owned(), source }),
        Ok(found) if found.is_dir() => below(path),
        Ok(_) => Ok(vec![ModelFiles::of_file(path)]),
    }
}

fn below(top: &Path) -> Result<Vec<ModelFiles>, ReadError> {
    let mut models = Vec::new();
    let mut walk = WalkDir::new(top).follow_links(true).sort_by_file_name().into_iter();
    while let Some(entry) = walk.next() {
        let entry = match entry {
            // A link back to a folder that is being searched already: nothing is lost by leaving it.
            Err(error) if error.loop_ancestor().is_some() => continue,
            entry => entry.map_err(|error| could_not_open(error, top))?,
        };
        if !entry.file_type().is_dir() {
            continue;
        }
        if is_hidden(&entry) {
            walk.skip_current_dir();
        } else if let Some(model) = model_of_run(entry.path())? {
            models.push(model);
            walk.skip_current_dir();
        }
    }
    if models.is_empty() {
        return Err(ReadError::NoModel { path: top.to_owned() });
    }
    Ok(models)
}

fn is_hidden(entry: &DirEntry) -> bool {
    entry.depth() > 0 && entry.file_name().as_encoded_bytes().starts_with(b".")
}

fn could_not_open(error: walkdir::Error, top: &Path) -> ReadError {
    let file = error.path().unwrap_or(top).to_owned();
    ReadError::Open { file, source: error.into() }
}

/// The model in this folder, or in the `sparse` of this run.
fn model_of_run(run: &Path) -> Result<Option<ModelFiles>, ReadError> {
    if let Some(model) = ModelFiles::in_folder(run) {
        return Ok(Some(model));
    }
    let is_sparse = run.file_name().is_some_and(|name| name == "sparse");
    let sparse = if is_sparse { run.to_owned() } else { run.join("sparse") };
    let first = sparse.join("0");
    let Some(mut model) = ModelFiles::in_folder(&sparse).or_else(|| ModelFiles::in_folder(&first))
    else {
        return Ok(None);
    };
    if model.folder() == first {
        model.remarks.extend(remark_on_split(&sparse)?);
    }
    Ok(Some(model))
}

/// COLMAP numbers the parts of a reconstruction that it could not join: `sparse/0`, `sparse/1`, ...
fn remark_on_split(sparse: &Path) -> Result<Option<String>, ReadError> {
    let could_not_open = |source| ReadError::Open { file: sparse.to_owned(), source };
    let mut unread = Vec::new();
    for entry in fs::read_dir(sparse).map_err(could_not_open)? {
        let name = entry.map_err(could_not_open)?.file_name();
        let number = name.to_str().and_then(|name| name.parse::<u32>().ok());
        if number.is_some_and(|number| number > 0)
            && ModelFiles::in_folder(&sparse.join(&name)).is_some()
        {
            unread.extend(number);
        }
    }
    unread.sort_unstable();
    let unread: Vec<String> = unread.iter().map(|number| format!("sparse/{number}")).collect();
    Ok((!unread.is_empty())
        .then(|| format!("the reconstruction split: sparse/0 is read, {} not", unread.join(", "))))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::colmap::Form;

    /// A folder with these files, all of them empty.
    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        folder
    }

    /// What is found below a folder, as `run <- cameras file`, with the remarks.
    fn found(folder: &tempfile::TempDir, path: &str) -> Vec<(String, Vec<String>)> {
        let below = |path: &Path| path.strip_prefix(folder.path()).unwrap().display().to_string();
        let models = find(&folder.path().join(path)).unwrap();
        let shown =
            |m: ModelFiles| (format!("{} <- {}", below(m.run()), below(&m.cameras)), m.remarks);
        models.into_iter().map(shown).collect()
    }

    fn found_without_remarks(folder: &tempfile::TempDir, path: &str) -> Vec<String> {
        let found = found(folder, path);
        assert!(found.iter().all(|(_, remarks)| remarks.is_empty()), "{found:?}");
        found.into_iter().map(|(shown, _)| shown).collect()
    }

    #[test]
    fn runs_are_found_at_any_depth_in_the_order_of_their_names() {
        let folder = folder(&[
            "set/run10/cameras.txt",
            "set/run2/sparse/0/cameras.bin",
            "set/run2/photos/a.jpg",
            "set/run3/sparse/cameras.txt",
            "set/.hidden/cameras.txt",
            "other/deep/deeper/model/cameras.txt",
            "other/deep/deeper/model/below/cameras.txt",
            "notes.txt",
        ]);
        let wanted = [
            "other/deep/deeper/model <- other/deep/deeper/model/cameras.txt",
            "set/run10 <- set/run10/cameras.txt",
            "set/run2 <- set/run2/sparse/0/cameras.bin",
            "set/run3 <- set/run3/sparse/cameras.txt",
        ];
        assert_eq!(found_without_remarks(&folder, ""), wanted);
        assert_eq!(found_without_remarks(&folder, "set/.hidden").len(), 1);
    }

    #[test]
    fn a_cameras_file_brings_its_siblings_and_a_file_of_another_name_none() {
        let folder = folder(&["m/cameras.txt", "m/images.txt", "m/points3D.txt", "m/mine.BIN"]);
        let one = |path: &str| find(&folder.path().join(path)).unwrap().remove(0);
        let model = one("m/cameras.txt");
        assert_eq!((model.form, model.paths().count()), (Form::Text, 3));
        assert_eq!((model.folder(), &model), (model.run(), &one("m")));
        let lone = one("m/mine.BIN");
        assert_eq!((lone.form, lone.paths().count()), (Form::Binary, 1));
        assert_eq!(lone.run(), lone.cameras);
    }

    #[test]
    fn of_two_forms_the_binary_one_is_read_unless_text_is_named_or_binary_is_not_whole() {
        let text = ["cameras.txt", "images.txt", "points3D.txt"];
        let both = folder(&[&text[..], &["cameras.bin", "images.bin", "points3D.bin"]].concat());
        let binary = "binary and text stand side by side: the binary files are read, cameras.txt, images.txt, \
                      points3D.txt not";
        assert_eq!(found(&both, ""), [(" <- cameras.bin".to_owned(), vec![binary.to_owned()])]);
        let named = "binary and text stand side by side: the text files are read, cameras.bin, images.bin, \
                     points3D.bin not";
        assert_eq!(found(&both, "cameras.txt")[0].1, [named]);

        let part = folder(&[&text[..], &["cameras.bin", "images.bin"]].concat());
        assert_eq!(found(&part, "")[0].0, " <- cameras.txt");
        let lone = folder(&["cameras.txt", "cameras.bin"]);
        assert_eq!(found(&lone, "")[0].0, " <- cameras.bin");
    }

    #[test]
    fn of_a_reconstruction_that_split_the_first_part_is_read_with_a_remark() {
        let folder = folder(&[
            "run/sparse/0/cameras.txt",
            "run/sparse/10/cameras.txt",
            "run/sparse/2/cameras.bin",
            "run/sparse/3/notes.txt",
            "later/sparse/1/cameras.txt",
        ]);
        let remark = "the reconstruction split: sparse/0 is read, sparse/2, sparse/10 not";
        let split =
            |run: &str| (format!("{run} <- run/sparse/0/cameras.txt"), vec![remark.to_owned()]);
        assert_eq!(found(&folder, "run"), [split("run")]);
        assert_eq!(found(&folder, "run/sparse"), [split("run")]);
        let first = "run <- run/sparse/0/cameras.txt";
        assert_eq!(found_without_remarks(&folder, "run/sparse/0"), [first]);
        let later = "later/sparse/1 <- later/sparse/1/cameras.txt";
        assert_eq!(found(&folder, ""), [(later.to_owned(), vec![]), split("run")]);
    }

    #[test]
    fn a_model_that_lost_its_cameras_is_still_found() {
        let folder = folder(&["a/images.txt", "a/points3D.txt", "b/images.txt"]);
        assert_eq!(found_without_remarks(&folder, ""), ["a <- a/cameras.txt"]);
    }

    #[test]
    fn nothing_found_is_an_error_that_says_what_was_looked_for() {
        let folder = folder(&["a/notes.txt", "b/.hidden/cameras.txt"]);
        let shown = |path: &str| find(&folder.path().join(path)).unwrap_err().to_string();
        assert!(shown("").contains("looked for cameras.txt and cameras.bin"), "{}", shown(""));
        assert!(shown("c").contains("c: there is no such file or folder"), "{}", shown("c"));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_a_link_back_up_ends_nothing() {
        use std::os::unix::fs::symlink;
        let folder = folder(&["store/model/cameras.txt", "set/notes.txt"]);
        symlink(folder.path().join("store/model"), folder.path().join("set/run0")).unwrap();
        symlink(folder.path().join("set"), folder.path().join("set/again")).unwrap();
        assert_eq!(found_without_remarks(&folder, "set"), ["set/run0 <- set/run0/cameras.txt"]);
    }
}
