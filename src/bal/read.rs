//! From a problem's text to a scene.
//!
//! Numbers apart by blanks or line ends: the counts of cameras, points and observations; camera, point, x, y of each
//! observation; rotation, translation, f, k1, k2 of each camera; each point.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use super::error::{ReadError, Why};
use super::rotation::quaternion;
use crate::camera::Intrinsics;
use crate::scene::{
    Camera, CameraId, Geometry, Image, ImageId, Keypoint, Keypoints, Point3D, Point3DId, Points3D,
    Pose, Scene, TrackElement,
};

/// The fewest bytes, blanks included, that a camera, a point and an observation take.
const LEAST_BYTES: [u64; 3] = [18, 6, 8];

/// Longer words from the file are cut in messages.
const LONGEST_WORD: usize = 40;

/// What COLMAP writes for an error that was not computed.
const NO_ERROR: f64 = -1.0;

/// Whether this file begins as a problem does, with a line of three numbers; no file of COLMAP's does.
pub fn is_problem(file: &Path) -> bool {
    /// Three numbers of 20 digits and a fourth word fit in.
    const FIRST_LINE: u64 = 128;
    let mut start = Vec::new();
    let read = File::open(file).and_then(|file| file.take(FIRST_LINE).read_to_end(&mut start));
    let first = String::from_utf8_lossy(&start);
    let words: Vec<&str> = first.lines().next().unwrap_or_default().split_whitespace().collect();
    read.is_ok() && words.len() == 3 && words.iter().all(|word| word.parse::<f64>().is_ok())
}

/// Reads a problem: camera, image and point number i get the id i + 1.
///
/// The format has no image sizes: an image is taken to be as large as its observations need.
pub fn read(file: &Path) -> Result<Scene, ReadError> {
    let bytes =
        fs::read(file).map_err(|source| ReadError::Open { file: file.to_owned(), source })?;
    parse(&bytes).map_err(|(at, why)| {
        let (line, column) = place(&bytes, at);
        ReadError::Line { file: file.to_owned(), line, column, why }
    })
}

/// The line and column of a byte, both from 1.
fn place(bytes: &[u8], at: usize) -> (usize, usize) {
    let before = &bytes[..at];
    let start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
    let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
    (line, 1 + String::from_utf8_lossy(&before[start..]).chars().count())
}

/// The same for a problem in memory; an error comes with the byte at which reading stopped.
pub fn parse(bytes: &[u8]) -> Result<Scene, (usize, Why)> {
    let mut words = Words { bytes, at: 0, mark: 0 };
    let [camera_count, point_count, observation_count] = words.counts()?;
    let Seen { by_camera, tracks } =
        words.observations(observation_count, camera_count, point_count)?;
    let mut cameras = BTreeMap::new();
    let mut images = BTreeMap::new();
    for (number, keypoints) in (0..).zip(by_camera) {
        let (pose, lens) = words.camera(number)?;
        let (camera, image) = (CameraId(number + 1), ImageId(number + 1));
        cameras.insert(camera, with_size(lens, &keypoints));
        let name = format!("{number:05}");
        images.insert(image, Image { name, camera, cam_from_world: pose, keypoints });
    }
    let mut points = Points3D::default();
    for (number, track) in (0..).zip(tracks) {
        let xyz = words.numbers(|at| format!("coordinate {at} of point {number}"))?;
        let id = Point3DId(number + 1);
        points.push(Point3D { id, xyz, rgb: [0; 3], error_px: NO_ERROR, track });
    }
    words.end()?;
    Ok(Scene { cameras, geometry: Some(Geometry { images, points, mounting: None }) })
}

/// The observations, as those that share them have them.
struct Seen {
    by_camera: Vec<Keypoints>,
    tracks: Vec<Vec<TrackElement>>,
}

/// A camera with an image just large enough for its keypoints.
fn with_size(intrinsics: Intrinsics, keypoints: &Keypoints) -> Camera {
    let mut half = [1.0_f64; 2];
    for keypoint in keypoints.iter() {
        half = [0, 1].map(|axis| half[axis].max(keypoint.xy[axis].abs()));
    }
    #[allow(clippy::cast_possible_truncation)] // what is too large becomes the largest
    let [width, height] = half.map(|half| 2 * (half.ceil() as u64).min(u64::MAX / 2));
    Camera { intrinsics, width, height }
}

