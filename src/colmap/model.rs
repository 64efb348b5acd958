//! One model, from its files to a scene: which file is read when, and the checks that take two of them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::binary::Binary;
use super::cameras::Cameras;
use super::images::Images;
use super::mounting::{Frames, Rigs};
use super::points::Points;
use super::sightings::Sightings;
use super::source::Records;
use super::text::Text;
use super::{Form, ModelFiles, ReadError, Why};
use crate::scene::{Camera, CameraId, Geometry, Image, ImageId, Mounting, Scene, SensorKind};

/// Two files of which neither goes without the other.
type Pair<'a> = Option<(&'a Path, &'a Path)>;

impl ModelFiles {
    /// Reads the model, or a lone cameras file, and checks every number and every reference in it.
    pub fn read(&self) -> Result<Scene, ReadError> {
        let seen = self.pair((&self.images, "images"), (&self.points, "points3D"))?;
        let mounting = self.pair((&self.rigs, "rigs"), (&self.frames, "frames"))?;
        let cameras = self.open(&self.cameras)?.read(Cameras)?;
        if cameras.is_empty() {
            return Err(ReadError::File { file: self.cameras.clone(), why: Why::NoCamera });
        }
        let geometry = match (seen, mounting) {
            (Some(seen), mounting) => Some(self.read_geometry(&cameras, seen, mounting)?),
            (None, Some((rigs, _))) => return Err(self.lone(rigs, "images")),
            (None, None) => None,
        };
        Ok(Scene { cameras, geometry })
    }

    fn pair<'a>(
        &self,
        (first, first_name): (&'a Option<PathBuf>, &str),
        (second, second_name): (&'a Option<PathBuf>, &str),
    ) -> Result<Pair<'a>, ReadError> {
        match (first, second) {
            (Some(first), Some(second)) => Ok(Some((first, second))),
            (None, None) => Ok(None),
            (Some(first), None) => Err(self.lone(first, second_name)),
            (None, Some(second)) => Err(self.lone(second, first_name)),
        }
    }

    fn lone(&self, file: &Path, missing: &str) -> ReadError {
        ReadError::Incomplete { file: file.to_owned(), missing: self.form.file_name(missing) }
    }

    fn read_geometry(
        &self,
        cameras: &BTreeMap<CameraId, Camera>,
        (images_path, points_path): (&Path, &Path),
        mounting: Pair,
    ) -> Result<Geometry, ReadError> {
        let images_file = self.open(images_path)?;
        let images = images_file.read(Images { cameras, check: |_, _, _| Ok(()) })?;
        let mut sightings = Sightings::of(&images);
        let points = self.open(points_path)?.read(Points { sightings: &mut sightings })?;
        if !sightings.are_all_claimed() {
            // Reads a second time what is known to be wrong, to find the place.
            let check = |image, index, point| sightings.check(image, index, point, &points);
            images_file.read(Images { cameras, check })?;
        }
        let mounting = match mounting {
            Some(files) => Some(self.read_mounting(cameras, &images, files)?),
            None => None,
        };
        Ok(Geometry { images, points, mounting })
    }

    fn read_mounting(
        &self,
        cameras: &BTreeMap<CameraId, Camera>,
        images: &BTreeMap<ImageId, Image>,
        (rigs_path, frames_path): (&Path, &Path),
    ) -> Result<Mounting, ReadError> {
        let rigs = self.open(rigs_path)?.read(Rigs { cameras })?;
        let frames = self.open(frames_path)?.read(Frames { rigs: &rigs, images })?;
        let data = frames.values().flat_map(|frame| &frame.data);
        let in_frames: BTreeSet<u64> = data
            .filter(|(sensor, _)| sensor.kind == SensorKind::Camera)
            .map(|&(_, datum)| datum)
            .collect();
        match images.keys().find(|id| !in_frames.contains(&id.0.into())) {
            Some(&image) => {
                Err(ReadError::File { file: frames_path.to_owned(), why: Why::InNoFrame(image) })
            }
            None => Ok(Mounting { rigs, frames }),
        }
    }

    fn open<'a>(&self, path: &'a Path) -> Result<File<'a>, ReadError> {
        let bytes =
            fs::read(path).map_err(|source| ReadError::Open { file: path.to_owned(), source })?;
        Ok(File { path, form: self.form, bytes })
    }
}

/// A file of a model, in memory.
struct File<'a> {
    path: &'a Path,
    form: Form,
    bytes: Vec<u8>,
}

impl File<'_> {
    fn read<R: Records>(&self, records: R) -> Result<R::Read, ReadError> {
        let read = match self.form {
            Form::Text => Text::new(&self.bytes).and_then(|mut text| records.read(&mut text)),
            Form::Binary => records.read(&mut Binary::new(&self.bytes)),
        };
        read.map_err(|fault| ReadError::at(self.path, self.form, &self.bytes, fault))
    }
}
