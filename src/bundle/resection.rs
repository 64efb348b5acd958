//! Images that took no part in an adjustment, posed by the points and the lens that it gives.

use nalgebra::Vector3;

use super::linearize::{Lens, Params, Placed, Row, Run, Sighting, wrt_pose};
use super::subsets::{Refit, Sight, Subsets};
use crate::least_squares::{self, NormalEquations, Reason, Step};
use crate::scene::ImageId;

/// An image that took no part in a refit, with what it sees of the refit's points.
#[derive(Debug, Clone)]
pub struct Bystander<'a> {
    /// In the order of its keypoints.
    pub seen: Vec<Seen>,
    lens: &'a Lens,
    params: &'a Params,
    start: Placed,
}

/// A point of a refit, as it is seen by a bystander.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    pixel: [f64; 2],
    point: Vector3<f64>,
}

impl Sight<'_> {
    /// The images that took no part in a refit, of cameras of which others did: of the rest the refit gives no lens.
    pub fn bystanders<'a>(&'a self, refit: &'a Refit) -> Vec<Bystander<'a>> {
        let Subsets { whole, tracks, .. } = self.subsets;
        let (problem, state) = (&refit.optimum.problem, &refit.optimum.state);
        let took_part = |id: &ImageId| problem.images.binary_search(id).is_ok();
        let mut seen: Vec<Option<Vec<(u32, Seen)>>> =
            whole.images.iter().map(|id| (!took_part(id)).then(Vec::new)).collect();
        for (&at, &point) in refit.kept.iter().zip(&state.points) {
            for sighting in &tracks[at] {
                if let Some(seen) = &mut seen[sighting.image as usize] {
                    let pixel = self.pixel(sighting);
                    seen.push((sighting.keypoint, Seen { pixel, point }));
                }
            }
        }
        let bystander = |(image, seen): (usize, Option<Vec<(u32, Seen)>>)| {
            let mut seen = seen?;
            let camera = whole.camera_of[image] as usize;
            refit.intrinsics.iter().find(|(id, _)| *id == whole.cameras[camera])?;
            seen.sort_unstable_by_key(|(keypoint, _)| *keypoint);
            Some(Bystander {
                seen: seen.into_iter().map(|(_, seen)| seen).collect(),
                lens: &problem.lenses[camera],
                params: &state.params[camera],
                start: self.start.poses[image],
            })
        };
        seen.into_iter().enumerate().filter_map(bystander).collect()
    }
}

impl Bystander<'_> {
    /// Poses the image by some of its sightings; the distances in px between pixel and projection of others. What the lens does
    /// not see is left out. None where no pose is found.
    pub fn distances_px(&self, by: &[Seen], of: &[Seen]) -> Option<Vec<f64>> {
        let pose = self.pose(by)?;
        let distance = |seen: &Seen| {
            let residual = self.lens.kernel.residual;
            let [x, y] = residual(self.params, &pose, &seen.point, &seen.pixel)?;
            Some(x.hypot(y))
        };
        Some(of.iter().filter_map(distance).collect())
    }

    fn pose(&self, by: &[Seen]) -> Option<Placed> {
        let residual = self.lens.kernel.residual;
        let is_seen =
            |seen: &&Seen| residual(self.params, &self.start, &seen.point, &seen.pixel).is_some();
        let by: Vec<Seen> = by.iter().filter(is_seen).copied().collect();
        if by.is_empty() {
            return None;
        }
        let mut posing = Posing { bystander: self, by, normal: NormalEquations::new(6) };
        let end = least_squares::minimize(&mut posing, self.start, &Default::default())?;
        matches!(end.reason, Reason::Converged | Reason::Rounding).then_some(end.state)
    }
}

/// The least squares by which an image is posed.
struct Posing<'a> {
    bystander: &'a Bystander<'a>,
    by: Vec<Seen>,
    normal: NormalEquations,
}

