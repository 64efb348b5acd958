//! The score test for freeing what was held, and what freeing it does to the lens.

use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::Serialize;

use super::freed::{Freeing, derivatives, freeing};
use crate::bundle::{CameraOutcome, Entry, Observation, Optimum, Outcome, Probe, Widened};
use crate::camera::{Intrinsics, ParamClass};
use crate::scene::{Camera, CameraId};
use crate::stability::spread::{Calibration, Region, View, difference};
use crate::stats::chi_square_tail;

/// Parameters that an adjustment holds together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HeldClass {
    /// The principal point.
    PrincipalPoint,
    /// One focal length for both directions.
    OneFocal,
    /// The first radial term that the model lacks, or that was held.
    NextRadial,
}

impl HeldClass {
    pub(super) const ALL: [Self; 3] = [Self::PrincipalPoint, Self::OneFocal, Self::NextRadial];
}

/// What freeing a class does to one camera of one run; the class is freed in all cameras of the run.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct HeldInRun {
    /// The camera's CAMERA_ID.
    pub camera_id: u32,
    /// What is freed.
    pub class: HeldClass,
    /// The model in which it is free.
    pub model: String,
    /// The parameters that are freed, under their names there.
    pub freed: Vec<String>,
    /// The score test: chi-square with as many degrees as are freed where what was held is right and noise is independent.
    pub statistic: f64,
    /// Its p-value.
    pub p: f64,
    /// How far the lens moves in the image when they are freed: RMS in px over the region, rotation removed. None where the lens
    /// that comes of it has no ray there.
    pub effect_px: Option<f64>,
    /// By how much the focal length changes, as a share of it; of two the mean.
    pub focal_change: Option<f64>,
    /// Whether the run was adjusted again for this; else it is Newton's first step, exact for small changes.
    pub is_readjusted: bool,
    /// What moves, the freed parameters among them.
    pub parameters: Vec<FreedParameter>,
}

/// A parameter before and after freeing others, or itself.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FreedParameter {
    /// Its name in the model in which the class is free.
    pub name: String,
    /// While the class was held.
    pub before: f64,
    /// After it was freed.
    pub after: f64,
}

/// A class of one camera, with its columns in the probe.
pub(super) struct Candidate<'a> {
    pub camera: &'a CameraOutcome,
    pub class: HeldClass,
    pub freeing: Freeing,
    pub freed: Vec<usize>,
}

/// What there is to ask.
pub(super) struct Beside<'a> {
    pub optimum: &'a Optimum,
    pub probe: &'a Probe,
    pub variance: f64,
    pub region: Option<Region>,
    pub view: &'a dyn Fn(CameraId) -> Option<View>,
}

/// All that could be freed, class by class; their columns follow each other.
pub(super) fn candidates<'a>(outcome: &'a Outcome, optimum: &Optimum) -> Vec<Candidate<'a>> {
    let mut all = Vec::new();
    let mut column = 0;
    for class in HeldClass::ALL {
        let cameras = outcome.cameras.iter();
        for camera in cameras.filter(|camera| camera.images > 0 && !camera.free.is_empty()) {
            // Priors and bounds are about parameters of the camera's own model.
            if let Some(freeing) = freeing(camera, class, optimum.is_limited()) {
                let freed: Vec<usize> = (column..column + freeing.freed.len()).collect();
                column += freed.len();
                all.push(Candidate { camera, class, freeing, freed });
            }
        }
    }
    all
}

