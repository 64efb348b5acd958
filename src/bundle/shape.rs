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
