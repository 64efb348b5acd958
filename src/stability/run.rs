//! What goes into an analysis: runs, each a scene with its place among the others.

use std::collections::BTreeMap;

use super::refinement::{Origin, refined};
use super::{InputFile, Inside};
use crate::bundle::{BundleError, Outcome};
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
    /// The reconstruction, as COLMAP left it.
    pub scene: Scene,
    /// How adjusting it went; none when it was not tried.
    pub refinement: Option<Result<Outcome, BundleError>>,
    /// What the adjustment gives away against itself; none where it was not asked, or cannot be.
    pub inside: Option<Inside>,
}

/// A camera that a run reconstructed, and the names of the images it took.
#[derive(Debug, Clone)]
pub(super) struct CameraInRun<'a> {
    /// Index of the run.
    pub run: usize,
    pub id: CameraId,
    pub camera: &'a Camera,
    pub origin: Origin<'a>,
    /// None when the run is a lone list of cameras.
    pub image_names: Option<Vec<&'a str>>,
}

impl<'a> CameraInRun<'a> {
    /// The camera as a sample; none where refining it failed.
    pub(super) fn calibration(&self) -> Option<&'a Camera> {
        match self.origin {
            Origin::Left | Origin::Refined { .. } => Some(self.camera),
            Origin::Failed => None,
        }
    }

    /// The same as COLMAP left it.
    pub(super) fn as_left(&self, run: &'a Run) -> Self {
        let camera = run.scene.cameras.get(&self.id).unwrap_or(self.camera);
        Self { camera, origin: Origin::Left, ..self.clone() }
    }
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
                origin: Origin::Left,
                image_names: names.get(&id).cloned(),
            })
            .collect()
    }

    /// The same cameras, as our own adjustment made them.
    pub(super) fn refined_cameras(&self, run: usize) -> Vec<CameraInRun<'_>> {
        let mut cameras = self.cameras(run);
        for camera in &mut cameras {
            if let Some(refined) = refined(self, camera.id) {
                (camera.camera, camera.origin) = refined;
            } else {
                camera.origin = Origin::Failed;
            }
        }
        cameras
    }

    /// Cameras that stand in the model and took no image.
    pub(super) fn unused_cameras(&self) -> Vec<CameraId> {
        let used: Vec<CameraId> = self.cameras(0).iter().map(|camera| camera.id).collect();
        self.scene.cameras.keys().filter(|id| !used.contains(id)).copied().collect()
    }
}
