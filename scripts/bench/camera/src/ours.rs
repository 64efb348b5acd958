//! Our side: one point after another by the model's own functions, and all in one call.

use std::cell::RefCell;
use std::hint::black_box;
use std::marker::PhantomData;

use calibstab::camera::CameraModel;
use nalgebra::{SMatrix, Vector2, Vector3};

use crate::Contestant;
use crate::scene::{POINTS, Scene};

pub struct Ours<'a, M, const N: usize> {
    params: [f64; N],
    scene: &'a Scene,
    points: [Vec<f64>; 3],
    pixels: [Vec<f64>; 2],
    /// The caller's slices, which batches write to.
    written: RefCell<[Vec<f64>; 3]>,
    model: PhantomData<M>,
}

/// Residual, d/d world point, d/d pose, d/d parameters.
type Factor<const N: usize> =
    (Vector2<f64>, SMatrix<f64, 2, 3>, SMatrix<f64, 2, 6>, SMatrix<f64, 2, N>);

impl<'a, M: CameraModel<N>, const N: usize> Ours<'a, M, N> {
    pub fn new(params: [f64; N], scene: &'a Scene) -> Self {
        let points =
            [0, 1, 2].map(|axis| scene.in_camera.iter().map(|point| point[axis]).collect());
        let pixels = [0, 1].map(|axis| scene.observed.iter().map(|pixel| pixel[axis]).collect());
        let written = RefCell::new([(); 3].map(|()| vec![0.0; POINTS]));
        Self { params, scene, points, pixels, written, model: PhantomData }
    }

    #[inline(always)]
    fn factor_at(&self, world: &Vector3<f64>, observed: &Vector2<f64>) -> Option<Factor<N>> {
        let Scene { rotation, translation, .. } = self.scene;
        let at = M::linearize(&self.params, &(rotation * world + translation))?;
        let wrt_world = at.wrt_world_point(rotation);
        let wrt_pose = at.wrt_pose(rotation, world);
        Some((at.pixel - observed, wrt_world, wrt_pose, at.wrt_params))
    }
}

impl<M: CameraModel<N>, const N: usize> Contestant for Ours<'_, M, N> {
    fn project(&self) {
        let params = self.params;
        let project = |point| M::project(&params, point).map_or([f64::NAN; 2], Into::into);
        black_box(self.scene.in_camera.iter().map(project).collect::<Vec<[f64; 2]>>());
    }

    fn factor(&self) {
        for (world, observed) in self.scene.in_world.iter().zip(&self.scene.observed) {
            black_box(&self.factor_at(world, observed));
        }
    }

    fn unproject(&self) -> Vec<[f64; 3]> {
        let unproject = |pixel| Some(M::unproject(&self.params, pixel)?.normalize());
        self.scene
            .observed
            .iter()
            .map(|pixel| unproject(pixel).map_or([f64::NAN; 3], Into::into))
            .collect()
    }

    fn project_all(&self) {
        let [px, py, _] = &mut *self.written.borrow_mut();
        let points = self.points.each_ref().map(Vec::as_slice);
        black_box(self.scene.camera.project_all(points, [px, py]).unwrap());
    }

    fn unproject_all(&self) {
        let rays = &mut *self.written.borrow_mut();
        let pixels = self.pixels.each_ref().map(Vec::as_slice);
        let rays = rays.each_mut().map(Vec::as_mut_slice);
        black_box(self.scene.camera.unproject_all(pixels, rays).unwrap());
    }

    fn one_factor(&self, index: usize) -> Vec<f64> {
        let (residual, wrt_world, wrt_pose, wrt_params) =
            self.factor_at(&self.scene.in_world[index], &self.scene.observed[index]).unwrap();
        [residual.as_slice(), wrt_world.as_slice(), wrt_pose.as_slice(), wrt_params.as_slice()]
            .concat()
    }
}
