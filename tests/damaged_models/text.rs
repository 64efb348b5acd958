//! Damaged text models: every damage has its own message, at its own place.

use std::path::Path;

use crate::small_model::{TEXT, folder, text};
use calibstab::colmap::{ReadError, Why, read};

/// What was in the file, what is there now with `^` in front of the place that the error must name, and its reason.
#[rustfmt::skip]
const DAMAGES: &[(&str, &str, &str, &str)] = &[
    // Fields that are missing or too many.
    ("cameras.txt", "1 OPENCV 640 480 500 501 320 240 0.1 0.01 0 0", "1^", "the line ends before its camera model"),
    ("cameras.txt", " 640 480 500 501 320 240 0.1 0.01 0 0", " 640^ \t", "the line ends before its height"),
    ("cameras.txt", "OPENCV 640 480 500 501 320 240 0.1 0.01 0 0", "^OPENCV 640 480 500 501 320", "OPENCV takes 8 parameters, found 3"),
    ("cameras.txt", "OPENCV 640 480 500 501 320 240 0.1 0.01 0 0", "^OPENCV 640 480 500 501 320 240 0.1 0.01 0 0 0", "OPENCV takes 8 parameters, found 9"),
    ("images.txt", "1 a.jpg", "1^", "the line ends before its image name"),
    ("points3D.txt", "5 11 21 31 0.25 2 2 3 0", "5 11 21^", "the line ends before its blue"),
    ("points3D.txt", " 0.5 2 0 3 1", "^", "the line ends before its error"),
    ("points3D.txt", "2 2 3 0", "2 2 ^3", "the track elements have 3 fields, expected a multiple of 2"),
    ("images.txt", "31.5 41.5 5", "^31.5 41.5", "the keypoints have 5 fields, expected a multiple of 3"),
    ("images.txt", " 5 11.5 21.5 -1 12.5 22.5", " 11.5 21.5 -1 12.5 ^22.5", "the keypoints have 8 fields, expected a multiple of 3"),
    ("images.txt", "30.5 40.5 9 31.5 41.5 5\n", "^", "the file ends before the second line of image 3, which may be empty but must be there"),
    ("rigs.txt", " 0 0.5 0 0", " 0^", "the line ends before its tx"),
    ("rigs.txt", "0.5 0 0", "0.5 0 0 ^CAMERA 8 0", "unexpected `CAMERA` after the last field"),
    ("rigs.txt", "1 2 CAMERA 1 CAMERA 7 1 1 0 0 0 0.5 0 0", "1 4000000000 CAMERA 1 CAMERA 7 1 1 0 0 0 0.5 0 0^", "the line ends before its sensor type"),
    ("frames.txt", "7 3", "7 3 ^# done", "unexpected `#` after the last field"),
    ("frames.txt", "1 2 CAMERA 1 2 CAMERA 7 3", "1 2 CAMERA 1 2^", "the line ends before its sensor type"),
    // Numbers that are none, or out of range.
    ("cameras.txt", "500 501", "^5oo 501", "fx is `5oo`, not a number"),
    ("cameras.txt", "500 501", "500 ^501,5", "fy is `501,5`, not a number"),
    ("cameras.txt", "501 320", "501 ^nan", "cx is nan, not a finite number"),
    ("cameras.txt", "240 0.1 0.01", "240 ^-inf 0.01", "k1 is -inf, not a finite number"),
    ("cameras.txt", "240 0.1 0.01", "240 0.1 ^1e999", "k2 is 1e999, not a finite number"),
    ("cameras.txt", "1 OPENCV", "^-1 OPENCV", "camera id is -1, below 0"),
    ("cameras.txt", "1 OPENCV", "^1.0 OPENCV", "camera id is `1.0`, not a whole number"),
    ("cameras.txt", "1 OPENCV", "^4294967296 OPENCV", "camera id is 4294967296, above 4294967295"),
    ("cameras.txt", "1 OPENCV", "^4294967295 OPENCV", "camera id is 4294967295, by which COLMAP means none"),
    ("cameras.txt", "640 480", "^0 480", "width is 0, expected at least 1"),
    ("cameras.txt", "640 480", "640 ^-480", "height is -480, below 0"),
    ("cameras.txt", "640 480", "^640.5 480", "width is `640.5`, not a whole number"),
    ("cameras.txt", "640 480", "640 ^99999999999999999999", "height is 99999999999999999999, above 18446744073709551615"),
    ("images.txt", "2 1 0 0 0", "2 ^0 -0 0 0", "the quaternion is 0 0 0 0, which is no rotation"),
    ("images.txt", "0 2 7", "0 ^two 7", "tz is `two`, not a number"),
    ("images.txt", "20.5 5 11.5", "20.5 ^-2 11.5", "point id is -2, below 0"),
    ("images.txt", "11.5 21.5", "11.5 ^21.5f", "keypoint y is `21.5f`, not a number"),
    ("points3D.txt", "5 0 0 4", "^-1 0 0 4", "point id is -1, below 0"),
    ("points3D.txt", "5 0 0 4", "^18446744073709551615 0 0 4", "point id is 18446744073709551615, by which COLMAP means none"),
    ("points3D.txt", "10 20 30", "10 ^256 30", "green is 256, above 255"),
    ("points3D.txt", "0.5 2 0", "^NaN 2 0", "error is NaN, not a finite number"),
    ("rigs.txt", "7 1 1", "7 ^2 1", "pose flag is 2, above 1"),
    // Words.
    ("cameras.txt", "1 OPENCV", "1 ^OPENCV_FISHEY", "no camera model is called `OPENCV_FISHEY`: did you mean OPENCV_FISHEYE?"),
    ("cameras.txt", "1 OPENCV", "1 ^\u{1b}[31m", "no camera model is called `\\u{1b}[31m`"),
    ("rigs.txt", "CAMERA 7", "^Camera 7", "sensor type is `Camera`, expected CAMERA (in binary 0) or IMU (1)"),
    // Twice, or not at all.
    ("cameras.txt", "7 SIMPLE", "^1 SIMPLE", "camera id 1 comes twice"),
    ("images.txt", "3 1 0", "^2 1 0", "image id 2 comes twice"),
    ("points3D.txt", "9 1 1", "^5 1 1", "point id 5 comes twice"),
    ("rigs.txt", "0.5 0 0\n", "0.5 0 0\n^1 0\n", "rig id 1 comes twice"),
    ("rigs.txt", "CAMERA 7", "CAMERA ^1", "camera 1 comes twice"),
    ("frames.txt", "7 3\n", "7 3\n^4 1 1 0 0 0 0 0 1 0\n", "frame id 4 comes twice"),
    ("rigs.txt", "0.5 0 0\n", "0.5 0 0\n2 2 IMU 0 CAMERA ^7 0\n", "camera 7 is already on rig 1"),
    ("images.txt", "7 b.jpg", "7 ^a.jpg", "another image has the name `a.jpg`"),
    ("images.txt", "7 b.jpg", "^8 b.jpg", "there is no camera 8"),
    ("images.txt", "-1 12.5", "^6 12.5", "there is no point 6"),
    ("images.txt", "-1 12.5", "^9 12.5", "the track of point 9 does not name this keypoint"),
    ("points3D.txt", "2 0 3 1", "^8 0 3 1", "there is no image 8"),
    ("points3D.txt", "2 0 3 1", "2 0 3 ^2", "image 3 has no keypoint 2: it has 2, counted from 0"),
    ("points3D.txt", "2 0 3 1", "2 ^1 3 1", "keypoint 1 of image 2 belongs to no point"),
    ("points3D.txt", "2 0 3 1", "2 ^2 3 1", "keypoint 2 of image 2 belongs to point 9"),
    ("points3D.txt", "2 0 3 1", "2 0 2 ^0", "keypoint 0 of image 2 comes twice in the track"),
    ("rigs.txt", "CAMERA 7", "CAMERA ^8", "there is no camera 8"),
    ("frames.txt", "4 1 1", "4 ^2 1", "there is no rig 2"),
    ("frames.txt", "CAMERA 7 3", "CAMERA 7 ^8", "there is no image 8"),
    ("frames.txt", "CAMERA 7 3", "CAMERA 7 ^4294967298", "there is no image 4294967298"),
    ("frames.txt", "CAMERA 7 3", "IMU ^7 3", "rig 1 has no IMU 7"),
    ("frames.txt", "CAMERA 7 3", "CAMERA 7 ^2", "image 2 was taken by camera 1"),
    ("frames.txt", "CAMERA 7 3", "CAMERA 1 ^2", "image 2 is already in frame 4"),
];

