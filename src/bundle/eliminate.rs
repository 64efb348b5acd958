//! One pass over a chunk's points: linearise, weigh, eliminate the point, add to the sums.
//!
//! With G = [-[X]x, 1] an image's pose moves the point X by G motion, so that its derivatives are the point's times G.
//! J_pose = J_point G: only J_point is ever formed per sighting, and every sum is one of outer products of a few vectors.

use multiversion::multiversion;
use nalgebra::Vector3;

use super::Loss;
use super::chunk::{Chunk, NONE, pair};
use super::linearize::{Lens, MOST_PARAMS, Params, Placed, Row, Sighting};
use super::pairs::Gathered;
use super::point::{InverseFactor, PointBlock};
use super::products::{Wide, add_outers, add_scaled, dot, fused, scaled, take_outers};
use super::rows::block_of;

/// What is needed of the unknowns, and how to weigh.
pub(super) struct View<'a> {
    pub lenses: &'a [Lens],
    pub params: &'a [Params],
    pub poses: &'a [Placed],
    pub points: &'a [Vector3<f64>],
    /// A camera's share of the border.
    pub width: usize,
    pub loss: Loss,
    /// Whether the loss bends as it does, or its curvature is made positive.
    pub bends: bool,
    pub moves_poses: bool,
    pub moves_points: bool,
}

/// The sums of one chunk, and room to work in; another chunk may have it next.
#[derive(Debug, Clone, Default)]
pub(super) struct Sums {
    /// J^T J after points are eliminated, as the chunk lays it out: the blocks between images, row by row. In an image's block
    /// with itself the last two columns are its gradient after points are eliminated, and before.
    pub pose_blocks: Vec<[Wide; 6]>,
    /// The blocks with cameras.
    pub blocks: Vec<f64>,
    /// By image: diagonal of J^T J before points are eliminated.
    pub pose_diagonals: Vec<Wide>,
    /// By camera: gradient after points are eliminated, diagonal of J^T J before, gradient before.
    pub cameras: Vec<[Params; 3]>,
    /// The fall of the cost that points alone predict, doubled: sum of g^T V^-1 g.
    pub by_points: f64,
    /// The largest component of a point's gradient.
    pub point_gradient: f64,
    /// Directions in which points are not determined; counted without damping only.
    pub nullity: usize,
    scratch: Scratch,
}

#[derive(Debug, Clone, Default)]
struct Scratch {
    rows: Vec<Row>,
    gathered: Gathered,
    /// For each camera of the point.
    borders: Vec<Border>,
}

/// What a point carries of a camera.
#[derive(Debug, Clone)]
struct Border {
    camera: usize,
    /// L^-1 J_point^T J_params
    rows: [Params; 3],
    /// V^-1 J_point^T J_params
    solved: [Params; 3],
}

/// A point's block, factored.
struct Eliminated {
    inverse: InverseFactor,
    /// L^-1 g
    reduced: [f64; 3],
    /// V^-1 g
    solved: [f64; 3],
}

impl Sums {
    /// Makes room for a chunk, and forgets what was summed.
    fn clear(&mut self, chunk: &Chunk) {
        refill(&mut self.pose_blocks, chunk.pose_pose_count, [[0.0; 8]; 6]);
        refill(&mut self.blocks, chunk.border_length, 0.0);
        refill(&mut self.pose_diagonals, chunk.images.len(), [0.0; 8]);
        refill(&mut self.cameras, chunk.cameras.len(), [[0.0; MOST_PARAMS]; 3]);
        (self.by_points, self.point_gradient, self.nullity) = (0.0, 0.0, 0);
        let zeros = [[0.0; MOST_PARAMS]; 3];
        let border = Border { camera: 0, rows: zeros, solved: zeros };
        let Scratch { rows, borders, .. } = &mut self.scratch;
        rows.resize(chunk.longest.max(rows.len()), Row::ZERO);
        borders.resize(chunk.cameras.len().max(borders.len()), border);
    }
}

