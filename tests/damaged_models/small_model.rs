//! A model of two cameras, images and points with one rig and one frame, the same in both forms.

#![allow(clippy::expect_used)] // only tests call this

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

/// The files as text; lines and columns of the tests count in these.
pub const TEXT: [(&str, &str); 5] = [
    (
        "cameras.txt",
        "# id, model, width, height, parameters\n\
         1 OPENCV 640 480 500 501 320 240 0.1 0.01 0 0\n\
         7 SIMPLE_RADIAL 640 481 500 320 240 0.1\n",
    ),
    (
        "images.txt",
        "# two lines an image\n\
         2 1 0 0 0 0 0 1 1 a.jpg\n\
         10.5 20.5 5 11.5 21.5 -1 12.5 22.5 9\n\
         3 1 0 0 0 0 0 2 7 b.jpg\n\
         30.5 40.5 9 31.5 41.5 5\n",
    ),
    (
        "points3D.txt",
        "# id, position, colour, error, track\n\
         5 0 0 4 10 20 30 0.5 2 0 3 1\n\
         9 1 1 5 11 21 31 0.25 2 2 3 0\n",
    ),
    ("rigs.txt", "1 2 CAMERA 1 CAMERA 7 1 1 0 0 0 0.5 0 0\n"),
    ("frames.txt", "4 1 1 0 0 0 0 0 1 2 CAMERA 1 2 CAMERA 7 3\n"),
];

/// The text file of this name.
pub fn text(file: &str) -> &'static str {
    TEXT.iter().find(|(name, _)| *name == file).expect("one of the five").1
}

/// The same model as COLMAP lays it out in binary: Q is eight bytes, I four, B one, S a name, a bare number a double.
const BINARY: [(&str, &str); 5] = [
    (
        "cameras.bin",
        "Q2 I1 I4 Q640 Q480 500 501 320 240 0.1 0.01 0 0 \
            I7 I2 Q640 Q481 500 320 240 0.1",
    ),
    (
        "images.bin",
        "Q2 I2 1 0 0 0 0 0 1 I1 Sa.jpg Q3 10.5 20.5 Q5 11.5 21.5 Q18446744073709551615 12.5 22.5 Q9 \
            I3 1 0 0 0 0 0 2 I7 Sb.jpg Q2 30.5 40.5 Q9 31.5 41.5 Q5",
    ),
    (
        "points3D.bin",
        "Q2 Q5 0 0 4 B10 B20 B30 0.5 Q2 I2 I0 I3 I1 \
            Q9 1 1 5 B11 B21 B31 0.25 Q2 I2 I2 I3 I0",
    ),
    ("rigs.bin", "Q1 I1 I2 I0 I1 I0 I7 B1 1 0 0 0 0.5 0 0"),
    ("frames.bin", "Q1 I4 I1 1 0 0 0 0 0 1 I2 I0 I1 Q2 I0 I7 Q3"),
];

/// The binary files.
pub fn binary() -> Vec<(&'static str, Vec<u8>)> {
    let bytes =
        |(name, fields): (_, &str)| (name, fields.split_whitespace().flat_map(field).collect());
    BINARY.into_iter().map(bytes).collect()
}

fn field(field: &str) -> Vec<u8> {
    let (kind, value) = field.split_at(1);
    match kind {
        "Q" => value.parse::<u64>().expect("u64").to_le_bytes().to_vec(),
        "I" => value.parse::<u32>().expect("u32").to_le_bytes().to_vec(),
        "B" => vec![value.parse().expect("u8")],
        "S" => [value.as_bytes(), b"\0"].concat(),
        _ => field.parse::<f64>().expect("f64").to_le_bytes().to_vec(),
    }
}

/// A folder with these files.
pub fn folder<Content: AsRef<[u8]>>(files: &[(&str, Content)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, content) in files {
        let path: PathBuf = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, content).expect("written");
    }
    folder
}