/// The small model with one of its files changed.
fn model_with(file: &str, content: impl AsRef<[u8]>) -> tempfile::TempDir {
    let other = |(name, whole): &(&'static str, &'static str)| (*name, whole.as_bytes().to_vec());
    let mut files: Vec<(&str, Vec<u8>)> = TEXT.iter().map(other).collect();
    for (name, whole) in &mut files {
        if *name == file {
            *whole = content.as_ref().to_vec();
        }
    }
    folder(&files)
}

#[test]
fn every_damage_is_told_at_its_place() {
    for (file, was, marked, reason) in DAMAGES {
        let case = format!("{file}: {was} -> {marked}");
        assert!(text(file).contains(was), "{case}");
        let marked = text(file).replacen(was, marked, 1);
        let (before, after) = marked.split_once('^').expect("a marked place");
        let model = model_with(file, format!("{before}{after}"));
        let error = read(model.path()).expect_err(&case);
        let shown = error.to_string();
        let ReadError::Line { file: found, line, column, text, why } = error else {
            panic!("{case}: {shown}");
        };
        let last_line = before.rsplit('\n').next().expect("a line");
        assert_eq!(why.to_string(), *reason, "{case}");
        assert_eq!(found, model.path().join(file), "{case}");
        assert_eq!(line, 1 + before.matches('\n').count(), "{case}");
        assert_eq!(column, 1 + last_line.chars().count(), "{case}");
        let under_caret = text.text.chars().nth(text.caret);
        let wanted = after.chars().next().filter(|c| !c.is_whitespace());
        let wanted = wanted.map(|c| if c.is_control() { '\\' } else { c });
        assert_eq!(under_caret, wanted, "{case}: {shown}");
        assert!(!shown.contains('\u{1b}'), "{case}");
    }
    assert!(DAMAGES.len() >= 60);
}

