//! One pass over a chunk's points: linearise, weigh, eliminate the point, add to the sums.
//!
//! With G = [-[X]x, 1] an image's pose moves the point X by G motion, so that its derivatives are the point's times G.
//! J_pose = J_point G: only J_point is ever formed per sighting, and every sum is one of outer products of a few vectors.

use nalgebra::Vector3;

use super::Loss;
use super::chunk::{Chunk, NONE, pair};
use super::linearize::{Lens, MOST_PARAMS, Params, Placed, Row, Run, Sighting};

/// What is needed of the unknowns, and how to weigh.
pub(super) struct View<'a> {
    pub lenses: &'a [Lens],
    pub params: &'a [Params],
    pub poses: &'a [Placed],
    pub points: &'a [Vector3<f64>],
    /// Each camera's share of the border.
    pub widths: &'a [usize],
    pub loss: Loss,
    pub moves_poses: bool,
    pub moves_points: bool,
}

/// The sums of one chunk, and room to work in.
#[derive(Debug, Clone)]
pub(super) struct Sums {
    /// J^T J after points are eliminated, as the chunk lays it out: the blocks between images, row by row.
    pub pose_blocks: Vec<[f64; 36]>,
    /// The blocks with cameras.
    pub blocks: Vec<f64>,
    /// Where the points go.
    pub point_steps: Vec<Vector3<f64>>,
    /// By image: gradient after points are eliminated, diagonal of J^T J before, gradient before.
    pub poses: Vec<[[f64; 6]; 3]>,
    /// By camera, the same.
    pub cameras: Vec<[Params; 3]>,
    /// The fall of the cost that points alone predict, doubled: sum of g^T V^-1 g.
    pub by_points: f64,
    /// The largest component of a point's gradient.
    pub point_gradient: f64,
    /// Directions in which points are not determined; counted without damping only.
    pub nullity: usize,
    scratch: Scratch,
}

#[derive(Debug, Clone)]
struct Scratch {
    rows: Vec<Row>,
    /// For each sighting: J_pose, and the columns of Z = G^T A L^-T.
    factors: Vec<[[f64; 6]; 5]>,
    /// For each camera of the point: L^-1 J_point^T J_params.
    borders: Vec<Border>,
}

#[derive(Debug, Clone)]
struct Border {
    camera: usize,
    rows: [Params; 3],
}

impl Sums {
    pub(super) fn new(chunk: &Chunk) -> Self {
        let border = Border { camera: 0, rows: [[0.0; MOST_PARAMS]; 3] };
        let scratch = Scratch {
            rows: vec![Row::ZERO; chunk.longest],
            factors: vec![[[0.0; 6]; 5]; chunk.longest],
            borders: vec![border; chunk.longest.min(chunk.cameras.len())],
        };
        Self {
            pose_blocks: vec![[0.0; 36]; chunk.pose_pose_count],
            blocks: vec![0.0; chunk.border_length],
            point_steps: vec![Vector3::zeros(); chunk.ends.len()],
            poses: vec![[[0.0; 6]; 3]; chunk.images.len()],
            cameras: vec![[[0.0; MOST_PARAMS]; 3]; chunk.cameras.len()],
            by_points: 0.0,
            point_gradient: 0.0,
            nullity: 0,
            scratch,
        }
    }

    /// Room for the rows of a track, and where the points' steps go.
    pub(super) fn rows_and_point_steps(&mut self) -> (&mut [Row], &mut [Vector3<f64>]) {
        (&mut self.scratch.rows, &mut self.point_steps)
    }

    fn clear(&mut self) {
        self.pose_blocks.fill([0.0; 36]);
        self.blocks.fill(0.0);
        self.poses.fill([[0.0; 6]; 3]);
        self.cameras.fill([[0.0; MOST_PARAMS]; 3]);
        (self.by_points, self.point_gradient, self.nullity) = (0.0, 0.0, 0);
    }
}

/// The point's own block of J^T J, with its factor.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointBlock {
    /// J_point^T J_point: xx, yx, yy, zx, zy, zz.
    pub square: [f64; 6],
    pub gradient: [f64; 3],
}

