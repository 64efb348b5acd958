//! What holds of any bytes that are taken for a model, and how the fuzzer's inputs become files.
//!
//! The first byte of an input says which reader it is for, so that one corpus serves all of them.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use calibstab::colmap::{Form, ModelFiles, ReadError, WriteError, encode};
use calibstab::scene::Scene;

/// The files of a model, in the order of the first byte's meaning and of a whole model's parts.
const KINDS: [&str; 5] = ["cameras", "images", "points3D", "rigs", "frames"];

/// Stands between the files of a whole model: long enough to be no part of one by chance, and valid in neither form.
pub const BETWEEN: &[u8] = b"\n=====\n";

const SOUND_TEXT: [&str; 5] = [
    "1 OPENCV 640 480 500 501 320 240 0.1 0.01 0 0\n7 SIMPLE_RADIAL 640 481 500 320 240 0.1\n",
    "2 1 0 0 0 0 0 1 1 a\n1 2 5 3 4 -1\n3 1 0 0 0 0 0 2 7 b\n5 6 5\n",
    "5 0 0 4 10 20 30 0.5 2 0 3 0\n",
    "1 2 CAMERA 1 CAMERA 7 1 1 0 0 0 0.5 0 0\n",
    "4 1 1 0 0 0 0 0 1 2 CAMERA 1 2 CAMERA 7 3\n",
];

/// The rest of the input is the file that the first byte says: 0 to 4 in text, 5 to 9 in binary.
pub fn one_file(data: &[u8]) {
    static SOUND_BINARY: LazyLock<Vec<(String, Vec<u8>)>> = LazyLock::new(|| {
        let sound = parse(Form::Text, &SOUND_TEXT.map(str::as_bytes)).expect("a sound model");
        encode(&sound, Form::Binary).expect("written")
    });
    let Some((&which, content)) = data.split_first() else { return };
    let (mut files, form) = match which {
        0..5 => (SOUND_TEXT.map(str::as_bytes), Form::Text),
        5..10 => (std::array::from_fn(|kind| SOUND_BINARY[kind].1.as_slice()), Form::Binary),
        _ => return,
    };
    files[usize::from(which % 5)] = content;
    must_hold(form, &files);
}

/// The rest of the input is the five files with `BETWEEN` between them, in text when the first byte is 0, binary when it is 1;
/// with 2 and 3 the same, of three files.
pub fn whole_model(data: &[u8]) {
    let Some((&which, mut rest)) = data.split_first() else { return };
    let (form, count) = match which {
        0 => (Form::Text, 5),
        1 => (Form::Binary, 5),
        2 => (Form::Text, 3),
        3 => (Form::Binary, 3),
        _ => return,
    };
    let mut files: Vec<&[u8]> = Vec::new();
    while files.len() + 1 < count {
        let at = rest.windows(BETWEEN.len()).position(|window| window == BETWEEN);
        let Some(at) = at else { break };
        files.push(&rest[..at]);
        rest = &rest[at + BETWEEN.len()..];
    }
    files.push(rest);
    files.resize(count, &[]);
    must_hold(form, &files);
}

fn must_hold(form: Form, files: &[&[u8]]) {
    match parse(form, files) {
        Ok(scene) => copies_hold(&scene),
        Err(error) => assert!(!error.to_string().contains('\u{1b}')),
    }
}

/// A scene that was read is written in both forms, and read back to the last bit.
pub fn copies_hold(scene: &Scene) {
    for form in [Form::Text, Form::Binary] {
        let written = match encode(scene, form) {
            Ok(written) => written,
            // Names that the other form cannot hold, and models that have no number.
            Err(WriteError::Name { .. } | WriteError::NoModelId { .. }) => continue,
            Err(error) => panic!("{error}"),
        };
        let contents: Vec<&[u8]> = written.iter().map(|(_, content)| content.as_slice()).collect();
        let back = parse(form, &contents).unwrap_or_else(|error| panic!("{error}"));
        assert!(back == *scene, "another scene came back");
        // Equal scenes may differ in the sign of a zero, files may not.
        assert!(encode(&back, form).expect("written") == written, "other bytes came back");
    }
}

/// The scene that these files hold, cameras first, as many as there are.
pub fn parse(form: Form, files: &[&[u8]]) -> Result<Scene, ReadError> {
    let path = |kind: usize| (kind < files.len()).then(|| PathBuf::from(KINDS[kind]));
    let model = ModelFiles {
        images: path(1),
        points: path(2),
        rigs: path(3),
        frames: path(4),
        ..ModelFiles::lone_cameras(KINDS[0].into(), form)
    };
    let open = |wanted: &Path| {
        let kind = KINDS.iter().position(|kind| wanted == Path::new(kind));
        kind.map(|kind| files[kind].to_vec().into()).ok_or_else(|| io::ErrorKind::NotFound.into())
    };
    model.read_with(&open)
}
