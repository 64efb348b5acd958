//! Laws that hold for every camera model, as checks for those who bring their own.

use nalgebra::{SMatrix, Vector2, Vector3};

use super::CameraModel;

/// The largest error of a model's derivatives at a point, relative to the norm of the column it is in, against
/// differences of fourth order; none where the model does not see the point or a neighbour of it.
///
/// Formula and derivative may share a mistake, which this cannot see: compare pixels with another implementation too.
pub fn derivative_error<M: CameraModel<N>, const N: usize>(
    params: &[f64; N],
    point: &Vector3<f64>,
) -> Option<f64> {
    let at = M::linearize(params, point)?;
    let scale = at.wrt_point.norm();
    let mut worst: f64 = 0.0;
    for axis in 0..3 {
        let moved = |step: f64| {
            let mut moved = *point;
            moved[axis] += step;
            M::project(params, &moved)
        };
        let column = at.wrt_point.column(axis).into();
        worst = worst.max(least_error(point.norm(), moved, column, |_| scale)?);
    }
    for (index, value) in params.iter().enumerate() {
        let moved = |step: f64| {
            let mut moved = *params;
            moved[index] += step;
            M::project(&moved, point)
        };
        let column: Vector2<f64> = at.wrt_params.column(index).into();
        // Columns that rounding alone could make are zero as far as differences can tell.
        let noise = |step: f64| 1e8 * f64::EPSILON * at.pixel.norm().max(1.0) / step;
        let size = value.abs().max(1.0);
        worst = worst.max(least_error(size, moved, column, |step| column.norm().max(noise(step)))?);
    }
    Some(worst)
}

/// The error of a derivative against the difference with the fittest step: a long one bends with the curve, a short one drowns
/// in rounding, and where the curve is steep only few are between.
pub(super) fn least_error(
    size: f64,
    at: impl Fn(f64) -> Option<Vector2<f64>>,
    derivative: Vector2<f64>,
    scale: impl Fn(f64) -> f64,
) -> Option<f64> {
    let errors = (0..6).filter_map(|shorter| {
        let step = 1e-3 * size * 0.1_f64.powi(shorter);
        let near = at(step)? - at(-step)?;
        let far = at(2.0 * step)? - at(-2.0 * step)?;
        let difference = (near * 8.0 - far) / (12.0 * step);
        Some((difference - derivative).norm() / scale(step))
    });
    errors.reduce(f64::min)
}

/// The angle in radians between a point and what its pixel is unprojected to, and how far that may be from zero: 1e-10 and
/// 16 roundings of the pixel, as the lens magnifies them. None where the model does not see the point.
pub fn round_trip_error<M: CameraModel<N>, const N: usize>(
    params: &[f64; N],
    point: &Vector3<f64>,
) -> Option<[f64; 2]> {
    let at = M::linearize(params, point)?;
    let allowed = |sensitivity: f64| 1e-10 + 16.0 * f64::EPSILON * at.pixel.norm() * sensitivity;
    let Some(ray) = M::unproject(params, &at.pixel) else {
        return Some([f64::INFINITY, allowed(ray_per_pixel(&at.wrt_point, point))]);
    };
    let (ray, direction) = (ray.normalize(), point.normalize());
    let angle = ray.cross(&direction).norm().atan2(ray.dot(&direction));
    Some([angle, allowed(ray_per_pixel(&at.wrt_point, point))])
}