/// L^-1 of V = L L^T, lower triangle; a direction that is not determined has a row of zeros.
#[derive(Debug, Clone, Copy)]
pub(super) struct InverseFactor {
    rows: [[f64; 3]; 3],
    pub nullity: usize,
}

impl PointBlock {
    /// Sums over weighed rows.
    #[inline(always)]
    pub(super) fn of(rows: &[Row]) -> Self {
        let (mut square, mut gradient) = ([0.0; 6], [0.0; 3]);
        for row in rows {
            for axis in 0..2 {
                let [x, y, z] = row.wrt_point[axis];
                let products = [x * x, y * x, y * y, z * x, z * y, z * z];
                for (sum, product) in square.iter_mut().zip(products) {
                    *sum += product;
                }
                for (sum, value) in gradient.iter_mut().zip([x, y, z]) {
                    *sum += value * row.residual[axis];
                }
            }
        }
        Self { square, gradient }
    }

    /// The inverse of the factor of V + damping diag(V).
    #[inline(always)]
    pub(super) fn factor(&self, damping: f64) -> InverseFactor {
        /// The square of the smallest parallax, in radians, that rounding leaves visible.
        const NULL: f64 = 1e-14;
        let [xx, yx, yy, zx, zy, zz] = self.square;
        let more = 1.0 + damping;
        let mut nullity = 0;
        let mut inverse_root = |pivot: f64, diagonal: f64| {
            if pivot > NULL * diagonal {
                1.0 / pivot.sqrt()
            } else {
                nullity += 1;
                0.0
            }
        };
        let a = inverse_root(xx * more, xx);
        let (l10, l20) = (yx * a, zx * a);
        let b = inverse_root(yy * more - l10 * l10, yy);
        let l21 = (zy - l20 * l10) * b;
        let c = inverse_root(zz * more - l20 * l20 - l21 * l21, zz);
        let ba = -l10 * a * b;
        let ca = -(l20 * a + l21 * ba) * c;
        let cb = -l21 * b * c;
        InverseFactor { rows: [[a, 0.0, 0.0], [ba, b, 0.0], [ca, cb, c]], nullity }
    }
}

impl InverseFactor {
    const ZERO: Self = Self { rows: [[0.0; 3]; 3], nullity: 0 };

    /// L^-1 v
    #[inline(always)]
    pub(super) fn times(&self, v: &[f64; 3]) -> [f64; 3] {
        let [[a, ..], [ba, b, _], [ca, cb, c]] = self.rows;
        [a * v[0], ba * v[0] + b * v[1], ca * v[0] + cb * v[1] + c * v[2]]
    }

    /// L^-T v
    #[inline(always)]
    pub(super) fn transpose_times(&self, v: &[f64; 3]) -> [f64; 3] {
        let [[a, ..], [ba, b, _], [ca, cb, c]] = self.rows;
        [a * v[0] + ba * v[1] + ca * v[2], b * v[1] + cb * v[2], c * v[2]]
    }
}

/// Fills the rows of a point's track, weighed by the loss; false if a sighting cannot be projected.
pub(super) fn weighed_rows(
    chunk: &Chunk,
    view: &View<'_>,
    point: &Vector3<f64>,
    track: &[Sighting],
    rows: &mut [Row],
) -> bool {
    let mut start = 0;
    while start < track.len() {
        let camera = chunk.camera_of[track[start].image as usize];
        let is_other = |seen: &Sighting| chunk.camera_of[seen.image as usize] != camera;
        let end = track[start..].iter().position(is_other).map_or(track.len(), |at| start + at);
        let camera = chunk.cameras[camera as usize] as usize;
        let sightings = &track[start..end];
        let run = Run { point: *point, sightings, images: &chunk.images, poses: view.poses };
        let lens = &view.lenses[camera];
        if !(lens.kernel.linearize)(lens, &view.params[camera], &run, &mut rows[start..end]) {
            return false;
        }
        start = end;
    }
    if view.loss != Loss::Squared {
        rows[..track.len()].iter_mut().for_each(|row| weigh(row, view.loss));
    }
    true
}

