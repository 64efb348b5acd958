//! Damaged binary models: every damage has its own message, at its own byte.

use std::fs;

use crate::small_model::{TEXT, binary, folder};
use calibstab::colmap::{ReadError, read};

/// The file, the bytes put over its own and where, the byte that the error must name, and its reason.
#[rustfmt::skip]
const DAMAGES: &[(&str, usize, &[u8], usize, &str)] = &[
    ("cameras.bin", 12, &[99, 0, 0, 0], 12, "no camera model has the id 99"),
    ("cameras.bin", 12, &[255; 4], 12, "no camera model has the id -1"),
    ("cameras.bin", 8, &[255; 4], 8, "camera id is 4294967295, by which COLMAP means none"),
    ("cameras.bin", 16, &[0; 8], 16, "width is 0, expected at least 1"),
    ("cameras.bin", 24, &[0; 8], 24, "height is 0, expected at least 1"),
    ("cameras.bin", 38, &[0xf8, 0x7f], 32, "fx is NaN, not a finite number"),
    ("cameras.bin", 88, &[0, 0, 0, 0, 0, 0, 0xf0, 0xff], 88, "p2 is -inf, not a finite number"),
    ("cameras.bin", 96, &[1], 96, "camera id 1 comes twice"),
    ("cameras.bin", 100, &[4], 152, "the file ends within the k1"),
    ("cameras.bin", 0, &[1], 96, "56 more bytes after the last record"),
    ("cameras.bin", 0, &[3], 152, "the file ends within the camera id"),
    ("cameras.bin", 0, &[4], 0, "4 cameras are announced, more than the 144 bytes that are left can hold"),
    ("cameras.bin", 0, &[255; 8], 0, "18446744073709551615 cameras are announced, more than the 144 bytes that are left can hold"),
    ("images.bin", 0, &[0, 0, 0, 0, 1], 0, "4294967296 images are announced, more than the 276 bytes that are left can hold"),
    ("images.bin", 18, &[0; 2], 12, "the quaternion is 0 0 0 0, which is no rotation"),
    ("images.bin", 66, &[0xf0, 0x7f], 60, "tz is inf, not a finite number"),
    ("images.bin", 68, &[3], 68, "there is no camera 3"),
    ("images.bin", 72, &[0xc3, b'a'], 72, "the image name is not valid UTF-8"),
    ("images.bin", 78, &[11], 78, "11 keypoints are announced, more than the 198 bytes that are left can hold"),
    ("images.bin", 78, &[0, 0, 0, 0, 0, 0, 0, 128], 78, "9223372036854775808 keypoints are announced, more than the 198 bytes that are left can hold"),
    ("images.bin", 86, &[0, 0, 0, 0, 0, 0, 0xf8, 0x7f], 86, "keypoint x is NaN, not a finite number"),
    ("images.bin", 126, &[6, 0, 0, 0, 0, 0, 0, 0], 126, "there is no point 6"),
    ("images.bin", 126, &[9, 0, 0, 0, 0, 0, 0, 0], 126, "the track of point 9 does not name this keypoint"),
    ("images.bin", 158, &[2], 158, "image id 2 comes twice"),
    ("images.bin", 222, b"a", 222, "another image has the name `a.jpg`"),
    ("images.bin", 228, &[1], 260, "24 more bytes after the last record"),
    ("points3D.bin", 8, &[255; 8], 8, "point id is 18446744073709551615, by which COLMAP means none"),
    ("points3D.bin", 43, &[0, 0, 0, 0, 0, 0, 0xf0, 0x7f], 43, "error is inf, not a finite number"),
    ("points3D.bin", 51, &[255], 51, "255 track elements are announced, more than the 83 bytes that are left can hold"),
    ("points3D.bin", 59, &[9], 59, "there is no image 9"),
    ("points3D.bin", 63, &[255; 4], 63, "image 2 has no keypoint 4294967295: it has 3, counted from 0"),
    ("points3D.bin", 67, &[2, 0, 0, 0, 0], 71, "keypoint 0 of image 2 comes twice in the track"),
    ("points3D.bin", 71, &[0], 71, "keypoint 0 of image 3 belongs to point 9"),
    ("points3D.bin", 75, &[5], 75, "point id 5 comes twice"),
    ("rigs.bin", 12, &[3], 89, "the file ends within the sensor type"),
    ("rigs.bin", 12, &[255; 4], 89, "the file ends within the sensor type"),
    ("rigs.bin", 16, &[2], 16, "sensor type is `2`, expected CAMERA (in binary 0) or IMU (1)"),
    ("rigs.bin", 20, &[5], 20, "there is no camera 5"),
    ("rigs.bin", 28, &[1], 28, "camera 1 comes twice"),
    ("rigs.bin", 32, &[2], 32, "pose flag is 2, above 1"),
    ("rigs.bin", 32, &[0], 33, "56 more bytes after the last record"),
    ("frames.bin", 0, &[0], 8, "100 more bytes after the last record"),
    ("frames.bin", 12, &[2], 12, "there is no rig 2"),
    ("frames.bin", 72, &[3], 108, "the file ends within the sensor type"),
    ("frames.bin", 96, &[8], 96, "rig 1 has no camera 8"),
    ("frames.bin", 100, &[2], 100, "image 2 was taken by camera 1"),
    ("frames.bin", 104, &[1], 100, "there is no image 4294967299"),
];