impl least_squares::Problem for Posing<'_> {
    type State = Placed;

    fn cost(&mut self, pose: &Placed) -> Option<f64> {
        let Bystander { lens, params, .. } = self.bystander;
        let mut sum = 0.0;
        for Seen { pixel, point } in &self.by {
            let [x, y] = (lens.kernel.residual)(params, pose, point, pixel)?;
            sum += x * x + y * y;
        }
        Some(0.5 * sum).filter(|cost| cost.is_finite())
    }

    fn linearize(&mut self, pose: &Placed) {
        let Bystander { lens, params, .. } = self.bystander;
        self.normal.clear();
        let mut rows = [Row::ZERO];
        for &Seen { pixel, point } in &self.by {
            let sightings = &[Sighting { xy: pixel, image: 0, keypoint: 0 }];
            let run = Run { point, sightings, images: &[0], poses: std::slice::from_ref(pose) };
            // What is linearised has a cost, so that all of it can be projected.
            if !(lens.kernel.linearize)(lens, params, &run, &mut rows) {
                continue;
            }
            let [Row { residual, wrt_point, .. }] = rows;
            for (residual, wrt_pose) in residual.into_iter().zip(wrt_pose(&wrt_point, &point)) {
                self.normal.add(residual, &wrt_pose);
            }
        }
    }

    fn solve(&mut self, damping: f64) -> Option<Step> {
        self.normal.solve(damping)
    }

    fn step(&self, pose: &Placed, moved: &mut Placed) {
        let step = self.normal.last_step();
        *moved = pose.moved(std::array::from_fn(|at| step[at]));
    }

    fn length(&self, pose: &Placed) -> f64 {
        (1.0 + pose.translation.norm_squared()).sqrt()
    }

    fn freedom(&self) -> f64 {
        2.0 * self.by.len() as f64 - 6.0
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::testing::{World, camera, disturbed};
    use super::super::{Mode, Options, Subsets, adjust};
    use super::*;
    use crate::scene::CameraId;

    #[test]
    fn a_bystander_is_posed_as_by_an_adjustment_of_its_pose_alone() {
        let lens = camera("OPENCV", &[1000.0, 1010.0, 645.0, 472.0, -0.1, 0.03, 0.001, -0.0005]);
        let world = World::ring(vec![lens], 9, 200);
        let exact = world.scene();
        let noisy = world.with_noise(0.5).scene();
        // Six images see points where they are: so lens and points are the truth, and the others' poses the noise's.
        let chosen: BTreeSet<ImageId> = [1, 2, 4, 5, 7, 8].map(ImageId).into();
        let mut pixels = exact.pixels();
        for image in [2, 5, 8] {
            pixels[image] = noisy.pixels()[image].clone();
        }
        let options = Options::default();
        let subsets = Subsets::new(&exact, &options).unwrap();
        let sight = subsets.seen(&pixels, &disturbed(exact.clone(), 0.01, 1.01).estimates());
        let sight = sight.unwrap();
        let refit = sight.adjust(&chosen).unwrap();
        let options = Options { mode: Mode::OnlyPose, ..options };
        let posed = adjust(noisy, &options, &mut |_| {}).unwrap().scene;
        let geometry = posed.geometry.as_ref().unwrap();
        let poses = geometry.poses();
        let bystanders = sight.bystanders(&refit);
        assert_eq!(bystanders.len(), 3);
        let mut count = 0;
        for (bystander, image) in bystanders.iter().zip([2, 5, 8]) {
            let found = bystander.distances_px(&bystander.seen, &bystander.seen).unwrap();
            let keypoints = &geometry.images[&ImageId(image + 1)].keypoints;
            let places = geometry.points.iter().map(|point| (point.id, point.xyz));
            let places: std::collections::BTreeMap<_, _> = places.collect();
            let pose = poses[image as usize].unwrap();
            for (keypoint, found) in keypoints.iter().zip(found) {
                let seen = pose.transform_point(&places[&keypoint.point.unwrap()].into());
                let pixel = posed.cameras[&CameraId(1)].intrinsics.project(&seen.coords).unwrap();
                let wanted = (pixel - nalgebra::Vector2::from(keypoint.xy)).norm();
                assert!((found - wanted).abs() < 1e-5, "{found} {wanted}");
                count += 1;
            }
        }
        assert!(count > 300, "{count}");
    }

    #[test]
    fn images_of_a_camera_of_which_none_took_part_are_no_bystanders() {
        let lens = camera("OPENCV", &[1000.0, 1010.0, 645.0, 472.0, -0.1, 0.03, 0.001, -0.0005]);
        let scene = World::ring(vec![lens, lens], 8, 100).scene();
        let (subsets, pixels) =
            (Subsets::new(&scene, &Options::default()).unwrap(), scene.pixels());
        let sight = subsets.seen(&pixels, &scene.estimates()).unwrap();
        // The cameras took every second image.
        for (chosen, bystanders) in [([1, 3, 5], 1), ([1, 2, 3], 5)] {
            let refit = sight.adjust(&chosen.map(ImageId).into()).unwrap();
            assert_eq!(sight.bystanders(&refit).len(), bystanders);
        }
    }

    #[test]
    fn an_image_without_a_sighting_finds_no_pose() {
        let lens = camera("OPENCV", &[1000.0, 1010.0, 645.0, 472.0, -0.1, 0.03, 0.001, -0.0005]);
        let subsets = Subsets::new(&World::ring(vec![lens], 6, 60).scene(), &Options::default());
        let scene = World::ring(vec![lens], 6, 60).scene();
        let (subsets, pixels) = (subsets.unwrap(), scene.pixels());
        let sight = subsets.seen(&pixels, &scene.estimates()).unwrap();
        let refit = sight.adjust(&[1, 2, 3].map(ImageId).into()).unwrap();
        let bystanders = sight.bystanders(&refit);
        assert_eq!(bystanders[0].distances_px(&[], &bystanders[0].seen), None);
    }
}