fn refill<T: Copy>(values: &mut Vec<T>, count: usize, value: T) {
    values.clear();
    values.resize(count, value);
}

/// The pass.
pub(super) fn eliminate(chunk: &Chunk, view: &View<'_>, damping: f64, sums: &mut Sums) {
    sums.clear(chunk);
    match view.width {
        0 => of_width::<0>(chunk, view, damping, sums),
        1..=4 => of_width::<4>(chunk, view, damping, sums),
        5..=8 => of_width::<8>(chunk, view, damping, sums),
        _ => of_width::<MOST_PARAMS>(chunk, view, damping, sums),
    }
}

#[multiversion(targets("x86_64+avx2+fma"))]
fn of_width<const W: usize>(chunk: &Chunk, view: &View<'_>, damping: f64, sums: &mut Sums) {
    if multiversion::target::target_cfg_f!(target_feature = "fma") {
        add_points::<W, true>(chunk, view, damping, sums);
    } else {
        add_points::<W, false>(chunk, view, damping, sums);
    }
}

#[inline(always)]
fn add_points<const W: usize, const FUSED: bool>(
    chunk: &Chunk,
    view: &View<'_>,
    damping: f64,
    sums: &mut Sums,
) {
    let mut start = 0;
    for (&end, point) in chunk.ends.iter().zip(&view.points[chunk.points.clone()]) {
        let track = &chunk.sightings[start..end as usize];
        start = end as usize;
        if sums.scratch.gathered.is_full_for(track.len(), chunk) {
            sums.scratch.gathered.take_from::<FUSED>(&mut sums.pose_blocks, chunk);
        }
        let block = block_of::<W, FUSED>(chunk, view, (point, track), &mut sums.scratch.rows);
        let own = eliminate_point::<FUSED>(view, damping, sums, &block);
        let cameras = add_cameras::<W, FUSED>(chunk, view, sums, &own, track);
        if view.moves_poses {
            add_poses::<FUSED>(chunk, view, sums, &own, (point, track));
            add_borders::<W, FUSED>(chunk, sums, cameras, (point, track));
        }
    }
    sums.scratch.gathered.take_from::<FUSED>(&mut sums.pose_blocks, chunk);
    for [gradient, _, own_gradient] in &mut sums.cameras {
        gradient.iter_mut().zip(own_gradient).for_each(|(sum, own)| *sum += *own);
    }
}

#[inline(always)]
fn eliminate_point<const FUSED: bool>(
    view: &View<'_>,
    damping: f64,
    sums: &mut Sums,
    block: &PointBlock,
) -> Eliminated {
    let inverse = if view.moves_points { block.factor(damping) } else { InverseFactor::ZERO };
    let reduced = inverse.times(&block.gradient);
    if view.moves_points {
        sums.by_points += dot::<3, FUSED>(&reduced, &reduced);
        sums.nullity += inverse.nullity;
        let largest = block.gradient.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        sums.point_gradient = sums.point_gradient.max(largest);
    }
    Eliminated { solved: inverse.transpose_times(&reduced), inverse, reduced }
}