#[test]
fn an_error_shows_its_line_with_a_caret() {
    let model = folder(&[("m/cameras.txt", "# a\n\n1 OPENCV 1280 960 500 500 640\n")]);
    let shown = read(&model.path().join("m")).expect_err("damaged").to_string();
    let shown =
        shown.strip_prefix(&format!("{}/", model.path().display())).expect("the path first");
    let wanted = "m/cameras.txt:3:3: OPENCV takes 8 parameters, found 3\n\
                  \x20 3 | 1 OPENCV 1280 960 500 500 640\n\
                  \x20   |   ^";
    assert_eq!(shown, wanted);
}

#[test]
fn a_track_may_not_name_a_keypoint_of_another_point() {
    let images = text("images.txt").replace("20.5 5", "20.5 6");
    let error = read(model_with("images.txt", images).path()).expect_err("damaged");
    assert_eq!(
        error.why().expect("a reason").to_string(),
        "keypoint 0 of image 2 belongs to point 6"
    );
    let ReadError::Line { file, line: 2, column: 24, .. } = error else { panic!("{error}") };
    assert!(file.ends_with("points3D.txt"));
}

#[test]
fn a_file_without_cameras_is_no_cameras_file() {
    for content in ["", "# nothing\n\n", "\r\n", "\u{feff}"] {
        let model = folder(&[("cameras.txt", content)]);
        let error = read(model.path()).expect_err("empty");
        assert!(matches!(error, ReadError::File { why: Why::NoCamera, .. }), "{error}");
    }
}

#[test]
fn every_image_must_be_in_a_frame() {
    let frames = text("frames.txt").replace("2 CAMERA 1 2 CAMERA 7 3", "1 CAMERA 1 2");
    let error = read(model_with("frames.txt", frames).path()).expect_err("damaged");
    let shown = error.to_string();
    assert!(shown.ends_with("frames.txt: image 3 is in no frame"), "{shown}");
}

