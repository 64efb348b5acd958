//! How well a lens found from some images fits the others.
//!
//! Nothing that is measured is fitted: points stay where the chosen images put them, the lens too, and of each other image half
//! of the observations of such points settle its pose and the other half are measured.

use std::collections::{BTreeMap, BTreeSet};

use crate::bundle::{self, CameraOutcome, Mode, Options};
use crate::scene::{
    Geometry, Image, ImageId, Keypoint, Keypoints, Point3D, Point3DId, Points3D, Scene,
    TrackElement,
};
use crate::stability::failure_of_sample;
use crate::stats::Sorted;

/// With fewer observations a pose fits whatever it is given.
const LEAST_FOR_A_POSE: usize = 8;

/// Half of what the images that were not chosen see of the points, by which they are posed, and the other half.
struct Halves {
    images: BTreeMap<ImageId, Image>,
    tracks: BTreeMap<Point3DId, Vec<TrackElement>>,
    measured: Vec<(ImageId, [f64; 2], Point3DId)>,
}

/// The median distance in px between where the other images see points and where the lens, the points of the chosen images, and
/// poses from other observations put them. None where no image sees enough of them, or no poses are found.
pub(super) fn median_px(seen: &Scene, chosen: &Scene) -> Option<f64> {
    let [all, own] = [seen.geometry.as_ref()?, chosen.geometry.as_ref()?];
    let places: BTreeMap<Point3DId, [f64; 3]> =
        own.points.iter().map(|point| (point.id, point.xyz)).collect();
    let chosen_images: BTreeSet<ImageId> = own.images.keys().copied().collect();
    let halves = Halves::new(all, &chosen_images, &places);
    let mut points = Points3D::default();
    for (id, track) in &halves.tracks {
        points.push(Point3D { id: *id, xyz: places[id], rgb: [0; 3], error_px: -1.0, track });
    }
    let geometry = Geometry { images: halves.images, points, mounting: None };
    let others = Scene { cameras: chosen.cameras.clone(), geometry: Some(geometry) };
    let options = Options { mode: Mode::OnlyPose, ..Options::default() };
    let posed = bundle::adjust(others, &options, &mut |_| {}).ok()?;
    let failure = |camera: &CameraOutcome| failure_of_sample(&posed.outcome, camera.id);
    if posed
        .outcome
        .cameras
        .iter()
        .filter(|camera| camera.images > 0)
        .any(|it| failure(it).is_some())
    {
        return None;
    }
    let geometry = posed.scene.geometry?;
    let poses: BTreeMap<ImageId, _> =
        geometry.images.keys().copied().zip(geometry.poses()).collect();
    let distance = |&(image, xy, point): &(ImageId, [f64; 2], Point3DId)| {
        let pose = poses.get(&image)?.as_ref()?;
        let lens = &posed.scene.cameras[&geometry.images[&image].camera].intrinsics;
        let pixel = lens.project(&pose.transform_point(&places[&point].into()).coords).ok()?;
        Some((pixel - nalgebra::Vector2::from(xy)).norm())
    };
    Some(Sorted::new(halves.measured.iter().filter_map(distance).collect())?.median())
}

impl Halves {
    fn new(
        all: &Geometry,
        chosen: &BTreeSet<ImageId>,
        places: &BTreeMap<Point3DId, [f64; 3]>,
    ) -> Self {
        let mut halves =
            Self { images: BTreeMap::new(), tracks: BTreeMap::new(), measured: Vec::new() };
        for (&id, image) in all.images.iter().filter(|(id, _)| !chosen.contains(id)) {
            let known = |keypoint: Keypoint| {
                let point = keypoint.point.filter(|point| places.contains_key(point))?;
                Some((keypoint.xy, point))
            };
            let known: Vec<([f64; 2], Point3DId)> =
                image.keypoints.iter().filter_map(known).collect();
            if known.len() < 2 * LEAST_FOR_A_POSE {
                continue;
            }
            let mut keypoints = Keypoints::default();
            for (number, &(xy, point)) in known.iter().enumerate() {
                if number % 2 == 1 {
                    halves.measured.push((id, xy, point));
                    continue;
                }
                let keypoint = u32::try_from(keypoints.len()).unwrap_or(u32::MAX);
                let element = TrackElement { image: id, keypoint };
                halves.tracks.entry(point).or_default().push(element);
                keypoints.push(Keypoint { xy, point: Some(point) });
            }
            halves.images.insert(id, Image { keypoints, ..image.clone() });
        }
        halves
    }
}