/// Triggs' correction: J^T r becomes the gradient of 1/2 rho, J^T J its curvature where that is positive enough.
fn weigh(row: &mut Row, loss: Loss) {
    let [x, y] = row.residual;
    let square = x * x + y * y;
    let rho = loss.at(square);
    let along = curvature_along(loss, 1.0 + 2.0 * square * rho.curvature / rho.slope);
    let (root, share) = (rho.slope.sqrt(), along.sqrt());
    // J - (1 - share) r r^T J / |r|^2
    let bend = if square > 0.0 { (1.0 - share) / square } else { 0.0 };
    let correct = |[first, second]: [f64; 2]| {
        let shift = bend * (x * first + y * second);
        [root * (first - shift * x), root * (second - shift * y)]
    };
    for axis in 0..3 {
        let column = correct([row.wrt_point[0][axis], row.wrt_point[1][axis]]);
        [row.wrt_point[0][axis], row.wrt_point[1][axis]] = column;
    }
    for param in 0..MOST_PARAMS {
        let column = correct([row.wrt_params[0][param], row.wrt_params[1][param]]);
        [row.wrt_params[0][param], row.wrt_params[1][param]] = column;
    }
    row.residual = [x, y].map(|value| value * root / share);
}

/// The share of the first-order weight that is kept along the residual: what the loss's own curvature is of it, kept positive.
#[inline]
fn curvature_along(loss: Loss, share: f64) -> f64 {
    /// Where a convex loss is straight the system must not become singular; ten times as much, and hundreds of steps are needed.
    const STRAIGHT: f64 = 1e-3;
    /// A loss that bends down drives steps too far where little is left of the weight; of the values tried this needs the fewest.
    const BENT: f64 = 0.3;
    match loss {
        Loss::Squared | Loss::Huber(_) | Loss::SoftL1(_) => share.max(STRAIGHT),
        Loss::Cauchy(_) => share.abs().max(BENT),
    }
}

/// The pass.
pub(super) fn eliminate(chunk: &Chunk, view: &View<'_>, damping: f64, sums: &mut Sums) {
    sums.clear();
    let mut start = 0;
    for (&end, point) in chunk.ends.iter().zip(&view.points[chunk.points.clone()]) {
        let track = &chunk.sightings[start..end as usize];
        start = end as usize;
        let is_seen = weighed_rows(chunk, view, point, track, &mut sums.scratch.rows);
        debug_assert!(is_seen, "a state without a cost is linearised");
        add_point(chunk, view, damping, sums, (point, track));
    }
}

type Point<'a> = (&'a Vector3<f64>, &'a [Sighting]);

#[inline(always)]
fn add_point(
    chunk: &Chunk,
    view: &View<'_>,
    damping: f64,
    sums: &mut Sums,
    (point, track): Point<'_>,
) {
    let block = PointBlock::of(&sums.scratch.rows[..track.len()]);
    let inverse = if view.moves_points { block.factor(damping) } else { InverseFactor::ZERO };
    let reduced = inverse.times(&block.gradient);
    sums.by_points += reduced.iter().map(|value| value * value).sum::<f64>();
    sums.nullity += inverse.nullity;
    if view.moves_points {
        let largest = block.gradient.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        sums.point_gradient = sums.point_gradient.max(largest);
    }
    let cameras = add_cameras(chunk, view, sums, (&inverse, &reduced), track);
    if view.moves_poses {
        add_poses(sums, (&inverse, &reduced), (point, track));
        add_pairs(chunk, sums, view.moves_points, track);
        add_borders(chunk, view, sums, cameras, track);
    }
}

type Factor<'a> = (&'a InverseFactor, &'a [f64; 3]);

