//! Pixels as pycolmap 4.2.1 sees them: laws cannot find a mistake that formula and derivative share.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::collections::BTreeSet;

use calibstab::camera::{Intrinsics, MODELS, Model};
use nalgebra::{Vector2, Vector3};

struct Row {
    camera: Intrinsics,
    point: Vector3<f64>,
    pixel: Vector2<f64>,
}

fn golden() -> Vec<Row> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/golden_pixels.csv");
    let mut rows = csv::Reader::from_path(path).unwrap();
    let row = |record: csv::StringRecord| {
        let params: Vec<f64> = record[1].split(' ').map(|value| value.parse().unwrap()).collect();
        let number = |column: usize| record[column].parse::<f64>().unwrap();
        Row {
            camera: Model::named(&record[0]).unwrap().with_params(&params).unwrap(),
            point: Vector3::new(number(2), number(3), number(4)),
            pixel: Vector2::new(number(5), number(6)),
        }
    };
    rows.records().map(|record| row(record.unwrap())).collect()
}

#[test]
fn points_are_seen_where_colmap_sees_them() {
    let rows = golden();
    let models: BTreeSet<&str> = rows.iter().map(|row| row.camera.model().name).collect();
    let of_colmap = MODELS.iter().filter(|model| model.colmap_id.is_some()).count();
    assert_eq!(models.len(), of_colmap);
    for Row { camera, point, pixel } in &rows {
        let error = (camera.project(point).unwrap() - pixel).norm();
        assert!(error <= 1e-9, "{camera:?} at {point:?}: {error:.1e} px from COLMAP");
    }
}

#[test]
fn the_pixels_of_colmap_lead_back_to_their_points() {
    for Row { camera, point, pixel } in golden() {
        let ray = camera.unproject(&pixel).unwrap();
        let angle = ray.cross(&point.normalize()).norm();
        assert!(angle <= 1e-10, "{camera:?} at {point:?}: {angle:.1e} rad");
    }
}