/// The words of the file, one after the other.
struct Words<'a> {
    bytes: &'a [u8],
    /// The byte to read next.
    at: usize,
    /// The start of the word read last.
    mark: usize,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a str> {
        let blank = |byte: &u8| !byte.is_ascii_whitespace();
        self.mark = self.at + self.bytes[self.at..].iter().position(blank)?;
        let rest = &self.bytes[self.mark..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at = self.mark + length;
        // What is not UTF-8 is no number either.
        Some(std::str::from_utf8(&rest[..length]).unwrap_or("\u{fffd}"))
    }

    fn word(&mut self, field: impl Fn() -> String) -> Result<&'a str, (usize, Why)> {
        self.next().ok_or_else(|| (self.bytes.len(), Why::Missing(field())))
    }

    fn fault(&self, why: Why) -> (usize, Why) {
        (self.mark, why)
    }

    fn whole(&mut self, field: impl Fn() -> String) -> Result<u32, (usize, Why)> {
        let word = self.word(&field)?;
        // `parse` would take a sign.
        let is_whole = word.bytes().all(|byte| byte.is_ascii_digit());
        let number = if is_whole { word.parse().ok() } else { None };
        number.ok_or_else(|| self.fault(Why::NotWhole { field: field(), text: clipped(word) }))
    }

    fn below(&mut self, count: u32, field: impl Fn() -> String) -> Result<u32, (usize, Why)> {
        let index = self.whole(&field)?;
        let why = || Why::OutOfRange { field: field(), index, count };
        if index < count { Ok(index) } else { Err(self.fault(why())) }
    }

    fn number(&mut self, field: impl Fn() -> String) -> Result<f64, (usize, Why)> {
        let word = self.word(&field)?;
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            Ok(_) => Err(self.fault(Why::NotFinite { field: field(), text: clipped(word) })),
            Err(_) => Err(self.fault(Why::NotANumber { field: field(), text: clipped(word) })),
        }
    }

    /// Several numbers, counted from 1 in messages.
    fn numbers<const N: usize>(
        &mut self,
        field: impl Fn(usize) -> String,
    ) -> Result<[f64; N], (usize, Why)> {
        let mut numbers = [0.0; N];
        for (at, number) in (1..).zip(&mut numbers) {
            *number = self.number(|| field(at))?;
        }
        Ok(numbers)
    }

    /// How many cameras, points and observations there are; so many that they cannot be in the file are refused.
    fn counts(&mut self) -> Result<[u32; 3], (usize, Why)> {
        let mut counts = [0; 3];
        let mut needed = 0;
        let fields =
            ["the number of cameras", "the number of points", "the number of observations"];
        for at in 0..3 {
            counts[at] = self.whole(|| fields[at].to_owned())?;
            needed += u64::from(counts[at]) * LEAST_BYTES[at];
            let left = self.bytes.len() - self.at;
            if needed > left as u64 {
                let field = fields[at].to_owned();
                return Err(self.fault(Why::CountTooLarge { field, count: counts[at], left }));
            }
            if counts[0] == 0 {
                return Err(self.fault(Why::NoCamera));
            }
        }
        Ok(counts)
    }

    fn observations(
        &mut self,
        count: u32,
        camera_count: u32,
        point_count: u32,
    ) -> Result<Seen, (usize, Why)> {
        let mut by_camera = vec![Keypoints::default(); camera_count as usize];
        let mut next_keypoint = vec![0; camera_count as usize];
        let mut tracks = vec![Vec::new(); point_count as usize];
        for number in 0..count {
            let of = |what: &str| format!("the {what} of observation {number}");
            let camera = self.below(camera_count, || of("camera"))?;
            let point = self.below(point_count, || of("point"))?;
            let xy = [self.number(|| of("x"))?, self.number(|| of("y"))?];
            let keypoint = next_keypoint[camera as usize];
            next_keypoint[camera as usize] += 1;
            tracks[point as usize].push(TrackElement { image: ImageId(camera + 1), keypoint });
            let point = Some(Point3DId(u64::from(point) + 1));
            by_camera[camera as usize].push(Keypoint { xy, point });
        }
        Ok(Seen { by_camera, tracks })
    }

    fn camera(&mut self, number: u32) -> Result<(Pose, Intrinsics), (usize, Why)> {
        let field = |at| format!("number {at} of camera {number}");
        let [rx, ry, rz, tx, ty, tz, f, k1, k2] = self.numbers(field)?;
        let pose = Pose { quaternion: quaternion([rx, ry, rz]), translation: [tx, ty, tz] };
        Ok((pose, Intrinsics::BalStrict([f, k1, k2])))
    }

    fn end(&mut self) -> Result<(), (usize, Why)> {
        match self.next() {
            None => Ok(()),
            Some(word) => Err(self.fault(Why::Trailing(clipped(word)))),
        }
    }
}