/// The cameras' own blocks; tells how many cameras see the point.
#[inline(always)]
fn add_cameras(
    chunk: &Chunk,
    view: &View<'_>,
    sums: &mut Sums,
    (inverse, reduced): Factor<'_>,
    track: &[Sighting],
) -> usize {
    let Sums { blocks, cameras, scratch, .. } = sums;
    let mut count = 0;
    for (sighting, row) in track.iter().zip(&scratch.rows) {
        let camera = chunk.camera_of[sighting.image as usize] as usize;
        let width = view.widths[chunk.cameras[camera] as usize];
        if width == 0 {
            continue;
        }
        let known = scratch.borders[..count].iter().position(|border| border.camera == camera);
        let at = known.unwrap_or(count);
        let border = &mut scratch.borders[at];
        if known.is_none() {
            *border = Border { camera, rows: [[0.0; MOST_PARAMS]; 3] };
            count += 1;
        }
        for axis in 0..2 {
            let wrt_params = &row.wrt_params[axis];
            for (sum, left) in border.rows.iter_mut().zip(row.wrt_point[axis]) {
                add_scaled(&mut sum[..width], left, &wrt_params[..width]);
            }
            let [gradient, diagonal, own_gradient] = &mut cameras[camera];
            add_scaled(&mut gradient[..width], row.residual[axis], &wrt_params[..width]);
            add_scaled(&mut own_gradient[..width], row.residual[axis], &wrt_params[..width]);
            for (sum, value) in diagonal[..width].iter_mut().zip(wrt_params) {
                *sum += value * value;
            }
            let block = chunk.camera_camera[pair(camera, camera)] as usize;
            outer(&mut blocks[block..block + width * width], width, wrt_params, wrt_params);
        }
    }
    for at in 0..count {
        let camera = scratch.borders[at].camera;
        let width = view.widths[chunk.cameras[camera] as usize];
        let rows = &mut scratch.borders[at].rows;
        let [first, second, third] = rows;
        for ((a, b), c) in first.iter_mut().zip(second).zip(third).take(width) {
            [*a, *b, *c] = inverse.times(&[*a, *b, *c]);
        }
        for axis in 0..3 {
            add_scaled(&mut cameras[camera][0][..width], -reduced[axis], &rows[axis][..width]);
        }
        if !view.moves_points {
            continue;
        }
        for other in 0..=at {
            add_camera_pair(chunk, view, blocks, [&scratch.borders[other], &scratch.borders[at]]);
        }
    }
    count
}

/// Takes what the point carries between two cameras from their sum, whose rows are those of the later camera.
#[inline(always)]
fn add_camera_pair(chunk: &Chunk, view: &View<'_>, blocks: &mut [f64], borders: [&Border; 2]) {
    let [first, second] =
        if borders[0].camera <= borders[1].camera { borders } else { [borders[1], borders[0]] };
    let [columns, rows] =
        [first, second].map(|border| view.widths[chunk.cameras[border.camera] as usize]);
    let start = chunk.camera_camera[pair(first.camera, second.camera)] as usize;
    let block = &mut blocks[start..start + rows * columns];
    for axis in 0..3 {
        for (sum, left) in block.chunks_exact_mut(columns).zip(second.rows[axis]) {
            add_scaled(sum, -left, &first.rows[axis][..columns]);
        }
    }
}

/// The poses' gradients and diagonals, and the factors for their blocks.
#[inline(always)]
fn add_poses(sums: &mut Sums, (inverse, reduced): Factor<'_>, (point, track): Point<'_>) {
    let [x, y, z]: [f64; 3] = (*point).into();
    // G^T v = (X x v, v)
    let lift = |[a, b, c]: [f64; 3]| [y * c - z * b, z * a - x * c, x * b - y * a, a, b, c];
    let Scratch { rows, factors, .. } = &mut sums.scratch;
    for ((sighting, row), factor) in track.iter().zip(rows.iter()).zip(factors.iter_mut()) {
        let [p, q] = row.wrt_point;
        // The columns of A L^-T = J^T (L^-1 J^T)^T.
        let [s, t] = [inverse.times(&p), inverse.times(&q)];
        factor[0] = lift(p);
        factor[1] = lift(q);
        for axis in 0..3 {
            factor[2 + axis] = lift([0, 1, 2].map(|at| p[at] * s[axis] + q[at] * t[axis]));
        }
        let [gradient, diagonal, own_gradient] = &mut sums.poses[sighting.image as usize];
        for at in 0..6 {
            let own = factor[0][at] * row.residual[0] + factor[1][at] * row.residual[1];
            let carried = factor[2][at] * reduced[0]
                + factor[3][at] * reduced[1]
                + factor[4][at] * reduced[2];
            gradient[at] += own - carried;
            own_gradient[at] += own;
            diagonal[at] += factor[0][at] * factor[0][at] + factor[1][at] * factor[1][at];
        }
    }
}

