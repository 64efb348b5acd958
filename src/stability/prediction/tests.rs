//! Closed forms; what needs many adjustments is in `tests/prediction_truth.rs`.

use nalgebra::{DMatrix, DVector};

use super::super::refinement::testing::{analysis, covariance, refined};
use super::super::{FindingId, Population};

const VALUES: [[f64; 2]; 3] = [[1001.0, 0.02], [1003.0, 0.03], [1008.0, 0.01]];
const MATRICES: [[[f64; 2]; 2]; 3] =
    [[[4.0, -0.01], [-0.01, 1e-4]], [[9.0, 0.0], [0.0, 1e-4]], [[5.0, -0.02], [-0.02, 1e-4]]];

fn population(times: f64) -> Population {
    let runs = VALUES.into_iter().zip(MATRICES).zip(["a", "b", "c"]);
    let runs = runs.map(|((values, matrix), name)| {
        refined(name, values, covariance(Some(matrix.map(|row| row.map(|v| times * v))), &[]))
    });
    let mut found = analysis(runs.collect());
    assert_eq!(found.findings.iter().any(|one| one.id == FindingId::Birge), times < 0.5);
    found.populations.remove(0)
}

#[test]
fn the_statistic_is_that_of_the_formula() {
    let found = population(1.0).prediction.unwrap().consistency.unwrap();
    let covariances = MATRICES.map(|m| DMatrix::from_fn(2, 2, |row, column| m[row][column]));
    let weights = covariances.map(|c| c.try_inverse().unwrap());
    let values = VALUES.map(|v| DVector::from_column_slice(&v));
    let total: DMatrix<f64> = weights.iter().sum();
    let right: DVector<f64> = weights.iter().zip(&values).map(|(w, v)| w * v).sum();
    let mean = total.clone().lu().solve(&right).unwrap();
    let statistic: f64 = weights
        .iter()
        .zip(&values)
        .map(|(w, v)| ((v - &mean).transpose() * w * (v - &mean))[0])
        .sum();
    assert_eq!((found.n, found.degrees, &*found.parameters.join(" ")), (3, 4, "f k"));
    assert!((found.found.statistic / statistic - 1.0).abs() < 1e-9, "{found:?} {statistic}");
    assert!((found.found.birge - (statistic / 4.0).sqrt()).abs() < 1e-9);
    // chi-square with 4 degrees: sf = (1 + x / 2) exp(-x / 2)
    let p = (1.0 + statistic / 2.0) * (-statistic / 2.0).exp();
    assert!((found.found.p / p - 1.0).abs() < 1e-9, "{found:?} {p}");
    let inverse = total.try_inverse().unwrap();
    for place in 0..2 {
        assert!((found.weighted_mean[place] / mean[place] - 1.0).abs() < 1e-9);
        let std = inverse[(place, place)].sqrt();
        assert!((found.weighted_mean_std[place] / std - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_ratio_scales_with_the_root_of_the_covariance_and_convicts_above_its_limit() {
    let birge = |times: f64| population(times).prediction.unwrap().consistency.unwrap().found.birge;
    assert!((birge(0.01) / birge(1.0) - 10.0).abs() < 1e-9);
    let px = |times: f64| population(times).prediction.unwrap().spread.unwrap().rms_px;
    assert!((px(0.01) / px(1.0) - 0.1).abs() < 1e-9);
}

#[test]
fn the_directions_add_up_to_the_expected_mapping_error() {
    // One run, so that the mean covariance and the mean effect are its own.
    let run = refined("a", VALUES[0], covariance(Some(MATRICES[0]), &[]));
    let found = analysis(vec![run]).populations.remove(0).prediction.unwrap();
    let spread = found.spread.unwrap();
    assert!(spread.observed_ratio.is_none() && found.consistency.is_none());
    let sum: f64 = found.directions.iter().map(|one| one.moves_px.powi(2)).sum();
    assert!((sum.sqrt() / spread.rms_px - 1.0).abs() < 1e-9, "{sum} {spread:?}");
    assert!(found.directions[0].moves_px > found.directions[1].moves_px);
    // Sigma = sum of the changes' outer products.
    for (row, values) in MATRICES[0].iter().enumerate() {
        for (column, want) in values.iter().enumerate() {
            let sum: f64 =
                found.directions.iter().map(|d| d.changes[row] * d.changes[column]).sum();
            assert!((sum - want).abs() < 1e-12, "{row} {column}: {sum} {want}");
        }
    }
}
