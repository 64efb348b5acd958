//! What goes into an analysis: runs, each a scene with its place among the others.

use std::collections::BTreeMap;

use super::InputFile;
use crate::scene::{Camera, CameraId, Scene};

/// One reconstruction among its repeats.
#[derive(Debug, Clone)]
pub struct Run {
    /// The group of runs that repeat one experiment.
    pub group: String,
    /// Its name, unique within the group.
    pub name: String,
    /// The files it was read from.
    pub files: Vec<InputFile>,
    /// What there was to remark when reading it.
    pub remarks: Vec<String>,
    /// The reconstruction.
    pub scene: Scene,
}

/// A camera that a run reconstructed, and the names of the images it took.
#[derive(Debug, Clone)]
pub(super) struct CameraInRun<'a> {
    /// Index of the run.
    pub run: usize,
    pub id: CameraId,
    pub camera: &'a Camera,
    /// None when the run is a lone list of cameras.
    pub image_names: Option<Vec<&'a str>>,
}

impl Run {
    /// The cameras that the run reconstructed: those that took an image, or all of a lone list.
    pub(super) fn cameras(&self, run: usize) -> Vec<CameraInRun<'_>> {
        let mut names: BTreeMap<CameraId, Vec<&str>> = BTreeMap::new();
        for image in self.scene.geometry.iter().flat_map(|geometry| geometry.images.values()) {
            names.entry(image.camera).or_default().push(&image.name);
        }
        let is_lone = self.scene.geometry.is_none();
        self.scene
            .cameras
            .iter()
            .filter(|(id, _)| is_lone || names.contains_key(id))
            .map(|(&id, camera)| CameraInRun {
                run,
                id,
                camera,
                image_names: names.get(&id).cloned(),
            })
            .collect()
    }

    /// Cameras that stand in the model and took no image.
    pub(super) fn unused_cameras(&self) -> Vec<CameraId> {
        let used: Vec<CameraId> = self.cameras(0).iter().map(|camera| camera.id).collect();
        self.scene.cameras.keys().filter(|id| !used.contains(id)).copied().collect()
    }
}