/// The cameras' own blocks, and what the point carries of them; tells how many cameras see the point.
#[inline(always)]
fn add_cameras<const W: usize, const FUSED: bool>(
    chunk: &Chunk,
    view: &View<'_>,
    sums: &mut Sums,
    point: &Eliminated,
    track: &[Sighting],
) -> usize {
    if W == 0 {
        return 0;
    }
    let Sums { blocks, cameras, scratch, .. } = sums;
    let Scratch { rows, borders, .. } = scratch;
    let mut count = 0;
    for (sighting, row) in track.iter().zip(&*rows) {
        let camera = chunk.camera_of[sighting.image as usize] as usize;
        let known = borders[..count].iter().position(|border| border.camera == camera);
        let border = &mut borders[known.unwrap_or(count)];
        if known.is_none() {
            (border.camera, border.rows) = (camera, [[0.0; MOST_PARAMS]; 3]);
            count += 1;
        }
        let [x, y] = &row.wrt_params;
        let (x, y) = (leading::<W>(x), leading::<W>(y));
        for (sum, left) in border.rows.iter_mut().zip(0..3) {
            let Some(sum) = sum.first_chunk_mut::<W>() else { continue };
            add_scaled::<W, FUSED>(sum, row.sign * row.wrt_point[0][left], &x);
            add_scaled::<W, FUSED>(sum, row.wrt_point[1][left], &y);
        }
        let [_, diagonal, gradient] = &mut cameras[camera];
        for lane in 0..W {
            let [x, y] = [x[lane], y[lane]];
            diagonal[lane] = fused::<FUSED>(x, x, fused::<FUSED>(y, y, diagonal[lane]));
            let [by_x, by_y] = row.residual;
            gradient[lane] = fused::<FUSED>(by_x, x, fused::<FUSED>(by_y, y, gradient[lane]));
        }
        let start = chunk.camera_camera[pair(camera, camera)] as usize;
        let (square, _) = blocks[start..start + W * W].as_chunks_mut::<W>();
        add_outers::<W, W, FUSED>(square, [&scaled(row.sign, &x), &y], [&x, &y]);
    }
    if !view.moves_points {
        borders[..count].iter_mut().for_each(|border| border.solved = [[0.0; MOST_PARAMS]; 3]);
        return count;
    }
    for at in 0..count {
        let (earlier, rest) = borders.split_at_mut(at);
        let border = &mut rest[0];
        let gradient = &mut cameras[border.camera][0];
        for lane in 0..W {
            let [a, b, c] = &border.rows;
            let reduced = point.inverse.times(&[a[lane], b[lane], c[lane]]);
            let solved = point.inverse.transpose_times(&reduced);
            gradient[lane] -= dot::<3, FUSED>(&reduced, &point.reduced);
            for axis in 0..3 {
                border.rows[axis][lane] = reduced[axis];
                border.solved[axis][lane] = solved[axis];
            }
        }
        for other in earlier.iter().chain([&*border]) {
            take_camera_pair::<W, FUSED>(chunk, blocks, [other, border]);
        }
    }
    count
}

/// Takes what the point carries between two cameras from their sum, whose rows are those of the later camera.
#[inline(always)]
fn take_camera_pair<const W: usize, const FUSED: bool>(
    chunk: &Chunk,
    blocks: &mut [f64],
    borders: [&Border; 2],
) {
    let [first, second] =
        if borders[0].camera <= borders[1].camera { borders } else { [borders[1], borders[0]] };
    let start = chunk.camera_camera[pair(first.camera, second.camera)] as usize;
    let (block, _) = blocks[start..start + W * W].as_chunks_mut::<W>();
    let [a, b, c] = &second.rows;
    let rows = [leading(a), leading(b), leading(c)];
    let [a, b, c] = &first.rows;
    let columns = [leading(a), leading(b), leading(c)];
    take_outers::<W, W, FUSED>(block, &rows, &columns);
}

type Point<'a> = (&'a Vector3<f64>, &'a [Sighting]);

/// G^T v = (X x v, v)
#[inline(always)]
pub(super) fn lift(point: &Vector3<f64>, [a, b, c]: &[f64; 3]) -> Wide {
    let [x, y, z]: [f64; 3] = (*point).into();
    [y * c - z * b, z * a - x * c, x * b - y * a, *a, *b, *c, 0.0, 0.0]
}