/// |d ray / d pixel|: one over the least singular value of d pixel / d point across the ray, at unit distance.
fn ray_per_pixel(wrt_point: &SMatrix<f64, 2, 3>, point: &Vector3<f64>) -> f64 {
    let across = wrt_point * point.norm();
    let gram = across * across.transpose();
    let (trace, determinant) = (gram.trace(), gram.determinant());
    let larger = 0.5 * (trace + (trace * trace - 4.0 * determinant).max(0.0).sqrt());
    (larger / determinant.max(f64::MIN_POSITIVE)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Random, WILD, hold, points};
    use super::super::{Intrinsics, Job};
    use super::*;

    struct Derivatives;
    impl Job for Derivatives {
        type Output = usize;
        fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
            let errors = points().filter_map(|p| Some((p, derivative_error::<M, N>(params, &p)?)));
            let mut count = 0;
            for (point, error) in errors {
                count += 1;
                assert!(error < 1e-8, "{} {params:?} at {point:?}: {error:.1e}", M::NAME);
            }
            count
        }
    }

    #[test]
    fn derivatives_are_those_of_the_projection() {
        hold(|example| example.visit(Derivatives), 300);
    }

    struct RoundTrip;
    impl Job for RoundTrip {
        type Output = usize;
        fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
            let errors = points().filter_map(|p| Some((p, round_trip_error::<M, N>(params, &p)?)));
            let mut count = 0;
            for (point, [angle, allowed]) in errors {
                count += 1;
                assert!(
                    angle <= allowed,
                    "{} {params:?} at {point:?}: {angle:.1e} > {allowed:.1e}",
                    M::NAME
                );
            }
            count
        }
    }

    #[test]
    fn what_is_projected_is_unprojected_to_the_same_ray() {
        hold(|example| example.visit(RoundTrip), 300);
    }

    struct Euler;
    impl Job for Euler {
        type Output = usize;
        fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
            let mut count = 0;
            for point in points() {
                let Some(at) = M::linearize(params, &point) else { continue };
                count += 1;
                let along = (at.wrt_point * point).norm();
                let size = at.wrt_point.norm() * point.norm();
                assert!(along <= 1e-12 * size, "{} {params:?} at {point:?}: {along:.1e}", M::NAME);
            }
            count
        }
    }

    #[test]
    fn distance_does_not_move_the_pixel() {
        hold(|example| example.visit(Euler), 300);
    }

    #[test]
    fn what_is_not_finite_is_neither_seen_nor_searched_for_ever() {
        let law = |camera: &Intrinsics| {
            let mut count = 0;
            for wild in WILD {
                for axis in 0..3 {
                    let mut point = Vector3::new(0.1, -0.2, 1.0);
                    point[axis] = wild;
                    if let Ok(pixel) = camera.project(&point) {
                        let is_finite = pixel.iter().all(|value| value.is_finite());
                        assert!(is_finite, "{camera:?} at {point:?}: {pixel:?}");
                    }
                    count += 1;
                }
                for pixel in [Vector2::new(wild, 240.0), Vector2::new(320.0, wild)] {
                    if let Ok(ray) = camera.unproject(&pixel) {
                        let error = (ray.norm() - 1.0).abs();
                        assert!(error < 1e-15, "{camera:?} at {pixel:?}: {ray:?}");
                    }
                    count += 1;
                }
            }
            count
        };
        hold(law, 30);
    }

    struct Edge;
    impl Job for Edge {
        type Output = usize;
        fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
            let edge = M::largest_angle(params);
            let forward = if M::project(params, &Vector3::new(1e-9, 0.0, 1.0)).is_some() {
                1.0
            } else {
                -1.0
            };
            let mut count = 0;
            for direction in 0..64 {
                let longitude = f64::from(direction) * 0.1;
                let seen = |angle: f64| {
                    let across = Vector2::new(longitude.cos(), longitude.sin()) * angle.sin();
                    M::project(params, &across.push(forward * angle.cos())).is_some()
                };
                if edge < 0.999 * std::f64::consts::PI {
                    assert!(!seen(edge + 1e-6), "{} {params:?} sees beyond its edge", M::NAME);
                }
                assert!(seen(0.5 * edge), "{} {params:?} is blind at half its edge", M::NAME);
                count += 2;
            }
            count
        }
    }

    #[test]
    fn nothing_is_seen_beyond_the_largest_angle() {
        hold(|example| example.visit(Edge), 100);
    }

    /// How many pixels of random cameras are tried for each model: a thousand, or what the environment says.
    fn trials() -> usize {
        let wanted = std::env::var("CALIBSTAB_PIXELS").ok();
        wanted.map_or(1000, |count| count.parse().unwrap())
    }

    struct PixelsOfRandomCameras;
    impl Job for PixelsOfRandomCameras {
        type Output = usize;
        fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> usize {
            let mut random = Random(0x9e37_79b9_7f4a_7c15);
            let mut seen = 0;
            for _ in 0..trials() {
                let mut params = *params;
                for (value, param) in params.iter_mut().zip(&M::PARAMS) {
                    *value *= 1.0 + 0.3 * random.next();
                    if param.is_small {
                        *value += 0.05 * random.next();
                    }
                }
                let pixel =
                    Vector2::new(700.0 + 900.0 * random.next(), 500.0 + 700.0 * random.next());
                let Some(ray) = M::unproject(&params, &pixel) else { continue };
                let back = M::project(&params, &ray);
                let error = back.map(|back| (back - pixel).norm());
                assert!(
                    error.is_some_and(|error| error <= 1e-9),
                    "{} {params:?} at {pixel:?}: {error:?} px off",
                    M::NAME
                );
                seen += 1;
            }
            seen
        }
    }

    #[test]
    fn a_pixel_has_a_ray_that_leads_back_to_it_or_none() {
        hold(|example| example.visit(PixelsOfRandomCameras), trials() / 4);
    }
}
