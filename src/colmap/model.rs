//! One model, from its files to a scene: which file is read when, and the checks that take two of them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::block::{BLOCK_SIZE, Block, Open, Opened};
use super::cameras::Cameras;
use super::geometry::GeometryFiles;
use super::mounting::{Frames, Rigs};
use super::source::Records;
use super::{ModelFiles, ReadError, Why};
use crate::scene::{Camera, CameraId, Geometry, Image, ImageId, Mounting, Scene, SensorKind};

/// Two files of which neither goes without the other.
type Pair<'a> = Option<(&'a Path, &'a Path)>;

impl ModelFiles {
    /// Reads the model, or a lone cameras file, and checks every number and every reference in it.
    pub fn read(&self) -> Result<Scene, ReadError> {
        self.read_with(&Opened::file)
    }

    /// The same for files that are elsewhere, in an archive or in memory: `open` gives the content of each.
    ///
    /// ```
    /// use calibstab::colmap::{Form, ModelFiles};
    ///
    /// let model = ModelFiles::lone_cameras("cameras.txt".into(), Form::Text);
    /// let scene = model.read_with(&|_| Ok(b"1 SIMPLE_RADIAL 640 480 500 320 240 -0.1".to_vec().into()))?;
    /// assert_eq!(scene.cameras.len(), 1);
    /// # Ok::<(), calibstab::colmap::ReadError>(())
    /// ```
    pub fn read_with(&self, open: Open) -> Result<Scene, ReadError> {
        let seen = self.pair((&self.images, "images"), (&self.points, "points3D"))?;
        let mounting = self.pair((&self.rigs, "rigs"), (&self.frames, "frames"))?;
        let cameras = self.read_cameras(open)?;
        let geometry = match (seen, mounting) {
            (Some(seen), mounting) => Some(self.read_geometry(&cameras, seen, mounting, open)?),
            (None, Some((rigs, _))) => return Err(self.lone(rigs, "images")),
            (None, None) => None,
        };
        Ok(Scene { cameras, geometry })
    }

    pub(super) fn read_cameras(&self, open: Open) -> Result<BTreeMap<CameraId, Camera>, ReadError> {
        let cameras = self.read_whole(&self.cameras, open, Cameras)?;
        if cameras.is_empty() {
            return Err(ReadError::File { file: self.cameras.clone(), why: Why::NoCamera });
        }
        Ok(cameras)
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
        (images, points): (&Path, &Path),
        mounting: Pair,
        open: Open,
    ) -> Result<Geometry, ReadError> {
        let files = GeometryFiles {
            form: self.form,
            cameras,
            images,
            points,
            open,
            block_size: BLOCK_SIZE,
        };
        let (images, points) = files.read()?;
        let mounting = match mounting {
            Some(files) => Some(self.read_mounting(cameras, &images, files, open)?),
            None => None,
        };
        Ok(Geometry { images, points, mounting })
    }

    fn read_mounting(
        &self,
        cameras: &BTreeMap<CameraId, Camera>,
        images: &BTreeMap<ImageId, Image>,
        (rigs_path, frames_path): (&Path, &Path),
        open: Open,
    ) -> Result<Mounting, ReadError> {
        let rigs = self.read_whole(rigs_path, open, Rigs { cameras })?;
        let frames = self.read_whole(frames_path, open, Frames { rigs: &rigs, images })?;
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

    fn read_whole<R: Records>(
        &self,
        path: &Path,
        open: Open,
        records: R,
    ) -> Result<R::Read, ReadError> {
        let block = Block::of_whole_file(path, open)?;
        let read = block.read(self.form, records);
        read.map_err(|fault| ReadError::at(path, self.form, &block, fault))
    }
}
