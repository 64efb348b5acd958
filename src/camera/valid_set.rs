//! Where in an image a lens sees: pixels without a ray, and folds.
//!
//! Seen pixels surround the principal point, and whoever goes away from it leaves them once.

use nalgebra::{Vector2, Vector3};

use super::lens::largest;
use super::{Intrinsics, Project, Unproject};

impl Intrinsics {
    /// How far from the principal point, in px, the lens folds in a direction of the image; none where it does not.
    ///
    /// At a fold the pixel stands still while the ray moves on, or the reverse; beyond it, pixels have no ray. A lens that sees all
    /// directions ends without one. For a radial lens of one focal length it is the same in all directions.
    pub fn fold_radius_px(&self, direction: &Vector2<f64>) -> Option<f64> {
        /// No image is larger, and far beyond it polynomials leave the doubles.
        const FARTHEST_PX: f64 = 1e6;
        /// From the first to the second of these shares of the way to a fold, the ray speeds up like the root of what is left,
        /// a hundred times, or slows down like the rest itself; elsewhere no lens does so by more than a few parts in ten.
        const BEFORE: [f64; 2] = [1.0 - 1e-2, 1.0 - 1e-6];
        const REGULAR: std::ops::Range<f64> = 0.2..5.0;
        let (centre, direction) = (self.principal_point()?, direction.try_normalize(0.0)?);
        let pixel_at = |radius: f64| centre + direction * radius;
        let radius = largest(FARTHEST_PX, |radius| self.has_ray(&pixel_at(radius)));
        let [before, there] = BEFORE.map(|share| self.speed(&pixel_at(share * radius), &direction));
        let is_regular =
            there.zip(before).is_some_and(|(there, before)| REGULAR.contains(&(there / before)));
        (radius < FARTHEST_PX && !is_regular).then_some(radius)
    }

    /// Whether the lens folds inside an image of this size: whether some pixel, corners of the image included, has no ray
    /// because the map folds before it.
    pub fn folds_inside(&self, width: u32, height: u32) -> bool {
        let Some(centre) = self.principal_point() else { return false };
        let [right, bottom] = [width, height].map(f64::from);
        let corners = [[0.0, 0.0], [right, 0.0], [0.0, bottom], [right, bottom]].map(Vector2::from);
        let [columns, rows] = [width, height].map(|count| (0..count).map(|at| f64::from(at) + 0.5));
        let is_unseen = |pixel: &Vector2<f64>| !self.has_ray(pixel);
        // Where one pixel of a side has no ray because of a fold, so have all of that side.
        let unseen = [
            corners.into_iter().find(is_unseen),
            columns.clone().map(|x| Vector2::new(x, 0.5)).find(is_unseen),
            columns.map(|x| Vector2::new(x, bottom - 0.5)).find(is_unseen),
            rows.clone().map(|y| Vector2::new(0.5, y)).find(is_unseen),
            rows.map(|y| Vector2::new(right - 0.5, y)).find(is_unseen),
        ];
        unseen.iter().flatten().any(|pixel| self.fold_radius_px(&(pixel - centre)).is_some())
    }

    /// The share of the pixels of an image of this size that no ray leads to.
    ///
    /// Counted at the centre of every pixel. In each row the seen ones are taken to be neighbours of the one nearest to the
    /// principal point, so that only their ends are searched for.
    pub fn share_without_ray(&self, width: u32, height: u32) -> f64 {
        let (Some(last), Some(centre)) = (width.checked_sub(1), self.principal_point()) else {
            return 1.0;
        };
        let nearest = column_at(centre.x, last);
        // Pixels without a ray are the dearest: the ends of a row are sought from those of the row before.
        let (mut to_left, mut to_right) = (nearest, last - nearest);
        let seen_in_row = |row: u32| {
            let y = f64::from(row) + 0.5;
            let is_seen = |column: u32| self.has_ray(&Vector2::new(f64::from(column) + 0.5, y));
            to_left = run_length(nearest, to_left, |step| is_seen(nearest - step));
            to_right = run_length(last - nearest, to_right, |step| is_seen(nearest + step));
            u64::from((to_left + to_right).saturating_sub(1))
        };
        let seen: u64 = (0..height).map(seen_in_row).sum();
        1.0 - seen as f64 / (f64::from(width) * f64::from(height)).max(1.0)
    }