/// A word from the file, made fit for a message.
fn clipped(word: &str) -> String {
    let more = if word.chars().nth(LONGEST_WORD).is_some() { "…" } else { "" };
    let shown: String = word.chars().take(LONGEST_WORD).flat_map(char::escape_debug).collect();
    shown + more
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cameras, two points; the second camera sees both.
    pub const SMALL: &str = "2 2 3\n0 0 -1.5 2\n1 0 3 -4e1\n1 1 5 6\n\
                         0 0 0.1 0 0 -5 500 -0.1 0.01\n0 0 0 1 2 3 400 0 0\n0 0 0\n1 1 1\n";

    fn fault(text: &str) -> (usize, usize, String) {
        let (at, why) = parse(text.as_bytes()).unwrap_err();
        let (line, column) = place(text.as_bytes(), at);
        (line, column, why.to_string())
    }

    #[test]
    fn a_problem_becomes_a_scene_with_a_camera_an_image() {
        let scene = parse(SMALL.as_bytes()).unwrap();
        let geometry = scene.geometry.unwrap();
        let lens = Intrinsics::BalStrict([400.0, 0.0, 0.0]);
        let camera = Camera { intrinsics: lens, width: 10, height: 80 };
        assert_eq!(scene.cameras[&CameraId(2)], camera);
        let translation = geometry.images[&ImageId(2)].cam_from_world.translation;
        assert_eq!(translation.map(f64::to_bits), [1.0_f64, 2.0, 3.0].map(f64::to_bits));
        assert_eq!(geometry.images[&ImageId(2)].keypoints.len(), 2);
        let tracks: Vec<Vec<TrackElement>> =
            geometry.points.iter().map(|point| point.track.collect()).collect();
        let element = |image, keypoint| TrackElement { image: ImageId(image), keypoint };
        assert_eq!(tracks, [vec![element(1, 0), element(2, 0)], vec![element(2, 1)]]);
    }

    #[test]
    fn damage_is_named_with_its_line_and_column() {
        let cases = [
            ("2 2 3", "-2 2 3", (1, 1), "the number of cameras is `-2`, not a whole number from 0"),
            ("2 2 3", "+2 2 3", (1, 1), "the number of cameras is `+2`, not a whole number"),
            ("2 2 3", "2 2.0 3", (1, 3), "the number of points is `2.0`, not a whole number"),
            ("2 2 3", "0 2 3", (1, 1), "there is no camera in the file"),
            (
                "2 2 3",
                "2 2 4000000000",
                (1, 5),
                "the number of observations is 4000000000, more than the 92",
            ),
            (
                "2 2 3",
                "2 4000000000 3",
                (1, 3),
                "the number of points is 4000000000, more than the 94",
            ),
            (
                "2 2 3",
                "2 2 9999999999",
                (1, 5),
                "the number of observations is `9999999999`, not a whole",
            ),
            (
                "1 1 5 6",
                "2 1 5 6",
                (4, 1),
                "the camera of observation 2 is 2: there are 2, counted from 0",
            ),
            (
                "1 1 5 6",
                "1 7 5 6",
                (4, 3),
                "the point of observation 2 is 7: there are 2, counted from 0",
            ),
            (
                "1 1 5 6",
                "-1 1 5 6",
                (4, 1),
                "the camera of observation 2 is `-1`, not a whole number",
            ),
            ("-4e1", "NaN", (3, 7), "the y of observation 1 is `NaN`, not a finite number"),
            ("-4e1", "1e999", (3, 7), "the y of observation 1 is `1e999`, not a finite number"),
            ("-4e1", "ä\u{1b}[1m", (3, 7), "the y of observation 1 is `ä\\u{1b}[1m`, not a number"),
            ("500", "inf", (5, 16), "number 7 of camera 0 is `inf`, not a finite number"),
            ("1 1 1\n", "1 x 1\n", (8, 3), "coordinate 2 of point 1 is `x`, not a number"),
            ("1 1 1\n", "1 1", (8, 4), "the file ends before coordinate 3 of point 1"),
            ("1 1 1\n", "1 1 1\n7\n", (9, 1), "unexpected `7` after the last point"),
        ];
        for (what, instead, place, why) in cases {
            let (line, column, message) = fault(&SMALL.replacen(what, instead, 1));
            assert_eq!((line, column), place, "{instead}: {message}");
            assert!(message.starts_with(why), "{message}");
        }
        assert_eq!(fault("").2, "the file ends before the number of cameras");
        let long = fault(&SMALL.replacen("500", &"x".repeat(10_000), 1)).2;
        assert!(long.len() < 100 && long.contains("xxx…"), "{long}");
    }

    #[test]
    fn a_problem_that_is_cut_anywhere_is_refused_or_has_lost_only_digits_of_its_end() {
        let mut refused = 0;
        for end in 0..SMALL.len() - 2 {
            let (at, _) = parse(&SMALL.as_bytes()[..end]).unwrap_err();
            assert!(at <= end);
            refused += 1;
        }
        assert!(refused > 80);
        assert!(parse(&[SMALL.as_bytes(), b"\xff"].concat()).is_err());
    }
}
