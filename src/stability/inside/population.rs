//! What the runs of a population say together of what was held.

use schemars::JsonSchema;
use serde::Serialize;

use super::held::{FreedParameter, HeldClass, HeldInRun};
use crate::stability::Run;
use crate::stability::run::CameraInRun;
use crate::stats::Sorted;

/// What freeing a class does to a camera, over its runs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct HeldTest {
    /// What is freed.
    pub class: HeldClass,
    /// The parameters that are freed, under their names in the model in which they are free.
    pub freed: Vec<String>,
    /// That model.
    pub model: String,
    /// How many runs were tested.
    pub n: usize,
    /// Twice the median of the runs' p-values: a p-value however much the runs share (Rueschendorf 1982).
    pub p: f64,
    /// Median over the runs of how far the lens moves in the image, in px; none where half of the runs have none.
    pub effect_px: Option<f64>,
    /// Median change of the focal length, as a share of it.
    pub focal_change: Option<f64>,
    /// What moves: medians over the runs.
    pub parameters: Vec<FreedParameter>,
    /// What each run says.
    pub runs: Vec<RunHeld>,
}

/// What one run says of freeing a class.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RunHeld {
    /// The run.
    pub run: String,
    /// Its test.
    #[serde(flatten)]
    pub test: HeldInRun,
}

/// One test a class that could be tested in some run.
pub(in crate::stability) fn held_tests(sampled: &[(&Run, &CameraInRun)]) -> Vec<HeldTest> {
    HeldClass::ALL.into_iter().filter_map(|class| held_test(sampled, class)).collect()
}

fn held_test(sampled: &[(&Run, &CameraInRun)], class: HeldClass) -> Option<HeldTest> {
    let of_run = |(run, camera): &(&Run, &CameraInRun)| {
        let mut held = run.inside.as_ref()?.held.iter();
        let test = held.find(|held| held.class == class && held.camera_id == camera.id.0)?;
        Some(RunHeld { run: run.name.clone(), test: test.clone() })
    };
    let runs: Vec<RunHeld> = sampled.iter().filter_map(of_run).collect();
    let first = runs.first()?.test.clone();
    // Of runs that held other parameters each speaks for itself.
    let runs: Vec<RunHeld> = runs
        .into_iter()
        .filter(|one| one.test.freed == first.freed && one.test.model == first.model)
        .collect();
    let median = |of: &dyn Fn(&HeldInRun) -> Option<f64>| {
        let values: Vec<f64> = runs.iter().filter_map(|one| of(&one.test)).collect();
        let is_most = 2 * values.len() > runs.len();
        median_of(values).filter(|_| is_most)
    };
    let parameter = |at: usize, name: &str| {
        let is_it = |held: &HeldInRun| held.parameters.get(at).filter(|p| p.name == name).cloned();
        Some(FreedParameter {
            name: name.to_owned(),
            before: median(&|held| Some(is_it(held)?.before))?,
            after: median(&|held| Some(is_it(held)?.after))?,
        })
    };
    Some(HeldTest {
        class,
        freed: first.freed.clone(),
        model: first.model.clone(),
        n: runs.len(),
        p: together(runs.iter().map(|one| one.test.p).collect()).unwrap_or(1.0),
        effect_px: median(&|held| held.effect_px),
        focal_change: median(&|held| held.focal_change),
        parameters: first
            .parameters
            .iter()
            .enumerate()
            .filter_map(|(at, one)| parameter(at, &one.name))
            .collect(),
        runs,
    })
}

/// The median; none of nothing.
pub(super) fn median_of(values: Vec<f64>) -> Option<f64> {
    Sorted::new(values).map(|sorted| sorted.median())
}

/// A p-value that all of these make, however they depend on each other: twice their median (Rueschendorf 1982).
pub(super) fn together(p: Vec<f64>) -> Option<f64> {
    median_of(p).map(|p| (2.0 * p).min(1.0))
}
