//! Many points or pixels of one camera at once: one dispatch a call, a loop compiled for each model.
//!
//! Coordinates are structures of arrays, one slice each. What is not seen becomes NaN in every number that belongs to it.

use multiversion::multiversion;
use nalgebra::{Vector2, Vector3};

use super::{CameraError, CameraModel, Intrinsics, Job, Linearized, unit_ray};

/// Where [`Intrinsics::linearize_all`] writes, for n points and a model of N parameters.
#[derive(Debug)]
pub struct LinearizedSlices<'a> {
    /// The pixels: x and y, n numbers each.
    pub pixels: [&'a mut [f64]; 2],
    /// d pixel / d point: 6 n numbers, a matrix of 2 n x 3 row by row, with the rows of px and py for each point.
    pub wrt_point: &'a mut [f64],
    /// d pixel / d parameters, in file order: 2 n N numbers, a matrix of 2 n x N row by row in the same way.
    pub wrt_params: &'a mut [f64],
}

impl Intrinsics {
    /// The pixels of points in camera coordinates, x, y and z; the same bits as [`project`](Self::project) gives, and NaN where
    /// that is an error. Gives how many are seen.
    pub fn project_all(
        &self,
        points: [&[f64]; 3],
        pixels: [&mut [f64]; 2],
    ) -> Result<usize, CameraError> {
        let count = same_length(["x", "y", "z"], points, points[0].len())?;
        same_length(["px", "py"], [&*pixels[0], &*pixels[1]], count)?;
        Ok(self.visit(ProjectAll { points, pixels }))
    }

    /// The unit rays, x, y and z, of what pixels see; the same bits as [`unproject`](Self::unproject) gives, and NaN where that
    /// is an error. Gives how many see something.
    pub fn unproject_all(
        &self,
        pixels: [&[f64]; 2],
        rays: [&mut [f64]; 3],
    ) -> Result<usize, CameraError> {
        let count = same_length(["px", "py"], pixels, pixels[0].len())?;
        same_length(["x", "y", "z"], [&*rays[0], &*rays[1], &*rays[2]], count)?;
        Ok(self.visit(UnprojectAll { pixels, rays }))
    }

    /// The pixels of points in camera coordinates, and d pixel / d point: px and then py by x, y, z. NaN where a point is not seen.
    /// Gives how many are. Much cheaper than [`linearize_all`](Self::linearize_all), as a loop of most lenses is SIMD.
    pub fn look_all(
        &self,
        points: [&[f64]; 3],
        pixels: [&mut [f64]; 2],
        wrt_point: [&mut [f64]; 6],
    ) -> Result<usize, CameraError> {
        let count = same_length(["x", "y", "z"], points, points[0].len())?;
        same_length(["px", "py"], [&*pixels[0], &*pixels[1]], count)?;
        same_length(["wrt_point"; 6], wrt_point.each_ref().map(|slice| &**slice), count)?;
        Ok(self.visit(LookAll { points, pixels, wrt_point }))
    }

    /// The pixels of points in camera coordinates with their derivatives, and NaN where a point is not seen. Gives how many are.
    pub fn linearize_all(
        &self,
        points: [&[f64]; 3],
        out: LinearizedSlices,
    ) -> Result<usize, CameraError> {
        let count = same_length(["x", "y", "z"], points, points[0].len())?;
        same_length(["px", "py"], [&*out.pixels[0], &*out.pixels[1]], count)?;
        same_length(["wrt_point"], [&*out.wrt_point], 6 * count)?;
        same_length(["wrt_params"], [&*out.wrt_params], 2 * self.params().len() * count)?;
        Ok(self.visit(LinearizeAll { points, out }))
    }
}

fn same_length<const K: usize>(
    names: [&'static str; K],
    slices: [&[f64]; K],
    want: usize,
) -> Result<usize, CameraError> {
    for (slice, got) in names.into_iter().zip(slices.map(<[f64]>::len)) {
        if got != want {
            return Err(CameraError::SliceLength { slice, want, got });
        }
    }
    Ok(want)
}

/// The vectors of a structure of arrays.
#[inline(always)]
fn vectors([x, y, z]: [&[f64]; 3]) -> impl Iterator<Item = Vector3<f64>> {
    x.iter().zip(y).zip(z).map(|((x, y), z)| Vector3::new(*x, *y, *z))
}

struct ProjectAll<'a> {
    points: [&'a [f64]; 3],
    pixels: [&'a mut [f64]; 2],
}

impl Job for ProjectAll<'_> {
    type Output = usize;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
        // A copy, which no pixel that is written can change.
        let (params, [px, py]) = (&params.clone(), self.pixels);
        if M::AT_ONCE {
            project_at_once::<M, N>(params, self.points, [px, py]);
        }
        let mut seen = 0;
        for (point, (px, py)) in vectors(self.points).zip(px.iter_mut().zip(py)) {
            if !M::AT_ONCE || px.is_nan() {
                let pixel = M::project(params, &point);
                [*px, *py] = pixel.map_or([f64::NAN; 2], Into::into);
            }
            seen += usize::from(!px.is_nan());
        }
        seen
    }
}

