//! What was adjusted, put back into the scene; what did not move keeps every bit.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3};

use super::BundleError;
use super::options::Options;
use super::problem::{Problem, State};
use crate::scene::{
    Frame, FrameId, Geometry, Image, ImageId, Mounting, Points3D, Pose, Rig, RigId, Scene,
    SensorId, SensorKind,
};

/// Puts cameras, poses and points back, with the points' new errors; tells whether rigs had to be dissolved.
pub(super) fn write_back(
    scene: &mut Scene,
    problem: &Problem,
    options: &Options,
    state: &State,
) -> Result<bool, BundleError> {
    for ((id, lens), params) in problem.cameras.iter().zip(&problem.lenses).zip(&state.params) {
        if let Some(camera) = scene.cameras.get_mut(id).filter(|_| !lens.free.is_empty()) {
            let (model, count) = (camera.intrinsics.model(), camera.intrinsics.params().len());
            let adjusted = model.with_params(&params[..count]);
            camera.intrinsics = adjusted.map_err(|error| BundleError::NoLens(*id, error))?;
        }
    }
    let Some(mut geometry) = scene.geometry.take() else { return Ok(false) };
    let mut is_dissolved = false;
    if options.mode.moves_poses() {
        is_dissolved = put_poses(&mut geometry, problem, state);
    }
    let mut places: Vec<Option<[f64; 3]>> = vec![None; geometry.points.len()];
    if options.mode.moves_points() {
        for (&index, point) in problem.points.iter().zip(&state.points) {
            places[index] = Some(problem.frame.point_out(point));
        }
    }
    geometry.points = points(scene, &geometry, &places);
    scene.geometry = Some(geometry);
    Ok(is_dissolved)
}

/// Gives the images their poses, and frames those of their images.
fn put_poses(geometry: &mut Geometry, problem: &Problem, state: &State) -> bool {
    let is_trivial = geometry.mounting.as_ref().is_none_or(is_trivial);
    // Where rigs are dissolved, also what did not move needs a pose of its own.
    let poses = geometry.poses();
    let numbers = (0..problem.images.len()).zip(geometry.images.values_mut()).zip(poses);
    for ((number, image), before) in numbers {
        if problem.sightings[number] > 0 {
            let pose: Pose = problem.frame.pose_out(&state.poses[number]).into();
            image.cam_from_world = facing(pose, &image.cam_from_world);
        } else if let Some(before) = before.filter(|_| !is_trivial) {
            image.cam_from_world = before.into();
        }
    }
    let Geometry { images, mounting, .. } = geometry;
    if is_trivial {
        let frames = mounting.iter_mut().flat_map(|mounting| mounting.frames.values_mut());
        for frame in frames {
            let image =
                frame.data.iter().find_map(|&(sensor, datum)| image_of(images, sensor, datum));
            if let Some((number, image)) =
                image.map(|id| (problem.images.binary_search(&id), &images[&id]))
                && number.is_ok_and(|number| problem.sightings[number] > 0)
            {
                frame.rig_from_world = image.cam_from_world;
            }
        }
    } else {
        *mounting = Some(one_rig_a_camera(images));
    }
    !is_trivial
}

/// Of a quaternion and its negative, the same rotation, the one that is nearer to what was there.
fn facing(pose: Pose, before: &Pose) -> Pose {
    let same: f64 = pose.quaternion.iter().zip(&before.quaternion).map(|(a, b)| a * b).sum();
    let quaternion = if same < 0.0 { pose.quaternion.map(|part| -part) } else { pose.quaternion };
    Pose { quaternion, ..pose }
}

fn image_of(images: &BTreeMap<ImageId, Image>, sensor: SensorId, datum: u64) -> Option<ImageId> {
    let id = (sensor.kind == SensorKind::Camera).then_some(datum)?.try_into().ok().map(ImageId)?;
    images.contains_key(&id).then_some(id)
}

/// Whether every rig is one camera.
fn is_trivial(mounting: &Mounting) -> bool {
    let is_alone = |rig: &Rig| {
        rig.sensors.is_empty()
            && rig.reference.is_none_or(|sensor| sensor.kind == SensorKind::Camera)
    };
    mounting.rigs.values().all(is_alone)
        && mounting.frames.values().all(|frame| frame.data.len() <= 1)
}

/// As COLMAP mounts what is on no rig: a rig for each camera, a frame for each image, of the same numbers.
fn one_rig_a_camera(images: &BTreeMap<ImageId, Image>) -> Mounting {
    let mut mounting = Mounting { rigs: BTreeMap::new(), frames: BTreeMap::new() };
    for (id, image) in images {
        let (rig, camera) = (RigId(image.camera.0), image.camera.0);
        let sensor = SensorId { kind: SensorKind::Camera, id: camera };
        let alone = Rig { reference: Some(sensor), sensors: BTreeMap::new() };
        mounting.rigs.entry(rig).or_insert(alone);
        let data = vec![(sensor, id.0.into())];
        let frame = Frame { rig, rig_from_world: image.cam_from_world, data };
        mounting.frames.insert(FrameId(id.0), frame);
    }
    mounting
}

/// All points, at their new places where they have one, with the mean reprojection error of the observations that can be projected.
fn points(scene: &Scene, geometry: &Geometry, places: &[Option<[f64; 3]>]) -> Points3D {
    let poses: BTreeMap<ImageId, Option<Isometry3<f64>>> =
        geometry.images.keys().copied().zip(geometry.poses()).collect();
    let mut points = Points3D::default();
    for (point, place) in geometry.points.iter().zip(places) {
        let xyz = place.unwrap_or(point.xyz);
        let (mut sum, mut count) = (0.0, 0.0);
        for element in point.track.clone() {
            let image = &geometry.images[&element.image];
            let seen = poses[&element.image].map(|pose| pose.transform_point(&Point3::from(xyz)));
            let camera = &scene.cameras[&image.camera].intrinsics;
            let pixel = seen.and_then(|seen| camera.project(&seen.coords).ok());
            let keypoint = image.keypoints.get(element.keypoint as usize);
            if let Some((pixel, keypoint)) = pixel.zip(keypoint) {
                sum += (pixel - nalgebra::Vector2::from(keypoint.xy)).norm();
                count += 1.0;
            }
        }
        let error_px = if count > 0.0 { sum / count } else { -1.0 };
        points.push(crate::scene::Point3D { xyz, error_px, ..point });
    }
    points
}