    /// The pixel of the optical axis.
    fn principal_point(&self) -> Option<Vector2<f64>> {
        let axis = Vector3::z();
        self.visit(Project(&axis)).or_else(|| self.visit(Project(&-axis)))
    }

    fn has_ray(&self, pixel: &Vector2<f64>) -> bool {
        self.visit(Unproject(pixel)).is_some()
    }

    /// How fast the ray turns, in radians a px, as the pixel moves in a direction.
    fn speed(&self, pixel: &Vector2<f64>, direction: &Vector2<f64>) -> Option<f64> {
        let wrt_point = self.linearize(&self.visit(Unproject(pixel))?)?.wrt_point;
        let pixel_per_ray = wrt_point * wrt_point.transpose();
        Some(direction.dot(&(pixel_per_ray.try_inverse()? * direction)).sqrt())
    }
}

/// The column whose pixels are nearest to this x, up to the last.
fn column_at(x: f64, last: u32) -> u32 {
    let (mut low, mut high) = (0, last);
    while low < high {
        let middle = low + (high - low) / 2;
        // The centres of this column and the next are equally far from here.
        if x <= f64::from(middle) + 1.0 { high = middle } else { low = middle + 1 }
    }
    low
}

/// How many steps from 0 to `last` are good, where everything before a good one is; probably as many as `guess`.
fn run_length(last: u32, guess: u32, is_good: impl Fn(u32) -> bool) -> u32 {
    let (mut count, mut bad) = (0, last + 1);
    let (mut probe, mut stride) = (guess.min(last), 1);
    while count < bad {
        if is_good(probe) {
            count = probe + 1
        } else {
            bad = probe
        }
        // In growing strides until the end lies between two probes, then by halves.
        probe = if bad > last {
            count.saturating_add(stride - 1).min(last)
        } else if count == 0 {
            bad.saturating_sub(stride)
        } else {
            count + (bad - count) / 2
        };
        stride = stride.saturating_mul(2);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::super::testing::hold;
    use super::super::{CameraError, Model, examples};
    use super::*;

    fn camera(name: &str, params: &[f64]) -> Intrinsics {
        Model::named(name).unwrap().with_params(params).unwrap()
    }

    #[test]
    fn the_thesis_camera_folds_inside_its_own_image() {
        let camera = camera("SIMPLE_RADIAL", &[1011.91, 640.0, 480.0, -0.241569]);
        // 1 + 3 k r^2 = 0 at r = 1 / sqrt(-3 k), where the image radius f r (1 + k r^2) = f r 2/3 is 792.4 px
        let fold = 1011.91 * 2.0 / 3.0 / (3.0_f64 * 0.241569).sqrt();
        assert!((fold - 792.4).abs() < 0.05, "{fold}");
        assert!((1011.91 * camera.largest_angle().tan() * 2.0 / 3.0 - fold).abs() < 1e-6);
        for direction in [Vector2::x(), -Vector2::y(), Vector2::new(-4.0, 3.0)] {
            let found = camera.fold_radius_px(&direction).unwrap();
            assert!((found - fold).abs() < 1e-6, "{found}");
        }
        // Its corner is at 800 px.
        assert!(camera.folds_inside(1280, 960));
        let smaller = Intrinsics::SimpleRadial([1011.91, 500.0, 400.0, -0.241569]);
        assert!(!smaller.folds_inside(1000, 800), "its corner is at 640 px");
        let corner = camera.unproject(&Vector2::new(0.0, 0.0)).unwrap_err();
        assert_eq!(corner, CameraError::PointOutsideImage { x: 0.0, y: 0.0 });
        assert_eq!(corner.to_string(), "no ray leads to the pixel (0, 0)");
        // Pixel centres beyond a circle, counted here without any lens.
        let beyond = (0..960).flat_map(|row| (0..1280).map(move |column| (column, row)));
        let beyond = beyond.filter(|&(column, row)| {
            (f64::from(column) - 639.5).hypot(f64::from(row) - 479.5) > fold
        });
        let share = beyond.count() as f64 / (1280.0 * 960.0);
        assert!(share > 0.0 && (camera.share_without_ray(1280, 960) - share).abs() < 1e-12);
    }

    #[test]
    fn fisheyes_of_the_thesis_have_pixels_without_a_ray() {
        // Counted by numpy: pixel centres beyond the first root of dr / dtheta, which the first two do not have.
        for (camera, unseen, folds_at_px) in [
            (
                camera(
                    "OPENCV_FISHEYE",
                    &[402.294, 437.448, 512.0, 512.0, -0.0814756, 0.121485, -0.0880346, 0.0181435],
                ),
                0,
                None,
            ),
            (
                camera(
                    "OPENCV_FISHEYE",
                    &[428.331, 444.79, 512.0, 512.0, 0.00974985, 0.0337692, -0.0801194, 0.0217839],
                ),
                0,
                None,
            ),
            (
                camera(
                    "OPENCV_FISHEYE",
                    &[
                        419.591,
                        418.346,
                        512.0,
                        512.0,
                        -0.0748247,
                        0.00877295,
                        -0.00344216,
                        0.000329053,
                    ],
                ),
                77_632,
                Some(591.707_184_623),
            ),
            (
                camera("SIMPLE_RADIAL_FISHEYE", &[427.761, 512.0, 512.0, -0.0768701]),
                73_952,
                Some(593.841_544_288),
            ),
            (
                camera("SIMPLE_RADIAL_FISHEYE", &[419.312, 512.0, 512.0, -0.0677735]),
                46_184,
                Some(619.948_263_313),
            ),
        ] {
            let share = f64::from(unseen) / (1024.0 * 1024.0);
            assert!((camera.share_without_ray(1024, 1024) - share).abs() < 1e-12, "{camera:?}");
            let radius = camera.fold_radius_px(&Vector2::x());
            assert_eq!(radius.is_some(), folds_at_px.is_some(), "{camera:?}");
            let error = radius.unwrap_or(0.0) - folds_at_px.unwrap_or(0.0);
            assert!(error.abs() < 1e-6, "{camera:?}: {radius:?}");
            assert_eq!(camera.folds_inside(1024, 1024), unseen > 0, "{camera:?}");
        }
    }

    #[test]
    fn only_a_fold_is_called_one() {
        let pinhole = [500.0, 490.0, 320.0, 240.0];
        for (name, extra, folds) in [
            ("PINHOLE", vec![], None),
            // 1 / (3 k) and its like are where a parabola turns back
            ("OPENCV", vec![-0.3, 0.0, 0.0, 0.0], Some(500.0 * 2.0 / 3.0 / 0.9_f64.sqrt())),
            ("OPENCV", vec![0.3, 0.0, 0.0, 0.0], None),
            // Sees the whole sphere, within a circle of 500 pi px.
            ("FISHEYE", vec![], None),
            ("OPENCV_FISHEYE", vec![-0.1, 0.0, 0.0, 0.0], Some(500.0 * 2.0 / 3.0 / 0.3_f64.sqrt())),
            ("FOV", vec![0.9], None),
            // r = 1 / sqrt(2 alpha - 1)
            ("UCM", vec![0.8], Some(500.0 / 0.6_f64.sqrt())),
            ("UCM", vec![0.5], None),
            ("UCM", vec![0.3], None),
            ("EUCM", vec![0.8, 2.0], Some(500.0 / 1.2_f64.sqrt())),
            ("DOUBLE_SPHERE", vec![0.0, 0.8], Some(500.0 / 0.6_f64.sqrt())),
            ("DOUBLE_SPHERE", vec![-0.2, 0.4], None),
            // k r^2 = 1, less the thousandth at which it is cut off
            ("DIVISION", vec![0.1], Some(500.0 * (0.999_f64 / 0.1).sqrt())),
            ("DIVISION", vec![-0.2], None),
        ] {
            let camera = camera(name, &[&pinhole[..], &extra].concat());
            let found = camera.fold_radius_px(&Vector2::x());
            assert_eq!(found.is_some(), folds.is_some(), "{camera:?}: {found:?}");
            let error = found.unwrap_or(0.0) - folds.unwrap_or(0.0);
            assert!(error.abs() < 1e-5, "{camera:?}: {found:?}");
            assert_eq!(camera.folds_inside(100_000, 100_000), folds.is_some(), "{camera:?}");
        }
        let sphere = camera("EQUIRECTANGULAR", &[2000.0, 1000.0]);
        for direction in [Vector2::x(), Vector2::y(), Vector2::new(0.6, 0.8)] {
            assert_eq!(sphere.fold_radius_px(&direction), None);
        }
        assert!(!sphere.folds_inside(3000, 3000));
    }

    #[test]
    fn decentring_alone_can_fold_an_image() {
        let params = [500.0, 500.0, 320.0, 240.0, 0.0, 0.0, 0.0, 0.05];
        let camera = Intrinsics::OpenCv(params);
        let mut moved = params;
        moved[2] = 1000.0;
        // px = 500 (u + 3 p2 u^2): folds at u = -1 / (6 p2), 833.3 px to the left
        let found = camera.fold_radius_px(&-Vector2::x()).unwrap();
        assert!((found - 500.0 / (12.0 * 0.05)).abs() < 1e-5, "{found}");
        assert_eq!(camera.fold_radius_px(&Vector2::x()), None);
        // Beyond u = -1 / (2 p2) it is turned over twice, and looks right again.
        for u in [-3.4, -9.9, -10.1, -50.0] {
            let error = camera.project(&Vector3::new(u, 0.0, 1.0)).unwrap_err();
            assert_eq!(error, CameraError::ProjectionOutOfBounds, "{u}");
        }
        assert!(
            !camera.folds_inside(640, 480) && Intrinsics::OpenCv(moved).folds_inside(1280, 480)
        );
    }

    #[test]
    fn the_share_is_that_of_all_pixels_looked_at_one_by_one() {
        let law = |example: &Intrinsics| {
            let mut count = 0;
            for (width, height) in [(301, 203), (61, 97)] {
                // The same lens with its image a few times as wide as usual, in few pixels.
                let params = shrunk(example, 0.12);
                let columns =
                    (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
                let unseen = columns.filter(|&(column, row)| {
                    let pixel = Vector2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
                    params.unproject(&pixel).is_err()
                });
                let share = unseen.count() as f64 / (f64::from(width) * f64::from(height));
                let found = params.share_without_ray(width, height);
                assert!((found - share).abs() < 1e-12, "{params:?}: {found}, not {share}");
                count += 1;
            }
            count
        };
        hold(law, 4);
        let with_holes =
            examples().iter().filter(|e| shrunk(e, 0.12).share_without_ray(301, 203) > 0.0).count();
        assert!(with_holes >= 20, "{with_holes}");
    }

    /// The lens in coarser pixels.
    fn shrunk(camera: &Intrinsics, factor: f64) -> Intrinsics {
        let params = camera.model().params.iter().zip(camera.params());
        let params: Vec<f64> = params
            .map(
                |(param, value)| if param.unit.starts_with("px") { value * factor } else { *value },
            )
            .collect();
        camera.model().with_params(&params).unwrap()
    }
}
