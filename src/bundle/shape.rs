//! Where the unknowns of poses and cameras stand in the matrix of tiles, and which tiles it has.

use super::chunk::{Chunk, NONE, pair};
use super::order::{Graph, ordered};
use super::schur::Layout;
use super::tiles::{Pattern, TILE};

/// Images that make a row of tiles.
const GROUP: usize = TILE / 6;

/// The matrix as it is stored: images in the order in which they are eliminated, then the cameras.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    /// The row of each unknown of the layout.
    pub rows: Vec<usize>,
    /// How many columns of tiles the poses have.
    pub pose_tiles: usize,
    pub pattern: Pattern,
}

impl Shape {
    /// For the chunks' pairs of images and cameras.
    pub(super) fn new(layout: &Layout, chunks: &[Chunk]) -> Self {
        let moving = layout.poses / 6;
        let mut images = Graph::new(moving);
        for chunk in chunks.iter().filter(|_| moving > 0) {
            for (second, &image) in chunk.images.iter().enumerate() {
                for (first, &earlier) in chunk.images[..second].iter().enumerate() {
                    if chunk.pose_pose[pair(first, second)] != NONE {
                        images.join(image as usize, earlier as usize);
                    }
                }
            }
        }
        let order = ordered(&images, GROUP);
        let pose_tiles = moving.div_ceil(GROUP);
        let mut rows = vec![0; layout.size];
        for (place, &image) in order.iter().enumerate() {
            (0..6).for_each(|at| rows[6 * image + at] = 6 * place + at);
        }
        (layout.poses..layout.size).for_each(|at| rows[at] = TILE * pose_tiles + at - layout.poses);
        let border = (layout.size - layout.poses).div_ceil(TILE);
        let mut tiles = images.grouped(&order, GROUP).enlarged(border);
        for chunk in chunks.iter().filter(|_| moving > 0) {
            for (index, &image) in chunk.images.iter().enumerate() {
                for (local, &camera) in chunk.cameras.iter().enumerate() {
                    if chunk.pose_camera[index * chunk.cameras.len() + local] != NONE {
                        let border = rows[layout.cameras[camera as usize]] / TILE;
                        tiles.join(rows[6 * image as usize] / TILE, border);
                    }
                }
            }
        }
        // What is left when poses are eliminated is small, and mostly full.
        for later in pose_tiles..pose_tiles + border {
            (pose_tiles..later).for_each(|earlier| tiles.join(earlier, later));
        }
        Self { rows, pose_tiles, pattern: Pattern::of(tiles) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::problem::Problem;
    use super::super::testing::{World, camera, disturbed};
    use super::super::{Options, adjust};
    use crate::scene::{ImageId, Point3D, Scene, TrackElement};

    const IMAGES: usize = 64;

    /// A closed sequence, each point seen by a few images that follow each other.
    fn sequence() -> Scene {
        let lens = camera("SIMPLE_RADIAL", &[1000.0, 640.0, 480.0, -0.05]);
        let mut scene = World::ring(vec![lens], 64, 1500).with_noise(0.5).scene();
        let points = std::mem::take(&mut scene.geometry.as_mut().unwrap().points);
        for (index, point) in points.iter().enumerate() {
            let is_near = |seen: &TrackElement| {
                (seen.image.0 as usize + IMAGES - index % IMAGES) % IMAGES < 6
            };
            let track: Vec<TrackElement> = point.track.filter(is_near).collect();
            let Point3D { id, xyz, rgb, error_px, .. } = point;
            let point = Point3D { id, xyz, rgb, error_px, track };
            scene.geometry.as_mut().unwrap().points.push(point);
        }
        disturbed(scene, 0.01, 1.03)
    }

    /// The same scene with the images in another order.
    fn shuffled(scene: &Scene) -> Scene {
        let number = |id: ImageId| ImageId(id.0 * 27 % 67);
        let mut scene = scene.clone();
        let geometry = scene.geometry.as_mut().unwrap();
        let images = std::mem::take(&mut geometry.images);
        geometry.images = images.into_iter().map(|(id, image)| (number(id), image)).collect();
        let points = std::mem::take(&mut geometry.points);
        for point in points.iter() {
            let renumbered =
                |seen: TrackElement| TrackElement { image: number(seen.image), ..seen };
            let track: Vec<TrackElement> = point.track.map(renumbered).collect();
            let Point3D { id, xyz, rgb, error_px, .. } = point;
            geometry.points.push(Point3D { id, xyz, rgb, error_px, track });
        }
        scene
    }

    #[test]
    fn a_sequence_takes_few_tiles_and_the_same_steps_under_any_numbers() {
        let options = Options::default();
        let scenes = [sequence(), shuffled(&sequence())];
        let outcomes = scenes.map(|scene| {
            let shape = Problem::new(&scene, &options).unwrap().shape;
            // Eight columns of images, each meets two others on either side of what is left of the ring, and the border.
            let tiles: Vec<usize> = (0..9).map(|at| shape.pattern.column(at).len()).collect();
            assert_eq!((shape.pose_tiles, tiles[8]), (8, 1));
            assert!(tiles.iter().all(|&count| count <= 6), "{tiles:?}");
            adjust(scene, &options, &mut |_| {}).unwrap().outcome
        });
        let [one, other] = &outcomes;
        assert!((one.sigma_px.unwrap() - 0.5).abs() < 0.02);
        assert!((one.cost / other.cost - 1.0).abs() < 1e-11);
        assert_eq!((one.iterations, one.rank), (other.iterations, other.rank));
        assert!(one.iterations < 10);
        let stds = [one, other].map(|it| it.covariance.as_ref().unwrap().stds().unwrap());
        for (one, other) in stds[0].iter().zip(&stds[1]) {
            assert!((one / other - 1.0).abs() < 1e-7);
        }
    }
}
