//! A scene as COLMAP's files, as COLMAP itself would write them.
//!
//! What a record holds is said once, for both forms, in `records`; `text` and `binary` know only how a field is written.

mod binary;
mod check;
mod error;
mod number;
mod records;
mod sink;
mod staged;
mod text;

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

pub use error::WriteError;
pub(crate) use staged::Staged;

use super::Form;
use super::files::KINDS;
use crate::scene::{Camera, CameraId, Scene};
use binary::Binary;
use records::Records;
use sink::Sink;
use text::Text;

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// The files, cameras first.
    pub files: Vec<PathBuf>,
    /// What COLMAP will not read back as it is, for the user to know.
    pub remarks: Vec<String>,
}

/// Writes the scene into this folder, made if need be: all of its files, or none.
///
/// A scene without geometry gives a lone cameras file, one without mounting neither rigs nor frames. Files of the same names
/// are replaced; one that would make another model of what is written is an error. Every number comes back to the last bit.
///
/// ```
/// use calibstab::colmap::{Form, read, write};
///
/// # let folder = tempfile::tempdir()?;
/// # let folder = folder.path();
/// std::fs::write(folder.join("cameras.txt"), "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1")?;
/// let scene = read(folder)?;
/// write(&scene, &folder.join("copy"), Form::Binary)?;
/// assert_eq!(read(&folder.join("copy"))?, scene);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write(scene: &Scene, folder: &Path, form: Form) -> Result<Written, WriteError> {
    let remarks = check::check(scene, form)?;
    let names: Vec<String> = parts(scene).iter().map(|part| form.file_name(part.kind())).collect();
    for name in KINDS.map(|kind| form.file_name(kind)) {
        let file = folder.join(&name);
        if !names.contains(&name) && file.exists() {
            return Err(WriteError::InTheWay { file });
        }
    }
    let mut staged = Staged::default();
    for (part, name) in parts(scene).iter().zip(&names) {
        let file = folder.join(name);
        staged
            .create(&file)
            .and_then(|mut out| part.write(form, &mut out))
            .map_err(|source| WriteError::File { file, source })?;
    }
    let files = staged.publish().map_err(|(file, source)| WriteError::File { file, source })?;
    Ok(Written { files, remarks })
}

/// Writes cameras alone, into a file of any name.
///
/// ```
/// use calibstab::colmap::{Form, read, write_cameras};
///
/// # let folder = tempfile::tempdir()?;
/// # let folder = folder.path();
/// std::fs::write(folder.join("cameras.txt"), "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1")?;
/// let scene = read(folder)?;
/// write_cameras(&scene.cameras, &folder.join("mine.bin"), Form::Binary)?;
/// assert_eq!(read(&folder.join("mine.bin"))?, scene);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_cameras(
    cameras: &BTreeMap<CameraId, Camera>,
    file: &Path,
    form: Form,
) -> Result<Written, WriteError> {
    let scene = Scene { cameras: cameras.clone(), geometry: None };
    let remarks = check::check(&scene, form)?;
    let mut staged = Staged::default();
    staged
        .create(file)
        .and_then(|mut out| Part::write(cameras, form, &mut out))
        .map_err(|source| WriteError::File { file: file.to_owned(), source })?;
    let files = staged.publish().map_err(|(file, source)| WriteError::File { file, source })?;
    Ok(Written { files, remarks })
}

/// The same files in memory, by name.
///
/// ```
/// use calibstab::colmap::{Form, encode, read};
///
/// # let folder = tempfile::tempdir()?;
/// # let folder = folder.path();
/// std::fs::write(folder.join("cameras.txt"), "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1")?;
/// let (name, content) = encode(&read(folder)?, Form::Text)?.remove(0);
/// assert_eq!(name, "cameras.txt");
/// assert!(content.ends_with(b"\n1 SIMPLE_RADIAL 640 480 500 320 240 -0.10000000000000001\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn encode(scene: &Scene, form: Form) -> Result<Vec<(String, Vec<u8>)>, WriteError> {
    check::check(scene, form)?;
    let mut files = Vec::new();
    for part in parts(scene) {
        let (name, mut content) = (form.file_name(part.kind()), Vec::new());
        part.write(form, &mut content)
            .map_err(|source| WriteError::File { file: PathBuf::from(&name), source })?;
        files.push((name, content));
    }
    Ok(files)
}

/// One file's share of a scene.
trait Part {
    /// What COLMAP calls the file, less the ending.
    fn kind(&self) -> &'static str;
    /// Writes the file.
    fn write(&self, form: Form, out: &mut dyn Write) -> io::Result<()>;
}

impl<R: Records> Part for R {
    fn kind(&self) -> &'static str {
        R::HEAD.kind
    }

    fn write(&self, form: Form, out: &mut dyn Write) -> io::Result<()> {
        match form {
            Form::Text => whole_file(self, &mut Text::new(out)),
            Form::Binary => whole_file(self, &mut Binary::new(out)),
        }
    }
}

fn whole_file(records: &impl Records, sink: &mut impl Sink) -> io::Result<()> {
    records.write(sink)?;
    sink.finish()
}

/// The files that the scene makes, cameras first.
fn parts(scene: &Scene) -> Vec<&dyn Part> {
    let mut parts: Vec<&dyn Part> = vec![&scene.cameras];
    if let Some(geometry) = &scene.geometry {
        parts.extend([&geometry.images as &dyn Part, &geometry.points]);
        if let Some(mounting) = &geometry.mounting {
            parts.extend([&mounting.rigs as &dyn Part, &mounting.frames]);
        }
    }
    parts
}