/// The blocks between poses, rows those of the earlier image; the poses' gradients and diagonals.
#[inline(always)]
fn add_poses<const FUSED: bool>(
    chunk: &Chunk,
    view: &View<'_>,
    sums: &mut Sums,
    eliminated: &Eliminated,
    (point, track): Point<'_>,
) {
    let Sums { pose_blocks: blocks, pose_diagonals, scratch, .. } = sums;
    let Scratch { rows, gathered, .. } = scratch;
    for (at, sighting) in track.iter().enumerate() {
        let image = sighting.image as usize;
        let Row { residual, sign, wrt_point: [along_x, along_y], .. } = &rows[at];
        let (x, y) = (lift(point, along_x), lift(point, along_y));
        for (lane, sum) in pose_diagonals[image].iter_mut().enumerate() {
            *sum = fused::<FUSED>(x[lane], x[lane], fused::<FUSED>(y[lane], y[lane], *sum));
        }
        // With S the signs: (S - S J_point V^-1 J_point^T S) J_pose, and r - S J_point V^-1 g.
        let (s, t) = (eliminated.inverse.times(along_x), eliminated.inverse.times(along_y));
        let mut kept_x = scaled(sign - dot::<3, FUSED>(&s, &s), &x);
        let mut kept_y = scaled(1.0 - dot::<3, FUSED>(&t, &t), &y);
        let st = sign * dot::<3, FUSED>(&s, &t);
        add_scaled::<8, FUSED>(&mut kept_x, -st, &y);
        add_scaled::<8, FUSED>(&mut kept_y, -st, &x);
        let carried = dot::<3, FUSED>(along_x, &eliminated.solved);
        [kept_x[6], kept_x[7]] = [residual[0] - sign * carried, residual[0]];
        let carried = dot::<3, FUSED>(along_y, &eliminated.solved);
        [kept_y[6], kept_y[7]] = [residual[1] - carried, residual[1]];
        let own = chunk.pose_pose[pair(image, image)] as usize;
        add_outers::<8, 8, FUSED>(&mut blocks[own], [&x, &y], [&kept_x, &kept_y]);
        if !view.moves_points {
            continue;
        }
        let mut columns = [[0.0; 8]; 3];
        for (axis, column) in columns.iter_mut().enumerate() {
            *column = scaled(sign * s[axis], &x);
            add_scaled::<8, FUSED>(column, t[axis], &y);
        }
        gathered.push(sighting.image, at, &columns);
    }
}

/// The blocks between poses and cameras: six rows each.
#[inline(always)]
fn add_borders<const W: usize, const FUSED: bool>(
    chunk: &Chunk,
    sums: &mut Sums,
    count: usize,
    (point, track): Point<'_>,
) {
    let Sums { blocks, scratch, .. } = sums;
    for (sighting, row) in track.iter().zip(&scratch.rows) {
        let image = sighting.image as usize;
        let [along_x, along_y] = &row.wrt_point;
        let (x, y) = (lift(point, along_x), lift(point, along_y));
        for border in &scratch.borders[..count] {
            let start = chunk.pose_camera[image * chunk.cameras.len() + border.camera];
            if start == NONE {
                continue;
            }
            // S (J_params - J_point V^-1 J_point^T S J_params)
            let (mut kept_x, mut kept_y) = ([0.0; W], [0.0; W]);
            if border.camera == chunk.camera_of[image] as usize {
                let [x, y] = &row.wrt_params;
                (kept_x, kept_y) = (leading(x), leading(y));
            }
            for (axis, solved) in border.solved.iter().enumerate() {
                let solved = leading(solved);
                add_scaled::<W, FUSED>(&mut kept_x, -along_x[axis], &solved);
                add_scaled::<W, FUSED>(&mut kept_y, -along_y[axis], &solved);
            }
            kept_x = scaled(row.sign, &kept_x);
            let (block, _) = blocks[start as usize..][..6 * W].as_chunks_mut::<W>();
            add_outers::<W, 8, FUSED>(block, [&x, &y], [&kept_x, &kept_y]);
        }
    }
}

/// The parameters that count.
#[inline(always)]
fn leading<const W: usize>(params: &Params) -> [f64; W] {
    let mut leading = [0.0; W];
    leading.copy_from_slice(&params[..W]);
    leading
}

#[cfg(test)]
mod tests;
