//! How a pixel moves with the camera's pose and with the point in the world: the chain rule, once for all models.

use nalgebra::{Matrix2x3, Matrix3, SMatrix, Vector3};

use super::Linearized;

impl<const N: usize> Linearized<N> {
    /// d pixel / d world point (2x3), R the rotation of cam_from_world.
    #[inline(always)]
    pub fn wrt_world_point(&self, rotation: &Matrix3<f64>) -> Matrix2x3<f64> {
        self.wrt_point * rotation
    }

    /// d pixel / d pose (2x6): the pose is moved on its right, cam_from_world * Exp(rho, phi), translation first.
    ///
    /// The point X in the world is then seen at R (Exp(phi) X + V(phi) rho) + t, V(0) = 1, so that at rho = phi = 0
    ///
    /// `d (point in camera) / d (rho, phi) = R [1, -[X]x]`
    ///
    /// phi turns about the world's origin, in radians; rho is in the world's unit and along its axes. J. Sola, J. Deray,
    /// D. Atchuthan, A micro Lie theory for state estimation in robotics, 2018.
    #[inline(always)]
    pub fn wrt_pose(
        &self,
        rotation: &Matrix3<f64>,
        world_point: &Vector3<f64>,
    ) -> SMatrix<f64, 2, 6> {
        let wrt_rho = self.wrt_world_point(rotation);
        let [x, y, z]: [f64; 3] = (*world_point).into();
        let mut wrt_pose = SMatrix::<f64, 2, 6>::zeros();
        for row in 0..2 {
            let [a, b, c] = [wrt_rho[(row, 0)], wrt_rho[(row, 1)], wrt_rho[(row, 2)]];
            // -a^T [X]x = (X x a)^T
            let wrt_phi = [y * c - z * b, z * a - x * c, x * b - y * a];
            for (column, value) in [a, b, c].into_iter().chain(wrt_phi).enumerate() {
                wrt_pose[(row, column)] = value;
            }
        }
        wrt_pose
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Translation3, UnitQuaternion};

    use super::super::laws::least_error;
    use super::super::testing::{hold, points};
    use super::super::{CameraModel, Job};
    use super::*;

    struct Pose;
    impl Job for Pose {
        type Output = usize;
        fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
            let cam_from_world = Isometry3::from_parts(
                Translation3::new(0.3, -0.7, 1.1),
                UnitQuaternion::from_scaled_axis(Vector3::new(0.9, -0.4, 1.7)),
            );
            let rotation = cam_from_world.rotation.to_rotation_matrix();
            points()
                .filter(|point| holds::<M, N>(params, &cam_from_world, &rotation, point))
                .count()
        }
    }

    fn holds<M: CameraModel<N>, const N: usize>(
        params: &[f64; N],
        cam_from_world: &Isometry3<f64>,
        rotation: &nalgebra::Rotation3<f64>,
        point: &Vector3<f64>,
    ) -> bool {
        let world_point = cam_from_world.inverse_transform_point(&(*point).into());
        let Some(at) = M::linearize(params, point) else { return false };
        let wrt_pose = at.wrt_pose(rotation.matrix(), &world_point.coords);
        for column in 0..6 {
            // Exp of a motion along one axis of translation or of rotation alone.
            let moved = |step: f64| {
                let mut axis = Vector3::zeros();
                axis[column % 3] = step;
                let exp = match column {
                    0..3 => Isometry3::translation(axis.x, axis.y, axis.z),
                    _ => Isometry3::rotation(axis),
                };
                M::project(params, &(cam_from_world * exp * world_point).coords)
            };
            // Steps are as long beside the point's distance as those of `derivative_error`.
            let unit =
                if column < 3 { point.norm() } else { point.norm() / world_point.coords.norm() };
            let size = at.wrt_point.norm() * point.norm() / unit;
            let column_of_pose = wrt_pose.column(column).into();
            let Some(error) = least_error(unit, moved, column_of_pose, |_| size) else {
                return false;
            };
            assert!(error < 1e-8, "{} {params:?} at {point:?}, {column}: {error:.1e}", M::NAME);
        }
        true
    }

    #[test]
    fn derivatives_by_pose_are_those_of_a_motion_on_its_right() {
        hold(|example| example.visit(Pose), 300);
    }
}