#[test]
fn ids_may_be_0_or_one_less_than_none() {
    let last = u32::MAX - 1;
    let files = [
        ("cameras.txt", format!("0 SIMPLE_PINHOLE 1 1 1 0 0\n{last} SIMPLE_PINHOLE 1 1 1 0 0\n")),
        (
            "images.txt",
            format!(
                "0 1 0 0 0 0 0 0 0 a\n1 1 0\n{last} 1 0 0 0 0 0 0 {last} b\n2 2 18446744073709551614\n"
            ),
        ),
        (
            "points3D.txt",
            format!("0 0 0 0 0 0 0 0 0 0\n18446744073709551614 0 0 0 0 0 0 0 {last} 0\n"),
        ),
        ("rigs.txt", format!("0 2 CAMERA 0 IMU {last} 0\n{last} 2 CAMERA {last} IMU 0 0\n")),
        (
            "frames.txt",
            format!(
                "0 0 1 0 0 0 0 0 0 1 CAMERA 0 0\n{last} {last} 1 0 0 0 0 0 0 2 CAMERA {last} {last} IMU 0 18446744073709551615\n"
            ),
        ),
    ];
    let scene = read(folder(&files).path()).expect("sound");
    assert_eq!(scene.cameras.keys().map(|id| id.0).collect::<Vec<_>>(), [0, last]);
    let geometry = scene.geometry.expect("geometry");
    let points: Vec<u64> = geometry.points.iter().map(|point| point.id.0).collect();
    assert_eq!(points, [0, u64::MAX - 1]);
    assert_eq!(geometry.mounting.expect("mounting").frames.len(), 2);
}

#[test]
fn files_that_need_each_other_are_missed() {
    let cases = [
        ("points3D.txt", "images.txt: points3D.txt must stand beside it, and does not"),
        ("images.txt", "points3D.txt: images.txt must stand beside it, and does not"),
        ("frames.txt", "rigs.txt: frames.txt must stand beside it, and does not"),
        ("rigs.txt", "frames.txt: rigs.txt must stand beside it, and does not"),
    ];
    for (missing, wanted) in cases {
        let files: Vec<_> = TEXT.into_iter().filter(|(name, _)| *name != missing).collect();
        let shown = read(folder(&files).path()).expect_err(missing).to_string();
        assert!(shown.ends_with(wanted), "{shown}");
    }
    let files = [TEXT[0], TEXT[3], TEXT[4]];
    let shown = read(folder(&files).path()).expect_err("no images").to_string();
    assert!(shown.ends_with("rigs.txt: images.txt must stand beside it, and does not"), "{shown}");
    let shown = read(folder(&TEXT[1..]).path()).expect_err("no cameras").to_string();
    assert!(shown.contains("cameras.txt: cannot be read"), "{shown}");
}

#[test]
fn names_and_encodings_that_are_not_utf8_are_told() {
    let images = text("images.txt").replace("b.jpg", "ä^.jpg");
    let bytes: Vec<u8> =
        images.bytes().map(|byte| if byte == b'^' { 0xff } else { byte }).collect();
    let error = read(model_with("images.txt", bytes).path()).expect_err("not UTF-8");
    assert!(
        matches!(
            error,
            ReadError::Line { line: 4, column: 20, why: Why::NotUtf8("image name"), .. }
        ),
        "{error}"
    );
    let error = read(model_with("cameras.txt", "\u{feff}1 OPENCW").path()).expect_err("no model");
    assert!(matches!(error, ReadError::Line { line: 1, column: 3, .. }), "{error}");
    let utf16: Vec<u8> = format!("\u{feff}{}", text("cameras.txt"))
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    let error = read(model_with("cameras.txt", utf16).path()).expect_err("UTF-16");
    assert!(
        matches!(error, ReadError::Line { line: 1, column: 1, why: Why::Utf16, .. }),
        "{error}"
    );
}

#[test]
fn a_file_cut_anywhere_is_read_or_refused_and_never_a_panic() {
    let mut refused = 0;
    let model = folder(&TEXT);
    for (file, whole) in TEXT {
        for length in 0..whole.len() {
            std::fs::write(model.path().join(file), &whole[..length]).expect("written");
            refused += usize::from(read(model.path()).is_err());
        }
        std::fs::write(model.path().join(file), whole).expect("written");
    }
    let bytes: usize = TEXT.iter().map(|(_, whole)| whole.len()).sum();
    assert!(refused > bytes / 2 && refused < bytes, "{refused} of {bytes}");
    assert!(read(model.path()).is_ok());
}

#[test]
fn a_word_as_long_as_a_file_is_cut_in_the_message() {
    let long = "x".repeat(1 << 20);
    for line in [long.clone(), format!("1 {long}"), format!("1 OPENCV {long}")] {
        let model = folder(&[("cameras.txt", line)]);
        let shown = read(Path::new(&model.path())).expect_err("no camera").to_string();
        assert!(shown.len() < 1000, "{}", shown.len());
    }
}
