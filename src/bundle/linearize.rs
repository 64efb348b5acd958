//! Pixels and their derivatives for runs of sightings: the only file of this room that is compiled for each camera model.
//!
//! What leaves it are plain blocks of numbers.

use multiversion::multiversion;
use nalgebra::{Matrix3, UnitQuaternion, Vector2, Vector3};

use crate::camera::{CameraModel, Intrinsics, Job};

/// No camera model has more parameters.
pub(super) const MOST_PARAMS: usize = 16;

/// A camera's parameters, in file order; zeros follow.
pub(super) type Params = [f64; MOST_PARAMS];

/// A pose, with its rotation also as a matrix. It moves to T exp(motion): the rotation is about the origin of the world, where
/// the scene's centre is put, and the translation is in world coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub turn: UnitQuaternion<f64>,
    pub rotation: Matrix3<f64>,
    pub translation: Vector3<f64>,
}

/// A keypoint that sees a point, by the number of its image in a block of points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting {
    pub xy: [f64; 2],
    pub image: u32,
    /// Its place among the keypoints of that image.
    pub keypoint: u32,
}

/// A residual, projection less measurement, with its derivatives by the point in world coordinates and by the free parameters;
/// zeros follow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub residual: [f64; 2],
    /// What the products of the first row's derivatives count: -1 where the loss bends down so much that they count negative.
    pub sign: f64,
    pub wrt_point: [[f64; 3]; 2],
    pub wrt_params: [Params; 2],
}

impl Row {
    pub(super) const ZERO: Self = Self {
        residual: [0.0; 2],
        sign: 1.0,
        wrt_point: [[0.0; 3]; 2],
        wrt_params: [[0.0; MOST_PARAMS]; 2],
    };
}

/// A camera as sightings are linearised: its functions, and which of its parameters move.
#[derive(Debug, Clone)]
pub(super) struct Lens {
    pub kernel: Kernel,
    /// The places of the parameters that move, ascending.
    pub free: Vec<usize>,
}

/// The residual of a point that is seen at a pixel.
type Residual = fn(&Params, &Placed, &Vector3<f64>, &[f64; 2]) -> Option<[f64; 2]>;

/// The functions of one camera model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kernel {
    /// Fills the rows of a run of sightings of one point; false if one cannot be projected.
    pub linearize: fn(&Lens, &Params, &Run<'_>, &mut [Row]) -> bool,
    /// The residual of one sighting.
    pub residual: Residual,
}

/// Sightings of one point by one camera.
pub(super) struct Run<'a> {
    pub point: Vector3<f64>,
    pub sightings: &'a [Sighting],
    /// By the sightings' number of the image.
    pub images: &'a [u32],
    pub poses: &'a [Placed],
}

impl Placed {
    pub(super) fn new(turn: UnitQuaternion<f64>, translation: Vector3<f64>) -> Self {
        Self { turn, rotation: turn.to_rotation_matrix().into_inner(), translation }
    }

    #[inline(always)]
    pub(super) fn see(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.translation
    }

    /// Turned and moved by a step.
    pub(super) fn moved(&self, [a, b, c, x, y, z]: [f64; 6]) -> Self {
        let turn = self.turn * UnitQuaternion::from_scaled_axis(Vector3::new(a, b, c));
        Self::new(turn, self.translation + self.rotation * Vector3::new(x, y, z))
    }
}

/// d pixel / d pose of a point: turned about the world's origin, then moved, both in world coordinates.
#[inline(always)]
pub(super) fn wrt_pose(wrt_point: &[[f64; 3]; 2], point: &Vector3<f64>) -> [[f64; 6]; 2] {
    let [x, y, z]: [f64; 3] = (*point).into();
    wrt_point.map(|[a, b, c]| [y * c - z * b, z * a - x * c, x * b - y * a, a, b, c])
}

impl Kernel {
    /// Those of this camera's model.
    pub(super) fn of(intrinsics: &Intrinsics) -> Self {
        intrinsics.visit(Compile)
    }
}

struct Compile;

impl Job for Compile {
    type Output = Kernel;

    fn run<M: CameraModel<N>, const N: usize>(self, _: &[f64; N]) -> Kernel {
        Kernel { linearize: linearize::<M, N>, residual: residual::<M, N> }
    }
}

#[multiversion(targets("x86_64+avx2+fma"))]
fn linearize<M: CameraModel<N>, const N: usize>(
    lens: &Lens,
    params: &Params,
    run: &Run<'_>,
    rows: &mut [Row],
) -> bool {
    let Some(params) = params.first_chunk::<N>() else { return false };
    for (sighting, row) in run.sightings.iter().zip(rows) {
        let pose = &run.poses[run.images[sighting.image as usize] as usize];
        let Some(seen) = M::linearize(params, &pose.see(&run.point)) else { return false };
        let wrt_point = seen.wrt_point * pose.rotation;
        row.sign = 1.0;
        for axis in 0..2 {
            row.residual[axis] = seen.pixel[axis] - sighting.xy[axis];
            row.wrt_point[axis] =
                [wrt_point[(axis, 0)], wrt_point[(axis, 1)], wrt_point[(axis, 2)]];
            row.wrt_params[axis] = [0.0; MOST_PARAMS];
            for (place, &param) in lens.free.iter().enumerate() {
                row.wrt_params[axis][place] = seen.wrt_params[(axis, param)];
            }
        }
    }
    true
}

fn residual<M: CameraModel<N>, const N: usize>(
    params: &Params,
    pose: &Placed,
    point: &Vector3<f64>,
    xy: &[f64; 2],
) -> Option<[f64; 2]> {
    let pixel = M::project(params.first_chunk::<N>()?, &pose.see(point))? - Vector2::from(*xy);
    Some(pixel.into())
}
