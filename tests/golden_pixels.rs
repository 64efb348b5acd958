//! Pixels and rays as pycolmap 4.2.1 sees them: laws cannot find a mistake that formula and derivative share.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::collections::BTreeSet;

use calibstab::camera::{CameraError, Intrinsics, MODELS, Model};
use nalgebra::{Vector2, Vector3};

/// A camera and the numbers that follow it in a table.
fn table<const N: usize>(name: &str) -> Vec<(Intrinsics, [f64; N])> {
    let path = format!("{}/fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
    let mut rows = csv::Reader::from_path(path).unwrap();
    let row = |record: csv::StringRecord| {
        let params: Vec<f64> = record[1].split(' ').map(|value| value.parse().unwrap()).collect();
        let camera = Model::named(&record[0]).unwrap().with_params(&params).unwrap();
        (camera, std::array::from_fn(|column| record[2 + column].parse().unwrap()))
    };
    rows.records().map(|record| row(record.unwrap())).collect()
}

fn pixels() -> impl Iterator<Item = (Intrinsics, Vector3<f64>, Vector2<f64>)> {
    let row = |(camera, [x, y, z, px, py]): (_, [f64; 5])| {
        (camera, Vector3::new(x, y, z), Vector2::new(px, py))
    };
    table::<5>("golden_pixels.csv").into_iter().map(row)
}

/// A pixel, pycolmap's ray of it, and the pixel to which pycolmap projects that ray.
struct Ray {
    camera: Intrinsics,
    pixel: Vector2<f64>,
    ray: Vector3<f64>,
    back: Vector2<f64>,
}

impl Ray {
    fn error_px(&self) -> f64 {
        (self.back - self.pixel).norm()
    }
}

/// Where pycolmap is right, and where it is wrong.
fn rays() -> (Vec<Ray>, Vec<Ray>) {
    let row = |(camera, [px, py, x, y, z, back_px, back_py]): (_, [f64; 7])| Ray {
        camera,
        pixel: Vector2::new(px, py),
        ray: Vector3::new(x, y, z),
        back: Vector2::new(back_px, back_py),
    };
    // It iterates to 5e-8 px; its faults begin at 1e-2 px.
    table::<7>("golden_rays.csv").into_iter().map(row).partition(|ray| ray.error_px() <= 5e-8)
}

fn all_of_colmap<'a>(cameras: impl Iterator<Item = &'a Intrinsics>) {
    let models: BTreeSet<&str> = cameras.map(|camera| camera.model().name).collect();
    let of_colmap = MODELS.iter().filter(|model| model.colmap_id.is_some()).count();
    assert_eq!(models.len(), of_colmap);
}

#[test]
fn points_are_seen_where_colmap_sees_them() {
    all_of_colmap(pixels().map(|(camera, ..)| camera).collect::<Vec<_>>().iter());
    for (camera, point, pixel) in pixels() {
        let error = (camera.project(&point).unwrap() - pixel).norm();
        assert!(error <= 1e-9, "{camera:?} at {point:?}: {error:.1e} px from COLMAP");
    }
}

#[test]
fn the_pixels_of_colmap_lead_back_to_their_points() {
    for (camera, point, pixel) in pixels() {
        let ray = camera.unproject(&pixel).unwrap();
        let angle = ray.cross(&point.normalize()).norm();
        assert!(angle <= 1e-10, "{camera:?} at {point:?}: {angle:.1e} rad");
    }
}

#[test]
fn pixels_see_along_the_rays_of_colmap() {
    let (right, _) = rays();
    all_of_colmap(right.iter().map(|row| &row.camera));
    for Ray { camera, pixel, ray, .. } in &right {
        let angle = camera.unproject(pixel).unwrap().cross(ray).norm();
        assert!(angle <= 1e-10, "{camera:?} at {pixel:?}: {angle:.1e} rad from COLMAP");
    }
}

#[test]
fn where_colmap_has_wrong_rays_ours_lead_back_or_are_errors() {
    let (_, wrong) = rays();
    let mut leads_back = 0;
    for row in &wrong {
        assert!(row.error_px() > 1e-2, "{:?} is neither right nor wrong", row.camera);
        match row.camera.unproject(&row.pixel) {
            Ok(ray) => {
                let error = (row.camera.project(&ray).unwrap() - row.pixel).norm();
                assert!(error <= 1e-9, "{:?} at {:?}: {error:.1e} px", row.camera, row.pixel);
                // Its FOV model projects wrongly and unprojects rightly; the fisheyes do the reverse.
                let from_colmap = ray.cross(&row.ray).norm();
                let is_fov = row.camera.model().name == "FOV";
                assert_eq!(from_colmap > 1e-3, !is_fov, "{:?}: {from_colmap}", row.camera);
                leads_back += 1;
            }
            Err(error) => assert!(matches!(error, CameraError::PointOutsideImage { .. })),
        }
    }
    assert!(wrong.len() >= 15 && leads_back >= 10, "{leads_back} of {}", wrong.len());
}

#[test]
fn a_narrow_fov_lens_is_where_its_formula_says_and_not_where_colmap_sees_it() {
    let (_, wrong) = rays();
    let mut count = 0;
    for row in wrong.iter().filter(|row| row.camera.model().name == "FOV") {
        let [fx, fy, cx, cy, omega]: [f64; 5] = row.camera.params().try_into().unwrap();
        // Devernay and Faugeras: atan(2 r tan(omega / 2)) / omega
        let at = row.ray.xy() / row.ray.z;
        let scale = (2.0 * at.norm() * (0.5 * omega).tan()).atan() / omega / at.norm();
        let truth = Vector2::new(fx * at.x * scale + cx, fy * at.y * scale + cy);
        let ours = row.camera.project(&row.ray).unwrap();
        assert!((ours - truth).norm() <= 1e-9, "{omega}: {ours:?} for {truth:?}");
        assert!((row.back - truth).norm() > 1e-2, "{omega}: COLMAP is right by now");
        count += 1;
    }
    assert_eq!(count, 5);
}
