//! Images and points, read together: quickly when all is well, once more in order when anything is not.
//!
//! The quick way uses all threads and only says whether the files are sound; the slow way says what is wrong first, and
//! where. So a message does not depend on the number of threads.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use super::block::{Blocks, Open};
use super::images::{Distinct, IMAGES, Images};
use super::points::{POINTS, Points, ReadPoint};
use super::sightings::{Claims, Seen};
use super::workers::read_in_order;
use super::{Form, ReadError};
use crate::scene::{Camera, CameraId, Image, ImageId, Point3DId, Points3D};

/// The two files, and what they may refer to.
pub struct GeometryFiles<'a> {
    /// How they are written.
    pub form: Form,
    /// The cameras that may have taken the images.
    pub cameras: &'a BTreeMap<CameraId, Camera>,
    /// The images.
    pub images: &'a Path,
    /// The points.
    pub points: &'a Path,
    /// How they are opened.
    pub open: Open<'a>,
    /// In how many bytes at a time they are read, about.
    pub block_size: usize,
}

type Read = (BTreeMap<ImageId, Image>, Points3D);

impl GeometryFiles<'_> {
    /// Reads both.
    pub fn read(&self) -> Result<Read, ReadError> {
        match self.read_at_once() {
            Some(read) => Ok(read),
            None => self.read_in_order(),
        }
    }

    fn image_blocks(&self) -> Result<Blocks, ReadError> {
        Blocks::of(self.images, self.open, self.form, &IMAGES, self.block_size)
    }

    fn point_blocks(&self) -> Result<Blocks, ReadError> {
        Blocks::of(self.points, self.open, self.form, &POINTS, self.block_size)
    }

    /// Reads with all threads; none when anything is wrong.
    fn read_at_once(&self) -> Option<Read> {
        let mut images = BTreeMap::new();
        let mut image_count = 0;
        read_in_order(
            self.image_blocks().ok()?,
            |block| {
                let mut read = Vec::new();
                let mut take = |id, image| read.push((id, image));
                block.read(self.form, Images { cameras: self.cameras, take: &mut take }).ok()?;
                Some(read)
            },
            |read: Vec<(ImageId, Image)>| {
                image_count += read.len();
                images.extend(read);
            },
        )?;
        let seen = Seen::of(&images);
        let mut points = Points3D::default();
        read_in_order(
            self.point_blocks().ok()?,
            |block| {
                let (mut read, mut agrees) = (Points3D::default(), true);
                let mut take = |point: ReadPoint| {
                    agrees &= seen.agrees(&point);
                    read.push(point);
                };
                block.read(self.form, Points { take: &mut take }).ok()?;
                agrees.then_some(read)
            },
            |read| points.append(read),
        )?;
        let names: HashSet<&str> = images.values().map(|image| image.name.as_str()).collect();
        let is_sound = image_count == images.len()
            && image_count == names.len()
            && points.observation_count() == seen.observation_count()
            && all_differ(&points);
        is_sound.then_some((images, points))
    }

    /// Reads one record after the other, to the first that is wrong.
    fn read_in_order(&self) -> Result<Read, ReadError> {
        let mut read = Distinct::default();
        self.image_blocks()?.for_each(|block| {
            let records = Images { cameras: self.cameras, take: &mut read };
            block.read(self.form, records)
        })?;
        let images = read.images;
        let mut claims = Claims::on(Seen::of(&images));
        self.point_blocks()?
            .for_each(|block| block.read(self.form, Points { take: &mut claims }))?;
        match claims.into_points() {
            Ok(points) => Ok((images, points)),
            Err(mut unclaimed) => {
                // The place of what is known to be wrong is found by reading the images again.
                self.image_blocks()?.for_each(|block| {
                    let records = Images { cameras: self.cameras, take: &mut unclaimed };
                    block.read(self.form, records)
                })?;
                Err(ReadError::changed(self.images))
            }
        }
    }
}