/// The pixels that are surely right, and NaN for the others.
#[multiversion(targets("x86_64+avx2"))]
fn project_at_once<M: CameraModel<N>, const N: usize>(
    params: &[f64; N],
    [x, y, z]: [&[f64]; 3],
    [px, py]: [&mut [f64]; 2],
) {
    // A copy, as above, and slices of one length, so that no index is checked.
    let (params, count) = (&params.clone(), x.len());
    let (y, z, px, py) = (&y[..count], &z[..count], &mut px[..count], &mut py[..count]);
    for index in 0..count {
        let point = Vector3::new(x[index], y[index], z[index]);
        let (at, is_sure) = M::linearize_at_once(params, &point);
        px[index] = if is_sure { at.pixel.x } else { f64::NAN };
        py[index] = at.pixel.y;
    }
}

struct LookAll<'a> {
    points: [&'a [f64]; 3],
    pixels: [&'a mut [f64]; 2],
    wrt_point: [&'a mut [f64]; 6],
}

impl Job for LookAll<'_> {
    type Output = usize;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
        let (params, [px, py], mut wrt_point) = (&params.clone(), self.pixels, self.wrt_point);
        if M::AT_ONCE {
            let slices = wrt_point.each_mut().map(|slice| &mut **slice);
            look_at_once::<M, N>(params, self.points, [&mut *px, &mut *py], slices);
        }
        let mut seen = 0;
        for (index, point) in vectors(self.points).enumerate() {
            if !M::AT_ONCE || px[index].is_nan() {
                let at = M::linearize(params, &point).unwrap_or(Linearized::NONE);
                [px[index], py[index]] = at.pixel.into();
                for (slice, value) in wrt_point.iter_mut().zip(row_by_row(&at)) {
                    slice[index] = value;
                }
            }
            seen += usize::from(!px[index].is_nan());
        }
        seen
    }
}

/// d pixel / d point, row by row.
#[inline(always)]
fn row_by_row<const N: usize>(at: &Linearized<N>) -> [f64; 6] {
    std::array::from_fn(|index| at.wrt_point[(index / 3, index % 3)])
}

/// The pixels that are surely right with their derivatives by the point, and NaN for the others.
#[multiversion(targets("x86_64+avx2"))]
fn look_at_once<M: CameraModel<N>, const N: usize>(
    params: &[f64; N],
    [x, y, z]: [&[f64]; 3],
    [px, py]: [&mut [f64]; 2],
    wrt_point: [&mut [f64]; 6],
) {
    let (params, count) = (&params.clone(), x.len());
    let (y, z, px, py) = (&y[..count], &z[..count], &mut px[..count], &mut py[..count]);
    let [a, b, c, d, e, f] = wrt_point.map(|slice| &mut slice[..count]);
    for index in 0..count {
        let point = Vector3::new(x[index], y[index], z[index]);
        let (at, is_sure) = M::linearize_at_once(params, &point);
        px[index] = if is_sure { at.pixel.x } else { f64::NAN };
        py[index] = at.pixel.y;
        [a[index], b[index], c[index], d[index], e[index], f[index]] = row_by_row(&at);
    }
}

struct UnprojectAll<'a> {
    pixels: [&'a [f64]; 2],
    rays: [&'a mut [f64]; 3],
}

impl Job for UnprojectAll<'_> {
    type Output = usize;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
        let (params, [px, py], [x, y, z]) = (&params.clone(), self.pixels, self.rays);
        if M::AT_ONCE {
            unproject_at_once::<M, N>(params, [px, py], [x, y, z]);
        }
        let mut seen = 0;
        for ((px, py), ((x, y), z)) in px.iter().zip(py).zip(x.iter_mut().zip(y).zip(z)) {
            if !M::AT_ONCE || x.is_nan() {
                let ray = unit_ray::<M, N>(params, &Vector2::new(*px, *py));
                [*x, *y, *z] = ray.map_or([f64::NAN; 3], Into::into);
            }
            seen += usize::from(!x.is_nan());
        }
        seen
    }
}

