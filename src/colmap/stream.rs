//! Images and points one after the other, for models larger than memory.

use std::path::PathBuf;

use super::block::{BLOCK_SIZE, Blocks, Opened};
use super::images::{IMAGES, Images};
use super::points::{POINTS, Points, ReadPoint};
use super::source::Layout;
use super::{ModelFiles, ReadError};
use crate::scene::{Image, ImageId};

impl ModelFiles {
    /// Reads the images one after the other, in the order of the file, and keeps none of them.
    ///
    /// Every number is checked, and that the camera of every image exists. What takes more than one image to see is not: an id
    /// that comes twice, a keypoint whose point does not exist. A lone list of cameras has no images. In memory is about as
    /// much of the file as the longest image takes.
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// # let folder = folder.path();
    /// std::fs::write(folder.join("cameras.txt"), "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1")?;
    /// std::fs::write(folder.join("images.txt"), "7 1 0 0 0 0 0 0 1 a.jpg\n10.5 20.5 3 11.5 21.5 -1")?;
    /// # std::fs::write(folder.join("points3D.txt"), "3 0 0 4 10 20 30 0.5 7 0")?;
    /// let model = calibstab::colmap::find_one(folder)?;
    /// let (mut keypoints, mut observations) = (0, 0);
    /// model.for_each_image(|_id, image| {
    ///     keypoints += image.keypoints.len();
    ///     observations += image.keypoints.observation_count();
    /// })?;
    /// assert_eq!((keypoints, observations), (2, 1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn for_each_image(&self, mut visit: impl FnMut(ImageId, Image)) -> Result<(), ReadError> {
        let cameras = self.read_cameras(&Opened::file)?;
        let Some(blocks) = self.blocks(&self.images, &IMAGES)? else { return Ok(()) };
        blocks
            .for_each(|block| block.read(self.form, Images { cameras: &cameras, take: &mut visit }))
    }

    /// Reads the points one after the other, in the order of the file, and keeps none of them.
    ///
    /// Every number is checked. What takes more than one point to see is not: an id that comes twice, a track that names a
    /// keypoint of another point. A lone list of cameras has no points.
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// # let folder = folder.path();
    /// # std::fs::write(folder.join("cameras.txt"), "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1")?;
    /// # std::fs::write(folder.join("images.txt"), "7 1 0 0 0 0 0 0 1 a.jpg\n10.5 20.5 3 11.5 21.5 -1")?;
    /// std::fs::write(folder.join("points3D.txt"), "3 0 0 4 10 20 30 0.5 7 0")?;
    /// let model = calibstab::colmap::find_one(folder)?;
    /// let mut longest_track = 0;
    /// model.for_each_point(|point| longest_track = longest_track.max(point.track.len()))?;
    /// assert_eq!(longest_track, 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn for_each_point(&self, mut visit: impl FnMut(ReadPoint)) -> Result<(), ReadError> {
        let Some(blocks) = self.blocks(&self.points, &POINTS)? else { return Ok(()) };
        blocks.for_each(|block| block.read(self.form, Points { take: &mut visit }))
    }

    fn blocks(
        &self,
        file: &Option<PathBuf>,
        layout: &'static Layout,
    ) -> Result<Option<Blocks>, ReadError> {
        let blocks =
            |path: &PathBuf| Blocks::of(path, &Opened::file, self.form, layout, BLOCK_SIZE);
        file.as_ref().map(blocks).transpose()
    }
}
