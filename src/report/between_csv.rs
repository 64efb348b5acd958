//! How groups compare, as tidy CSV.

use serde::Serialize;

use super::csv::table;
use crate::stability::{
    Analysis, Components, GroupComparison, PairTest, TestMethod, VarianceComponents,
};

/// A test of two groups, one a row.
#[derive(Serialize)]
struct TestRow<'a> {
    camera: &'a str,
    width: u64,
    height: u64,
    of: &'a str,
    group_more: &'a str,
    model_more: &'a str,
    n_more: usize,
    std_more: f64,
    group_less: &'a str,
    model_less: &'a str,
    n_less: usize,
    std_less: f64,
    ratio: f64,
    method: TestMethod,
    f: f64,
    degrees_above: f64,
    degrees_below: f64,
    p: f64,
    p_holm: f64,
    power_at_2: f64,
    n_for_2: Option<usize>,
    n_for_ratio: Option<usize>,
}

/// Components of the variance of a parameter or of the pixels, one a row.
#[derive(Serialize)]
struct ComponentsRow<'a> {
    parent: &'a str,
    camera: &'a str,
    model: &'a str,
    width: u64,
    height: u64,
    of: &'a str,
    group_count: usize,
    sample_count: usize,
    repeatability_std: f64,
    repeatability_low_95: f64,
    repeatability_high_95: f64,
    between_std: f64,
    between_low_95: f64,
    between_high_95: f64,
    between_variance: f64,
    reproducibility_std: f64,
    reproducibility_low_95: f64,
    reproducibility_high_95: f64,
    repeatability_limit: f64,
    reproducibility_limit: f64,
    f: f64,
    degrees_above: f64,
    degrees_below: f64,
    p: f64,
}

/// What stands for a parameter's name where a row is about the pixels.
const IMAGE: &str = "image px";
/// The pixels without aligning rotations.
const RAW_IMAGE: &str = "raw image px";

/// Every test of two groups, one a row.
pub fn comparisons_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(analysis.comparisons.iter().flat_map(|one| {
        let spreads = one.spreads.iter().map(|test| (IMAGE, test));
        let parameters = one.parameters.iter().map(|one| (one.parameter.as_str(), &one.test));
        spreads.chain(parameters).map(|(of, test)| test_row(one, of, test))
    }))
}

/// Components of variance, one parameter a row; the pixels' in px.
pub fn components_csv(analysis: &Analysis) -> csv::Result<Vec<u8>> {
    table(analysis.components.iter().flat_map(|one| {
        let image = one.image.iter().flat_map(|image| {
            image.aligned.iter().map(|found| (IMAGE, found)).chain([(RAW_IMAGE, &image.raw)])
        });
        let parameters = one.parameters.iter().map(|p| (p.parameter.as_str(), &p.components));
        image.chain(parameters).map(|(of, found)| components_row(one, of, found))
    }))
}

fn test_row<'a>(one: &'a GroupComparison, of: &'a str, test: &'a PairTest) -> TestRow<'a> {
    TestRow {
        camera: &one.camera,
        width: one.width,
        height: one.height,
        of,
        group_more: &test.groups[0],
        model_more: &test.models[0],
        n_more: test.n[0],
        std_more: test.std[0],
        group_less: &test.groups[1],
        model_less: &test.models[1],
        n_less: test.n[1],
        std_less: test.std[1],
        ratio: test.ratio,
        method: test.method,
        f: test.f,
        degrees_above: test.degrees[0],
        degrees_below: test.degrees[1],
        p: test.p,
        p_holm: test.p_holm,
        power_at_2: test.power_at_2,
        n_for_2: test.n_for_2,
        n_for_ratio: test.n_for_ratio,
    }
}

fn components_row<'a>(
    one: &'a Components,
    of: &'a str,
    found: &VarianceComponents,
) -> ComponentsRow<'a> {
    ComponentsRow {
        parent: &one.parent,
        camera: &one.camera,
        model: &one.model,
        width: one.width,
        height: one.height,
        of,
        group_count: found.n.iter().filter(|n| **n > 0).count(),
        sample_count: found.n.iter().sum(),
        repeatability_std: found.repeatability_std,
        repeatability_low_95: found.repeatability_interval_95[0],
        repeatability_high_95: found.repeatability_interval_95[1],
        between_std: found.between_std,
        between_low_95: found.between_interval_95[0],
        between_high_95: found.between_interval_95[1],
        between_variance: found.between_variance,
        reproducibility_std: found.reproducibility_std,
        reproducibility_low_95: found.reproducibility_interval_95[0],
        reproducibility_high_95: found.reproducibility_interval_95[1],
        repeatability_limit: found.repeatability_limit,
        reproducibility_limit: found.reproducibility_limit,
        f: found.f,
        degrees_above: found.degrees[0],
        degrees_below: found.degrees[1],
        p: found.p,
    }
}