/// The unit rays that are surely right, and NaN for the others.
#[multiversion(targets("x86_64+avx2"))]
fn unproject_at_once<M: CameraModel<N>, const N: usize>(
    params: &[f64; N],
    [px, py]: [&[f64]; 2],
    [x, y, z]: [&mut [f64]; 3],
) {
    let (params, count) = (&params.clone(), px.len());
    let (py, x, y, z) = (&py[..count], &mut x[..count], &mut y[..count], &mut z[..count]);
    for index in 0..count {
        let (ray, is_sure) = M::unproject_at_once(params, &Vector2::new(px[index], py[index]));
        let length = ray.norm();
        let (ray, has_length) = (ray / length, length > 0.0 && length < f64::INFINITY);
        x[index] = if is_sure && has_length { ray.x } else { f64::NAN };
        [y[index], z[index]] = [ray.y, ray.z];
    }
}

struct LinearizeAll<'a> {
    points: [&'a [f64]; 3],
    out: LinearizedSlices<'a>,
}

impl Job for LinearizeAll<'_> {
    type Output = usize;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
        let LinearizedSlices { pixels: [px, py], wrt_point, wrt_params } = self.out;
        let pixels = px.iter_mut().zip(py);
        let blocks = wrt_point.chunks_exact_mut(6).zip(wrt_params.chunks_exact_mut(2 * N));
        let mut seen = 0;
        for ((point, (px, py)), (wrt_point, wrt_params)) in
            vectors(self.points).zip(pixels).zip(blocks)
        {
            let Some(at) = M::linearize(params, &point) else {
                [*px, *py] = [f64::NAN; 2];
                wrt_point.fill(f64::NAN);
                wrt_params.fill(f64::NAN);
                continue;
            };
            seen += 1;
            [*px, *py] = at.pixel.into();
            for row in 0..2 {
                for column in 0..3 {
                    wrt_point[3 * row + column] = at.wrt_point[(row, column)];
                }
                for column in 0..N {
                    wrt_params[N * row + column] = at.wrt_params[(row, column)];
                }
            }
        }
        seen
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{hold, points};
    use super::super::{Model, Pinhole};
    use super::*;

    fn bits<const K: usize>(values: [f64; K]) -> [u64; K] {
        values.map(f64::to_bits)
    }

    /// Compares the enum and the slices, which it gets, with the model itself.
    struct Dispatch<'a> {
        camera: &'a Intrinsics,
        points: &'a [Vec<f64>; 3],
        pixels: &'a [Vec<f64>; 2],
        rays: &'a [Vec<f64>; 3],
        wrt: [&'a [f64]; 2],
    }

    impl Job for Dispatch<'_> {
        type Output = usize;
        fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
            let mut count = 0;
            for (index, point) in vectors(self.points.each_ref().map(Vec::as_slice)).enumerate() {
                let pixel = M::project(params, &point);
                assert_eq!(self.camera.project(&point).ok(), pixel);
                let want: [f64; 2] = pixel.map_or([f64::NAN; 2], Into::into);
                let found = self.pixels.each_ref().map(|axis| axis[index]);
                assert_eq!(bits(found), bits(want), "{} {params:?} at {point:?}", M::NAME);
                let [wrt_point, wrt_params] = self.wrt;
                let rows = |found: &[f64], width: usize, row: usize, column: usize| {
                    found[(2 * index + row) * width + column].to_bits()
                };
                let Some(at) = M::linearize(params, &point) else {
                    assert!(pixel.is_none() && wrt_params[2 * N * index].is_nan());
                    assert!(self.camera.linearize(&point).is_none());
                    continue;
                };
                count += 1;
                assert_eq!(Some(at.pixel), pixel);
                let padded = self.camera.linearize(&point).unwrap();
                assert_eq!((padded.pixel, padded.wrt_point), (at.pixel, at.wrt_point));
                assert_eq!(padded.wrt_params.columns(0, N), at.wrt_params);
                assert!(
                    padded.wrt_params.columns_range(N..).iter().all(|zero| zero.to_bits() == 0)
                );
                for row in 0..2 {
                    for column in 0..3 {
                        let want = at.wrt_point[(row, column)].to_bits();
                        assert_eq!(rows(wrt_point, 3, row, column), want, "{}", M::NAME);
                    }
                    for column in 0..N {
                        let want = at.wrt_params[(row, column)].to_bits();
                        assert_eq!(rows(wrt_params, N, row, column), want, "{}", M::NAME);
                    }
                }
                let ray = M::unproject(params, &at.pixel).map(|ray| ray.normalize());
                assert_eq!(self.camera.unproject(&at.pixel).ok(), ray);
                let want: [f64; 3] = ray.map_or([f64::NAN; 3], Into::into);
                let found = self.rays.each_ref().map(|axis| axis[index]);
                assert_eq!(bits(found), bits(want), "{} {params:?} at {point:?}", M::NAME);
            }
            count
        }
    }

    #[test]
    fn enum_model_and_slices_give_the_same_bits() {
        let points: [Vec<f64>; 3] = [0, 1, 2].map(|axis| points().map(|p| p[axis]).collect());
        let count = points[0].len();
        let slices = points.each_ref().map(Vec::as_slice);
        let law = |camera: &Intrinsics| {
            let zeros = || vec![0.0; count];
            let [mut pixels, mut again] = [[zeros(), zeros()], [zeros(), zeros()]];
            let mut rays = [zeros(), zeros(), zeros()];
            let mut wrt_point = vec![0.0; 6 * count];
            let mut wrt_params = vec![0.0; 2 * camera.params().len() * count];
            let seen =
                camera.project_all(slices, pixels.each_mut().map(Vec::as_mut_slice)).unwrap();
            let out = LinearizedSlices {
                pixels: again.each_mut().map(Vec::as_mut_slice),
                wrt_point: &mut wrt_point,
                wrt_params: &mut wrt_params,
            };
            assert_eq!(camera.linearize_all(slices, out).unwrap(), seen);
            let all_bits = |of: &[Vec<f64>; 2]| of.concat().into_iter().map(f64::to_bits).collect();
            let [first, second]: [Vec<u64>; 2] = [all_bits(&pixels), all_bits(&again)];
            assert_eq!(first, second);
            let mut wrt: [Vec<f64>; 6] = std::array::from_fn(|_| zeros());
            let [px, py] = &mut again;
            let wrt_slices = wrt.each_mut().map(Vec::as_mut_slice);
            assert_eq!(camera.look_all(slices, [px, py], wrt_slices).unwrap(), seen);
            assert_eq!(all_bits(&again), first);
            for (place, value) in wrt_point.iter().enumerate() {
                let found = wrt[place % 6][place / 6];
                assert!(found.to_bits() == value.to_bits() || (found.is_nan() && value.is_nan()));
            }
            let read = pixels.each_ref().map(Vec::as_slice);
            camera.unproject_all(read, rays.each_mut().map(Vec::as_mut_slice)).unwrap();
            let job = Dispatch {
                camera,
                points: &points,
                pixels: &pixels,
                rays: &rays,
                wrt: [&wrt_point, &wrt_params],
            };
            let compared = camera.visit(job);
            assert_eq!(compared, seen);
            compared
        };
        hold(law, 300);
    }

    #[test]
    fn slices_of_unlike_lengths_are_refused() {
        let camera = Intrinsics::Pinhole(Pinhole::EXAMPLES[0]);
        let mut out = [[0.0; 3]; 2];
        let [px, py] = &mut out;
        let error = camera.project_all([&[1.0; 3], &[1.0; 3], &[1.0; 2]], [px, py]).unwrap_err();
        assert_eq!(error, CameraError::SliceLength { slice: "z", want: 3, got: 2 });
        assert_eq!(error.to_string(), "z holds 2 numbers, and needs 3");
        let [px, _] = &mut out;
        let error = camera.project_all([&[1.0; 3]; 3], [px, &mut []]).unwrap_err();
        assert_eq!(error, CameraError::SliceLength { slice: "py", want: 3, got: 0 });
        let [px, py] = &mut out;
        let error = camera.unproject_all([&[1.0; 2]; 2], [px, py, &mut [0.0; 2]]).unwrap_err();
        assert_eq!(error, CameraError::SliceLength { slice: "x", want: 2, got: 3 });
        let model = Model::named("PINHOLE").unwrap();
        let [px, py] = &mut out;
        let out = LinearizedSlices {
            pixels: [px, py],
            wrt_point: &mut [0.0; 18],
            wrt_params: &mut [0.0; 23],
        };
        let error = camera.linearize_all([&[1.0; 3]; 3], out).unwrap_err();
        let want = 3 * 2 * model.params.len();
        assert_eq!(error, CameraError::SliceLength { slice: "wrt_params", want, got: 23 });
    }
}