#[test]
fn text_and_binary_of_one_model_are_one_scene() {
    let (text, binary) = (folder(&TEXT), folder(&binary()));
    let scene = read(text.path()).expect("text");
    assert_eq!(scene, read(binary.path()).expect("binary"));
    let geometry = scene.geometry.expect("geometry");
    let mounting = geometry.mounting.expect("mounting");
    let counts = [scene.cameras.len(), geometry.images.len(), geometry.points.len()];
    assert_eq!(counts, [2, 2, 2]);
    assert_eq!((mounting.rigs.len(), mounting.frames.len()), (1, 1));
    assert_eq!(geometry.points.observation_count(), 4);
}

#[test]
fn every_damage_is_told_at_its_byte() {
    let whole = binary();
    let model = folder(&whole);
    for (file, at, bytes, wanted, reason) in DAMAGES {
        let case = format!("{file}: {bytes:?} at {at}");
        let intact = &whole.iter().find(|(name, _)| name == file).expect("one of the five").1;
        let mut damaged = intact.clone();
        damaged[*at..*at + bytes.len()].copy_from_slice(bytes);
        fs::write(model.path().join(file), &damaged).expect("written");
        let error = read(model.path()).expect_err(&case);
        fs::write(model.path().join(file), intact).expect("written");
        let shown = error.to_string();
        let ReadError::Byte { file: found, offset, why } = error else { panic!("{case}: {shown}") };
        assert_eq!(why.to_string(), *reason, "{case}");
        assert_eq!(offset, *wanted, "{case}");
        assert_eq!(found, model.path().join(file), "{case}");
        assert!(shown.ends_with(&format!("{file}: byte {wanted}: {reason}")), "{shown}");
    }
    assert!(DAMAGES.len() >= 40);
}

#[test]
fn no_byte_may_follow_the_last_record() {
    for (index, (file, bytes)) in binary().into_iter().enumerate() {
        let mut files = binary();
        files[index].1.extend_from_slice(&[0; 3]);
        let shown = read(folder(&files).path()).expect_err(file).to_string();
        let at = bytes.len();
        let wanted = format!("{file}: byte {at}: 3 more bytes after the last record");
        assert!(shown.ends_with(&wanted), "{shown}");
    }
}

#[test]
fn a_sensor_is_on_one_rig_only() {
    let mut files = binary();
    let rigs = &mut files[3].1;
    rigs[0] = 2;
    for number in [2_u32, 1, 0, 7] {
        rigs.extend(number.to_le_bytes());
    }
    let shown = read(folder(&files).path()).expect_err("twice").to_string();
    assert!(shown.ends_with("rigs.bin: byte 101: camera 7 is already on rig 1"), "{shown}");
}

#[test]
fn a_name_needs_its_end() {
    let mut files = binary();
    files[1].1.truncate(76);
    let shown = read(folder(&files).path()).expect_err("no end").to_string();
    assert!(shown.ends_with("images.bin: byte 0: 2 images are announced, more than the 68 bytes that are left can hold"), "{shown}");
    files[1].1[0] = 1;
    files[1].1.resize(81, b'a');
    let shown = read(folder(&files).path()).expect_err("no end").to_string();
    assert!(shown.ends_with("images.bin: byte 72: the image name has no end"), "{shown}");
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let whole = binary();
    let model = folder(&whole);
    let mut refused = 0;
    for (file, bytes) in &whole {
        for length in 0..bytes.len() {
            fs::write(model.path().join(file), &bytes[..length]).expect("written");
            let error = read(model.path()).expect_err("cut");
            assert!(matches!(error, ReadError::Byte { offset, .. } if offset <= length), "{error}");
            refused += 1;
        }
        fs::write(model.path().join(file), bytes).expect("written");
    }
    assert_eq!(refused, 152 + 284 + 142 + 89 + 108);
}

#[test]
fn no_byte_makes_the_reader_panic() {
    let whole = binary();
    let model = folder(&whole);
    let mut read_or_refused = 0;
    for (file, bytes) in &whole {
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] = 0xff - damaged[at];
            fs::write(model.path().join(file), &damaged).expect("written");
            read_or_refused += usize::from(matches!(
                read(model.path()),
                Ok(_) | Err(ReadError::Byte { .. } | ReadError::File { .. })
            ));
        }
        fs::write(model.path().join(file), bytes).expect("written");
    }
    assert_eq!(read_or_refused, 775);
}