/// Whether no two points have one id.
fn all_differ(points: &Points3D) -> bool {
    if points.ids().is_sorted_by(|one, next| one < next) {
        return true;
    }
    let mut ids: Vec<Point3DId> = points.ids().collect();
    ids.sort_unstable();
    ids.is_sorted_by(|one, next| one < next)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::*;
    use crate::colmap::ModelFiles;
    use crate::colmap::block::{BLOCK_SIZE, Block, Opened};
    use crate::colmap::cameras::Cameras;
    use crate::scene::{Pose, TrackElement};

    /// Files of 20 images that see 40 points, each point in five of them, as text.
    fn text_files() -> [(&'static str, String); 3] {
        let mut keypoints = vec![String::new(); 20];
        let mut counts = [0; 20];
        let mut points = String::from("# a comment\n\n");
        for point in 0..40 {
            let id = 7 * (40 - point);
            _ = write!(points, "{id} {point}.5 -0.{point} 1e-3 1 2 3 0.25");
            for image in (0..5).map(|step| (point + 3 * step) % 20) {
                _ = write!(points, " {} {}", image + 1, counts[image]);
                _ = write!(keypoints[image], "{point}.25 1234.5678901234567 {id}  0.5 .5 -1 ");
                counts[image] += 2;
            }
            points.push('\n');
        }
        let mut images = String::from("\u{feff}# two lines an image\n");
        for (image, keypoints) in keypoints.iter().enumerate() {
            let id = image + 1;
            _ = writeln!(
                images,
                "{id} 1 0 0 0 0 0 {image} 1 {id}.jpg\r\n{}\n\n",
                keypoints.trim_end()
            );
        }
        images.push_str("21 1 0 0 0 0 0 0 1 sees nothing.jpg\n\n");
        let cameras = "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1".to_owned();
        [("cameras.txt", cameras), ("images.txt", images), ("points3D.txt", points)]
    }

    /// The same in binary, of the same camera.
    fn binary_files((images, points): &Read) -> [(&'static str, Vec<u8>); 3] {
        let mut file = (images.len() as u64).to_le_bytes().to_vec();
        for (id, image) in images {
            let Pose { quaternion, translation } = image.cam_from_world;
            file.extend(id.0.to_le_bytes());
            file.extend(
                [&quaternion[..], &translation].concat().iter().flat_map(|x| x.to_le_bytes()),
            );
            file.extend(image.camera.0.to_le_bytes());
            file.extend(image.name.bytes().chain([0]));
            file.extend((image.keypoints.len() as u64).to_le_bytes());
            for keypoint in image.keypoints.iter() {
                file.extend(keypoint.xy.iter().flat_map(|x| x.to_le_bytes()));
                file.extend(keypoint.point.map_or(u64::MAX, |id| id.0).to_le_bytes());
            }
        }
        let images = std::mem::replace(&mut file, (points.len() as u64).to_le_bytes().to_vec());
        for point in points.iter() {
            file.extend(point.id.0.to_le_bytes());
            file.extend(point.xyz.iter().flat_map(|x| x.to_le_bytes()));
            file.extend(point.rgb);
            file.extend(point.error_px.to_le_bytes());
            file.extend((point.track.len() as u64).to_le_bytes());
            let element = |one: TrackElement| [one.image.0, one.keypoint];
            file.extend(point.track.flat_map(element).flat_map(u32::to_le_bytes));
        }
        let mut cameras = [1_u64.to_le_bytes(), [1, 0, 0, 0, 2, 0, 0, 0]].concat();
        cameras.extend([640_u64, 480].iter().flat_map(|x| x.to_le_bytes()));
        cameras.extend([500.0, 320.0, 240.0, -0.1_f64].iter().flat_map(|x| x.to_le_bytes()));
        [("cameras.bin", cameras), ("images.bin", images), ("points3D.bin", file)]
    }

    fn folder<Content: AsRef<[u8]>>(files: &[(&str, Content)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
        folder
    }

    /// What both ways make of the two files, in blocks of this size by this many threads.
    fn read(
        folder: &tempfile::TempDir,
        block_size: usize,
        threads: usize,
    ) -> (Option<Read>, Result<Read, String>) {
        let model = ModelFiles::in_folder(folder.path()).unwrap();
        let cameras = Block::of_whole_file(&model.cameras, &Opened::file)
            .unwrap()
            .read(model.form, Cameras)
            .unwrap();
        let (images, points) = (model.images.unwrap(), model.points.unwrap());
        let files = GeometryFiles {
            form: model.form,
            cameras: &cameras,
            images: &images,
            points: &points,
            open: &Opened::file,
            block_size,
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let shown = |error: ReadError| error.to_string();
        (pool.install(|| files.read_at_once()), files.read_in_order().map_err(shown))
    }

    /// A file of `text_files`, what is replaced in it by what, and a part of the message.
    type Damage = (usize, &'static [(&'static str, &'static str)], &'static str);

    const BLOCK_SIZES: [usize; 6] = [1, 7, 64, 333, 1000, BLOCK_SIZE];

    #[test]
    fn neither_blocks_nor_threads_nor_the_way_make_a_difference() {
        let text = folder(&text_files());
        let whole = read(&text, BLOCK_SIZE, 1).1.unwrap();
        let binary = folder(&binary_files(&whole));
        assert_eq!((whole.0.len(), whole.1.len(), whole.1.observation_count()), (21, 40, 200));
        let mut checked = 0;
        for folder in [text, binary] {
            for block_size in BLOCK_SIZES {
                for threads in [1, 2, 3, 8] {
                    let (at_once, in_order) = read(&folder, block_size, threads);
                    assert!(at_once.as_ref() == Some(&whole), "{block_size} {threads}");
                    assert!(in_order.as_ref() == Ok(&whole), "{block_size} {threads}");
                    checked += 1;
                }
            }
        }
        assert_eq!(checked, 48);
    }

    #[test]
    fn a_damaged_binary_file_has_one_message_whatever_the_blocks() {
        let whole = read(&folder(&text_files()), BLOCK_SIZE, 1).1.unwrap();
        let mut checked = 0;
        for file in [1, 2] {
            let intact = binary_files(&whole);
            let length = intact[file].1.len();
            // Every 97th byte changed, the file cut there, or longer than it says.
            for at in (0..length).step_by(97) {
                for damage in 0..3 {
                    let mut files = intact.clone();
                    match damage {
                        0 => files[file].1[at] ^= 0x55,
                        1 => files[file].1.truncate(at),
                        _ => files[file].1.extend(std::iter::repeat_n(0, 1 + at)),
                    }
                    let folder = folder(&files);
                    let (_, wanted) = read(&folder, BLOCK_SIZE, 1);
                    for block_size in [1, 64, 1000] {
                        let (at_once, in_order) = read(&folder, block_size, 2);
                        assert!(in_order == wanted, "{at} {damage} {block_size}");
                        assert!(at_once.as_ref() == wanted.as_ref().ok(), "{at} {damage}");
                        checked += 1;
                    }
                }
            }
        }
        assert!(checked > 1000, "{checked}");
    }

    #[test]
    fn the_first_of_two_errors_is_told_whatever_the_blocks() {
        // Up to two damages in a file, images or points; the message must be of the first.
        let damages: [Damage; 8] = [
            (1, &[(" 5 1 6.jpg", " x 1 6.jpg"), (" 12 1 13.jpg", " y 1 13.jpg")], "tz is `x`"),
            (1, &[("\n9 1 0", "\n8 1 0"), ("\n12 1 0", "\n12 0 0")], "image id 8 comes twice"),
            (1, &[(" -1 ", " 6 ")], "there is no point 6"),
            (1, &[(" -1 ", " 280 ")], "the track of point 280 does not name this keypoint"),
            (1, &[(" 280 ", " 279 ")], "belongs to point 279"),
            (2, &[("280 0.5", "281 0.5"), ("7 39.5", "7 nan")], "belongs to point 280"),
            (2, &[("\n7 39.5", "\n14 39.5")], "points3D.txt:42:1: point id 14 comes twice"),
            (2, &[("273 1.5", "273 1.5 x"), ("7 39.5", "7 y")], "points3D.txt:4:9: y is `x`"),
        ];
        let mut checked = 0;
        for (file, changes, wanted) in damages {
            let mut files = text_files();
            for (was, is) in changes {
                assert!(files[file].1.contains(was), "{was}");
                files[file].1 = files[file].1.replacen(was, is, 1);
            }
            let folder = folder(&files);
            let (_, whole) = read(&folder, BLOCK_SIZE, 1);
            let message = whole.unwrap_err();
            assert!(message.contains(wanted), "{wanted}: {message}");
            for block_size in BLOCK_SIZES {
                for threads in [1, 3] {
                    let (at_once, in_order) = read(&folder, block_size, threads);
                    assert!(at_once.is_none(), "{wanted} {block_size}");
                    assert_eq!(in_order.unwrap_err(), message, "{block_size}");
                    checked += 1;
                }
            }
        }
        assert_eq!(checked, 8 * 12);
    }
}
