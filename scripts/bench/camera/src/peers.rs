//! Their side: apex-camera-models' own batch, and the work that apex-solver's `ProjectionFactor` does with it for each
//! observation: act, project, then `jacobian_pose`, `jacobian_point` times the rotation, `jacobian_intrinsics`.

macro_rules! peer {
    ($name:ident, $models:ident, $manifolds:ident) => {
        pub mod $name {
            use std::hint::black_box;

            use $manifolds::{LieGroup, se3::SE3};
            use $models::CameraModel;
            use nalgebra_0_33::{Matrix3xX, Quaternion, SMatrix, UnitQuaternion, Vector2, Vector3};

            use crate::Contestant;
            use crate::scene::Scene;

            pub struct Peer<C> {
                camera: C,
                pose: SE3,
                in_world: Vec<Vector3<f64>>,
                in_camera: Matrix3xX<f64>,
                observed: Vec<Vector2<f64>>,
            }

            type Factor<J> = (Vector2<f64>, SMatrix<f64, 2, 3>, SMatrix<f64, 2, 6>, J);

            impl<C: CameraModel> Peer<C> {
                pub fn new(camera: C, scene: &Scene) -> Self {
                    let [x, y, z, w] = scene.quaternion;
                    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
                    let translation: [f64; 3] = scene.translation.into();
                    let copy = |point: &nalgebra::Vector3<f64>| Vector3::new(point.x, point.y, point.z);
                    let in_camera: Vec<_> = scene.in_camera.iter().map(copy).collect();
                    Self {
                        camera,
                        pose: SE3::new(translation.into(), rotation),
                        in_world: scene.in_world.iter().map(copy).collect(),
                        in_camera: Matrix3xX::from_columns(&in_camera),
                        observed: scene.observed.iter().map(|pixel| Vector2::new(pixel.x, pixel.y)).collect(),
                    }
                }

                #[inline(always)]
                fn factor_at(&self, world: &Vector3<f64>, observed: &Vector2<f64>) -> Option<Factor<C::IntrinsicJacobian>> {
                    let in_camera = self.pose.act(world, None, None);
                    let pixel = self.camera.project(&in_camera).ok()?;
                    let (wrt_camera, camera_wrt_pose) = self.camera.jacobian_pose(world, &self.pose);
                    let wrt_pose = wrt_camera * camera_wrt_pose;
                    let rotation = self.pose.rotation_so3().rotation_matrix();
                    let wrt_world = self.camera.jacobian_point(&in_camera) * rotation;
                    let wrt_params = self.camera.jacobian_intrinsics(&in_camera);
                    Some((pixel - observed, wrt_world, wrt_pose, wrt_params))
                }
            }

            impl<C: CameraModel> Contestant for Peer<C> {
                fn project(&self) {
                    black_box(self.camera.project_batch(&self.in_camera));
                }

                fn factor(&self) {
                    for (world, observed) in self.in_world.iter().zip(&self.observed) {
                        black_box(&self.factor_at(world, observed));
                    }
                }

                fn unproject(&self) -> Vec<[f64; 3]> {
                    let unproject = |pixel| self.camera.unproject(pixel).map_or([f64::NAN; 3], Into::into);
                    self.observed.iter().map(unproject).collect()
                }

                fn one_factor(&self, index: usize) -> Vec<f64> {
                    let (residual, wrt_world, wrt_pose, wrt_params) =
                        self.factor_at(&self.in_world[index], &self.observed[index]).unwrap();
                    let wrt_params = (0..C::INTRINSIC_DIM).flat_map(|c| [wrt_params[(0, c)], wrt_params[(1, c)]]);
                    let blocks = [residual.as_slice(), wrt_world.as_slice(), wrt_pose.as_slice()].concat();
                    blocks.into_iter().chain(wrt_params).collect()
                }
            }
        }
    };
}

peer!(v0_2, apex_0_2, apex_manifolds_0_2);
peer!(v0_4, apex_0_4, apex_manifolds_0_4);
