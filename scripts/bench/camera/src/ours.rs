//! Our side: one point after another, by the model's own functions.

use std::hint::black_box;
use std::marker::PhantomData;

use calibstab::camera::CameraModel;
use nalgebra::{SMatrix, Vector2, Vector3};

use crate::Contestant;
use crate::scene::Scene;

pub struct Ours<'a, M, const N: usize> {
    params: [f64; N],
    scene: &'a Scene,
    model: PhantomData<M>,
}

/// Residual, d/d world point, d/d pose, d/d parameters.
type Factor<const N: usize> = (Vector2<f64>, SMatrix<f64, 2, 3>, SMatrix<f64, 2, 6>, SMatrix<f64, 2, N>);

impl<'a, M: CameraModel<N>, const N: usize> Ours<'a, M, N> {
    pub fn new(params: [f64; N], scene: &'a Scene) -> Self {
        Self { params, scene, model: PhantomData }
    }

    #[inline(always)]
    fn factor_at(&self, world: &Vector3<f64>, observed: &Vector2<f64>) -> Option<Factor<N>> {
        let Scene { rotation, translation, .. } = self.scene;
        let at = M::linearize(&self.params, &(rotation * world + translation))?;
        let wrt_world = at.wrt_point * rotation;
        let mut wrt_pose = SMatrix::<f64, 2, 6>::zeros();
        wrt_pose.fixed_columns_mut::<3>(0).copy_from(&wrt_world);
        for row in 0..2 {
            let turned = world.cross(&wrt_world.row(row).transpose());
            wrt_pose.fixed_view_mut::<1, 3>(row, 3).copy_from(&turned.transpose());
        }
        Some((at.pixel - observed, wrt_world, wrt_pose, at.wrt_params))
    }
}

impl<M: CameraModel<N>, const N: usize> Contestant for Ours<'_, M, N> {
    fn project(&self) {
        let project = |point| M::project(&self.params, point).map_or([f64::NAN; 2], Into::into);
        black_box(self.scene.in_camera.iter().map(project).collect::<Vec<[f64; 2]>>());
    }

    fn factor(&self) {
        for (world, observed) in self.scene.in_world.iter().zip(&self.scene.observed) {
            black_box(&self.factor_at(world, observed));
        }
    }

    fn unproject(&self) -> Vec<[f64; 3]> {
        let unproject = |pixel| Some(M::unproject(&self.params, pixel)?.normalize());
        self.scene.observed.iter().map(|pixel| unproject(pixel).map_or([f64::NAN; 3], Into::into)).collect()
    }

    fn one_factor(&self, index: usize) -> Vec<f64> {
        let (residual, wrt_world, wrt_pose, wrt_params) =
            self.factor_at(&self.scene.in_world[index], &self.scene.observed[index]).unwrap();
        [residual.as_slice(), wrt_world.as_slice(), wrt_pose.as_slice(), wrt_params.as_slice()].concat()
    }
}
