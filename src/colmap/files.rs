//! The files of one model in one folder: which are there, and in which form they are read.

use std::path::{Path, PathBuf};

/// How a model's files are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// `.txt`
    Text,
    /// `.bin`
    Binary,
}

/// The files of one model, not yet read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelFiles {
    /// How all of them are written.
    pub form: Form,
    /// The cameras.
    pub cameras: PathBuf,
    /// The images.
    pub images: Option<PathBuf>,
    /// The points.
    pub points: Option<PathBuf>,
    /// The rigs.
    pub rigs: Option<PathBuf>,
    /// The frames.
    pub frames: Option<PathBuf>,
    /// What the user should know of how they were chosen.
    pub remarks: Vec<String>,
}

impl Form {
    /// The name of a model's file of this kind: `cameras`, `points3D`, ...
    pub(super) fn file_name(self, kind: &str) -> String {
        format!("{kind}.{}", self.extension())
    }

    fn extension(self) -> &'static str {
        match self {
            Self::Text => "txt",
            Self::Binary => "bin",
        }
    }

    /// What a user calls it.
    pub(super) fn adjective(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Binary => "binary",
        }
    }

    fn other(self) -> Self {
        match self {
            Self::Text => Self::Binary,
            Self::Binary => Self::Text,
        }
    }

    /// The file of this kind in a folder, if there is one.
    fn file(self, folder: &Path, kind: &str) -> Option<PathBuf> {
        Some(folder.join(self.file_name(kind))).filter(|path| path.is_file())
    }
}

/// How much of a model a folder holds in one form; the more, the sooner that form is read.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Extent {
    /// Something, but not all that a model needs.
    Part,
    /// A cameras file alone.
    Cameras,
    /// Cameras, images and points.
    Whole,
}

/// What COLMAP calls a model's files, less the ending.
pub(super) const KINDS: [&str; 5] = ["cameras", "images", "points3D", "rigs", "frames"];

impl ModelFiles {
    /// A cameras file and nothing else.
    pub fn lone_cameras(cameras: PathBuf, form: Form) -> Self {
        let (images, points, rigs, frames) = (None, None, None, None);
        Self { form, cameras, images, points, rigs, frames, remarks: Vec::new() }
    }

    /// What a user would call the run: the model's folder, or the one above its `sparse` or `sparse/0`. A cameras file of
    /// another name is a run by itself.
    pub fn run(&self) -> &Path {
        if !self.is_cameras_file_named_so() {
            return &self.cameras;
        }
        let mut run = self.folder();
        for suffix in ["sparse/0", "sparse"] {
            if let Some(above) = run.ancestors().nth(Path::new(suffix).components().count())
                && run.ends_with(suffix)
            {
                run = above;
            }
        }
        run
    }

    fn is_cameras_file_named_so(&self) -> bool {
        self.cameras.file_name().is_some_and(|name| name == self.form.file_name("cameras").as_str())
    }

    /// The model's folder.
    pub fn folder(&self) -> &Path {
        self.cameras.parent().unwrap_or(Path::new(""))
    }

    /// Its files, cameras first.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        let others = [&self.images, &self.points, &self.rigs, &self.frames];
        let others = others.into_iter().filter_map(|path| path.as_deref());
        std::iter::once(self.cameras.as_path()).chain(others)
    }

    /// The model that this cameras file belongs to.
    pub(super) fn of_file(cameras: &Path) -> Self {
        let is_binary = cameras.extension().is_some_and(|end| end.eq_ignore_ascii_case("bin"));
        let form = if is_binary { Form::Binary } else { Form::Text };
        let folder = cameras.parent().unwrap_or(Path::new(""));
        if cameras.file_name().is_some_and(|name| name == form.file_name("cameras").as_str()) {
            let mut model = Self::in_form(folder, form);
            model.remark_on_other_form();
            return model;
        }
        Self::lone_cameras(cameras.to_owned(), form)
    }

    /// The model in this very folder, if there is one.
    pub(super) fn in_folder(folder: &Path) -> Option<Self> {
        let text = Self::extent(folder, Form::Text);
        let binary = Self::extent(folder, Form::Binary);
        // COLMAP, too, reads the binary one of two.
        let form = if binary >= text { Form::Binary } else { Form::Text };
        binary.or(text)?;
        let mut model = Self::in_form(folder, form);
        model.remark_on_other_form();
        Some(model)
    }

    /// A model whose cameras alone are missing counts, so that the user hears of it.
    fn extent(folder: &Path, form: Form) -> Option<Extent> {
        let has = |kind| form.file(folder, kind).is_some();
        match (has("cameras"), has("images"), has("points3D")) {
            (true, true, true) => Some(Extent::Whole),
            (true, false, false) => Some(Extent::Cameras),
            (false, true, true) | (true, _, _) => Some(Extent::Part),
            (false, _, _) => None,
        }
    }

    fn in_form(folder: &Path, form: Form) -> Self {
        let [_, images, points, rigs, frames] = KINDS.map(|kind| form.file(folder, kind));
        Self {
            form,
            cameras: folder.join(form.file_name("cameras")),
            images,
            points,
            rigs,
            frames,
            remarks: Vec::new(),
        }
    }

    fn remark_on_other_form(&mut self) {
        let other = self.form.other();
        let unread: Vec<String> = KINDS
            .iter()
            .filter(|kind| other.file(self.folder(), kind).is_some())
            .map(|kind| other.file_name(kind))
            .collect();
        if !unread.is_empty() {
            self.remarks.push(format!(
                "binary and text stand side by side: the {} files are read, {} not",
                self.form.adjective(),
                unread.join(", ")
            ));
        }
    }
}