/// The blocks between poses: rows are those of the later image.
#[inline(always)]
fn add_pairs(chunk: &Chunk, sums: &mut Sums, moves_points: bool, track: &[Sighting]) {
    let Sums { pose_blocks: blocks, scratch, .. } = sums;
    for (at, sighting) in track.iter().enumerate() {
        let image = sighting.image as usize;
        let [p, q, z @ ..] = &scratch.factors[at];
        let own = &mut blocks[chunk.pose_pose[pair(image, image)] as usize];
        for row in 0..6 {
            for column in 0..6 {
                own[row * 6 + column] += p[row] * p[column] + q[row] * q[column]
                    - z[0][row] * z[0][column]
                    - z[1][row] * z[1][column]
                    - z[2][row] * z[2][column];
            }
        }
        if !moves_points {
            continue;
        }
        for (other, earlier) in track[..at].iter().enumerate() {
            let [_, _, other @ ..] = &scratch.factors[other];
            let first = earlier.image as usize;
            let block = &mut blocks[chunk.pose_pose[pair(first, image)] as usize];
            subtract_product(block, z, other);
            if first == image {
                // Both halves of a symmetric block: the image has two keypoints of this point.
                subtract_product(block, other, z);
            }
        }
    }
}

/// block -= left right^T
#[inline(always)]
fn subtract_product(block: &mut [f64; 36], left: &[[f64; 6]; 3], right: &[[f64; 6]; 3]) {
    for row in 0..6 {
        let [a, b, c] = [left[0][row], left[1][row], left[2][row]];
        for column in 0..6 {
            block[row * 6 + column] -=
                a * right[0][column] + b * right[1][column] + c * right[2][column];
        }
    }
}

/// The blocks between poses and cameras: six rows each.
#[inline(always)]
fn add_borders(chunk: &Chunk, view: &View<'_>, sums: &mut Sums, count: usize, track: &[Sighting]) {
    let Sums { blocks, scratch, .. } = sums;
    for (at, sighting) in track.iter().enumerate() {
        let image = sighting.image as usize;
        let factors = &scratch.factors[at];
        let own = chunk.camera_of[image] as usize;
        for border in &scratch.borders[..count] {
            let start = chunk.pose_camera[image * chunk.cameras.len() + border.camera];
            let width = view.widths[chunk.cameras[border.camera] as usize];
            if start == NONE {
                continue;
            }
            let block = &mut blocks[start as usize..start as usize + 6 * width];
            let [wrt_x, wrt_y] = &scratch.rows[at].wrt_params;
            let is_own = border.camera == own;
            for (row, sums) in block.chunks_exact_mut(width).enumerate() {
                if is_own {
                    add_scaled(sums, factors[0][row], &wrt_x[..width]);
                    add_scaled(sums, factors[1][row], &wrt_y[..width]);
                }
                for axis in 0..3 {
                    add_scaled(sums, -factors[2 + axis][row], &border.rows[axis][..width]);
                }
            }
        }
    }
}

/// block += left right^T
#[inline(always)]
fn outer(block: &mut [f64], width: usize, left: &Params, right: &Params) {
    for (sums, left) in block.chunks_exact_mut(width).zip(left) {
        add_scaled(sums, *left, &right[..width]);
    }
}

/// sum += scale values; widths are multiples of four.
#[inline(always)]
fn add_scaled(sum: &mut [f64], scale: f64, values: &[f64]) {
    let (sum, _) = sum.as_chunks_mut::<4>();
    let (values, _) = values.as_chunks::<4>();
    for (sum, values) in sum.iter_mut().zip(values) {
        for lane in 0..4 {
            sum[lane] += scale * values[lane];
        }
    }
}