/// What an observation has in the candidates' columns.
pub(super) fn add_entries(
    candidates: &[Candidate<'_>],
    seen: &Observation,
    entries: &mut Vec<Entry>,
) {
    for one in candidates.iter().filter(|one| one.camera.id == seen.camera) {
        if let Some([x, y]) = derivatives(&one.freeing.contained.intrinsics, &seen.point) {
            let both = one.freed.iter().zip(&one.freeing.freed);
            entries.extend(both.map(|(&column, &place)| (column, [x[place], y[place]])));
        }
    }
}

/// The tests of all candidates.
pub(super) fn tests(candidates: &[Candidate<'_>], beside: &Beside<'_>) -> Vec<HeldInRun> {
    let mut found = Vec::new();
    for class in HeldClass::ALL {
        let of_class: Vec<&Candidate> = candidates.iter().filter(|c| c.class == class).collect();
        found.extend(tests_of_class(&of_class, beside));
    }
    found
}

/// Of one class, freed in all cameras at once; one by one where that leaves something open.
fn tests_of_class(candidates: &[&Candidate<'_>], beside: &Beside<'_>) -> Vec<HeldInRun> {
    if candidates.is_empty() {
        return Vec::new();
    }
    let Some(step) = Step::new(candidates, beside.probe) else {
        let alone = candidates.iter().filter(|_| candidates.len() > 1);
        return alone.flat_map(|one| tests_of_class(&[*one], beside)).collect();
    };
    let stepped: Vec<Option<HeldInRun>> =
        candidates.iter().map(|one| tested(one, &step, beside)).collect();
    let is_worth = |one: &HeldInRun| {
        // Half of what makes a finding: the step may be off by as much.
        one.p < MOST_P && one.effect_px.is_none_or(|px| px > 0.5 * LEAST_EFFECT_PX)
    };
    let mut found: Vec<HeldInRun> = stepped.into_iter().flatten().collect();
    if found.iter().any(is_worth) && !beside.optimum.is_limited() {
        readjust(&mut found, candidates, beside);
    }
    found
}

/// Probability below which what was held is not by chance away from its optimum (DESIGN section 6).
pub(in crate::stability) const MOST_P: f64 = 1e-3;
/// What moves the lens by less in the image makes no finding, however surely it moves it (DESIGN section 6).
pub(in crate::stability) const LEAST_EFFECT_PX: f64 = 0.5;

/// Newton's step for freed parameters.
struct Step {
    columns: Vec<usize>,
    step: DVector<f64>,
    /// For unit noise.
    covariance: DMatrix<f64>,
}

impl Step {
    /// None where what is already free, or the others that are freed, can do the same.
    fn new(candidates: &[&Candidate<'_>], probe: &Probe) -> Option<Self> {
        /// Of a column's square; less is rounding.
        const OPEN: f64 = 1e-10;
        let columns: Vec<usize> =
            candidates.iter().flat_map(|one| one.freed.iter().copied()).collect();
        let scale = |at: usize| 1.0 / probe.own[columns[at]].sqrt();
        let scaled = DMatrix::from_fn(columns.len(), columns.len(), |row, column| {
            scale(row) * scale(column) * probe.information[(columns[row], columns[column])]
        });
        if !scaled.iter().all(|value| value.is_finite()) {
            return None;
        }
        let eigen = scaled.symmetric_eigen();
        if eigen.eigenvalues.min() < OPEN {
            return None;
        }
        let inverse = &eigen.eigenvectors
            * DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| 1.0 / value))
            * eigen.eigenvectors.transpose();
        let covariance = DMatrix::from_fn(columns.len(), columns.len(), |row, column| {
            scale(row) * scale(column) * inverse[(row, column)]
        });
        let score = DVector::from_fn(columns.len(), |at, _| probe.score[columns[at]]);
        let step = -&covariance * score;
        Some(Self { columns, step, covariance })
    }

    /// The statistic of one candidate, whatever the others are, for unit noise: with one camera the score test, with several the
    /// test of its own parameters when all are free.
    fn statistic(&self, one: &Candidate<'_>) -> Option<f64> {
        let own: Vec<usize> = one
            .freed
            .iter()
            .filter_map(|column| self.columns.iter().position(|other| other == column))
            .collect();
        let step = DVector::from_fn(own.len(), |at, _| self.step[own[at]]);
        let covariance = DMatrix::from_fn(own.len(), own.len(), |row, column| {
            self.covariance[(own[row], own[column])]
        });
        Some(step.dot(&covariance.cholesky()?.solve(&step)))
    }

    fn of_column(&self, column: usize) -> f64 {
        let at = self.columns.iter().position(|other| *other == column);
        at.map_or(0.0, |at| self.step[at])
    }
}

/// A candidate after Newton's first step.
fn tested(one: &Candidate<'_>, step: &Step, beside: &Beside<'_>) -> Option<HeldInRun> {
    let statistic = step.statistic(one)? / beside.variance;
    let p = chi_square_tail(statistic, one.freed.len() as f64)?;
    let model = one.freeing.contained.intrinsics.model();
    let mut held = HeldInRun {
        camera_id: one.camera.id.0,
        class: one.class,
        model: model.name.to_owned(),
        freed: one.freeing.freed.iter().map(|&at| model.params[at].name.to_owned()).collect(),
        statistic,
        p,
        effect_px: None,
        focal_change: None,
        is_readjusted: false,
        parameters: Vec::new(),
    };
    fill(&mut held, one, &stepped(one, step, beside)?, beside);
    Some(held)
}

/// The lens after Newton's first step; none when it is beyond doubles.
fn stepped(one: &Candidate<'_>, step: &Step, beside: &Beside<'_>) -> Option<Intrinsics> {
    let Freeing { contained, freed } = &one.freeing;
    let follows = |place: usize| {
        let mut free = beside.optimum.free().iter();
        let row = free.position(|it| it.camera == one.camera.id && it.place == place)?;
        let along = step.columns.iter().zip(&step.step);
        Some(along.map(|(&column, by)| beside.probe.following[(row, column)] * by).sum::<f64>())
    };
    let mut params = contained.intrinsics.params().to_vec();
    for (param, origin) in params.iter_mut().zip(&contained.origins) {
        *param += origin.and_then(follows).unwrap_or(0.0);
    }
    for (&place, &column) in freed.iter().zip(&one.freed) {
        params[place] += step.of_column(column);
    }
    contained.intrinsics.model().with_params(&params).ok()
}

/// Puts what the lens has become into the test.
fn fill(held: &mut HeldInRun, one: &Candidate<'_>, after: &Intrinsics, beside: &Beside<'_>) {
    let before = one.freeing.contained.intrinsics;
    let model = before.model();
    let moving = free_places(one);
    held.parameters = moving
        .iter()
        .map(|&at| FreedParameter {
            name: model.params[at].name.to_owned(),
            before: before.params()[at],
            after: after.params()[at],
        })
        .collect();
    let changes: Vec<f64> = moving
        .iter()
        .filter(|&&at| model.params[at].class == ParamClass::Focal)
        .map(|&at| after.params()[at] / before.params()[at] - 1.0)
        .collect();
    let count = changes.len() as f64;
    held.focal_change = (count > 0.0).then(|| changes.iter().sum::<f64>() / count);
    let view = (beside.view)(one.camera.id);
    let calibration = |camera| Calibration {
        run: "",
        camera_id: one.camera.id.0,
        camera,
        is_flagged: false,
        view: view.clone(),
    };
    let (from, to) = (Camera { intrinsics: before, ..one.camera.after }, one.camera.after);
    let to = Camera { intrinsics: *after, ..to };
    let moved = difference(&calibration(&from), &calibration(&to), beside.region);
    held.effect_px = moved.ok().map(|moved| moved.rotated.rms_px);
}

/// What moves when the class is free, as places in the wider model.
fn free_places(one: &Candidate<'_>) -> Vec<usize> {
    let Freeing { contained, freed } = &one.freeing;
    let origins = contained.origins.iter().enumerate();
    let moves = |(at, origin): (usize, &Option<usize>)| {
        let moved = origin.is_some_and(|origin| one.camera.free.contains(&origin));
        (moved || freed.contains(&at)).then_some(at)
    };
    origins.filter_map(moves).collect()
}

/// Adjusts the run again with the class free in all cameras; where that fails, the step stays.
fn readjust(found: &mut [HeldInRun], candidates: &[&Candidate<'_>], beside: &Beside<'_>) {
    let widened: Vec<Widened> = candidates
        .iter()
        .map(|one| Widened {
            camera: one.camera.id,
            intrinsics: one.freeing.contained.intrinsics,
            free: free_places(one),
        })
        .collect();
    let Ok(Some(lenses)) = beside.optimum.readjusted(&widened) else { return };
    for (camera, lens) in lenses {
        let one = candidates.iter().find(|one| one.camera.id == camera);
        let held = found.iter_mut().find(|held| held.camera_id == camera.0);
        if let Some((one, held)) = one.zip(held) {
            fill(held, one, &lens, beside);
            held.is_readjusted = true;
        }
    }
}
