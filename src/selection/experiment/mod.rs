//! Which heuristic chooses the images that calibrate best, by experiment: choose, adjust, compare, again and again.
//!
//! All heuristics choose from the same pools and see the same noise. A heuristic that chooses the same images again and again
//! looks stable for that reason alone: so each repeat draws the noise of all pixels anew, and what is told is the error and not
//! the spread alone. Knows nothing of files or threads.

mod ground;
mod held_out;
mod plan;
mod ranking;
mod result;
mod sample;
mod score;
#[cfg(test)]
mod tests;

pub use ground::{GroundError, Input};
pub use plan::{Noise, Plan, Pool};
pub use result::*;
pub use sample::{Draw, Sample, SampledCamera};

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::Unit;
use crate::stability::InputFile;
use ground::Ground;
use ranking::Errors;

/// Version of the format of `selection.json`.
const SCHEMA_VERSION: u32 = 1;

/// An experiment on some models.
#[derive(Debug, Clone)]
pub struct Experiment {
    plan: Plan,
    grounds: Vec<Ground>,
}

impl Experiment {
    /// Refines each model in full, and takes that for what subsets of it are compared with. An error comes with its model's name.
    pub fn new(plan: Plan, models: Vec<Input>) -> Result<Self, (String, GroundError)> {
        let ground = |input: Input| {
            let name = input.name.clone();
            Ground::new(input, &plan).map_err(|error| (name, error))
        };
        let grounds = models.into_iter().map(ground).collect::<Result<_, _>>()?;
        Ok(Self { plan, grounds })
    }

    /// All that there is to do, in order.
    pub fn draws(&self) -> Vec<Draw> {
        let of_model = |(model, ground): (usize, &Ground)| {
            let sizes = self.sizes(ground);
            let of_size =
                move |size| (0..self.plan.repeats).map(move |repeat| Draw { model, size, repeat });
            sizes.into_iter().flat_map(of_size)
        };
        self.grounds.iter().enumerate().flat_map(of_model).collect()
    }

    /// Does one of them: a sample for each heuristic.
    pub fn run(&self, draw: Draw) -> Vec<Sample> {
        sample::samples(&self.grounds[draw.model], &self.plan, draw)
    }

    fn sizes(&self, ground: &Ground) -> Vec<usize> {
        let most = self.plan.pool.size(ground.unit_count);
        self.plan.sizes.iter().copied().filter(|&size| size <= most).collect()
    }

    /// What all samples show, in whatever order they come.
    pub fn result(&self, mut samples: Vec<Sample>, told: Told) -> Selection {
        let order: Vec<&str> = self.plan.heuristics.iter().map(|it| it.name).collect();
        let place = |sample: &Sample| order.iter().position(|name| *name == sample.heuristic);
        samples.sort_by_cached_key(|it| (it.draw.model, it.draw.size, place(it), it.draw.repeat));
        let is_independent = self.plan.noise == Noise::Redraw;
        let is_same = |a: &Sample, b: &Sample| {
            (a.draw.model, a.draw.size, &a.heuristic) == (b.draw.model, b.draw.size, &b.heuristic)
        };
        let groups: Vec<&[Sample]> = samples.chunk_by(is_same).collect();
        let scored: Vec<(Vec<ScoredSample>, Cell)> = groups
            .into_par_iter()
            .map(|group| score::scored(&self.grounds[group[0].draw.model], group, is_independent))
            .collect();
        let (samples, cells): (Vec<_>, Vec<_>) = scored.into_iter().unzip();
        let samples: Vec<ScoredSample> = samples.into_iter().flatten().collect();
        let names: Vec<String> = order.into_iter().map(str::to_owned).collect();
        let errors = Errors::new(&samples, names.clone(), is_independent);
        let rankings = errors.rankings();
        Selection {
            schema_version: SCHEMA_VERSION,
            calibstab_version: env!("CARGO_PKG_VERSION").to_owned(),
            options: self.options(told),
            models: self.grounds.iter().map(|ground| self.record(ground)).collect(),
            remarks: self.remarks(&cells),
            agreement: errors.agreement(&rankings),
            rankings,
            targets: self
                .plan
                .target_px
                .map_or_else(Vec::new, |target_px| ranking::targets(&cells, &names, target_px)),
            cells,
            samples,
        }
    }

    /// A line that differs for experiments that are not the same: what was asked for, and of which files.
    pub fn fingerprint(&self, told: &Told) -> String {
        let files: Vec<&[InputFile]> = self.grounds.iter().map(|it| &*it.files).collect();
        let version = env!("CARGO_PKG_VERSION");
        serde_json::json!([version, self.options(told.clone()), files]).to_string()
    }

    /// What was asked for.
    fn options(&self, told: Told) -> SelectionOptions {
        let Plan { heuristics, sizes, repeats, seed, pool, noise, unit, camera, target_px, .. } =
            &self.plan;
        let unit = match unit {
            Unit::Image => "image",
            Unit::Frame => "frame",
        };
        SelectionOptions {
            heuristics: heuristics
                .iter()
                .map(|it| (it.name.to_owned(), it.summary.to_owned()))
                .collect(),
            sizes: sizes.clone(),
            repeats: *repeats,
            seed: *seed,
            pool: pool.to_string(),
            noise: noise.to_string(),
            unit: unit.to_owned(),
            camera: camera.map(|camera| camera.0),
            refine: told.refine,
            target_px: *target_px,
            truth: told.truth,
        }
    }

    fn record(&self, ground: &Ground) -> ModelRecord {
        let all = 0..ground.candidates.image_count();
        let camera = |id: &crate::scene::CameraId| {
            let camera = &ground.refined[id];
            let model = camera.intrinsics.model();
            let free = ground.candidates.params().iter().filter(|param| param.camera == *id);
            CameraRecord {
                camera_id: id.0,
                model: model.name.to_owned(),
                width: camera.width,
                height: camera.height,
                parameters: model.params.iter().map(|param| param.name.to_owned()).collect(),
                refined: camera.intrinsics.params().to_vec(),
                free: free.map(|param| param.place).collect(),
                parts: score::parts_of(camera),
            }
        };
        ModelRecord {
            name: ground.name.clone(),
            files: ground.files.clone(),
            images: all.clone().map(|at| ground.candidates.name(at).to_owned()).collect(),
            image_cameras: all.clone().map(|at| ground.candidates.camera(at).0).collect(),
            map: map(&all.map(|at| ground.candidates.centre(at)).collect::<Vec<_>>()),
            cameras: ground.wanted.iter().map(camera).collect(),
            sigma_px: ground.sigma_px,
            unit_count: ground.unit_count,
            pool_size: self.plan.pool.size(ground.unit_count),
            sizes: self.sizes(ground),
        }
    }

    fn remarks(&self, cells: &[Cell]) -> Vec<String> {
        let mut remarks = self.skipped();
        if self.plan.noise == Noise::Keep {
            remarks.push("all repeats share the noise that was measured: one that chooses the same images again looks stable, and only three models or more, with noise of their own, tell whether a difference is certain".to_owned());
        }
        let failures: usize = cells.iter().map(|cell| cell.failures).sum();
        if failures > 0 {
            let all: usize = cells.iter().map(|cell| cell.failures + cell.n).sum();
            remarks.push(format!("{failures} of {all} choices gave no calibration"));
        }
        remarks
    }

    /// The sizes that are larger than a pool, and so not tried.
    pub fn skipped(&self) -> Vec<String> {
        let of_ground = |ground: &Ground| {
            let most = self.plan.pool.size(ground.unit_count);
            let larger: Vec<String> =
                self.plan.sizes.iter().filter(|&&size| size > most).map(usize::to_string).collect();
            (!larger.is_empty()).then(|| {
                let sizes = larger.join(", ");
                format!("{}: a pool has {most}: nothing was tried at size {sizes}", ground.name)
            })
        };
        self.grounds.iter().filter_map(of_ground).collect()
    }
}

/// Places along the two directions in which they differ most.
fn map(places: &[Vector3<f64>]) -> Vec<[f64; 2]> {
    let mean = places.iter().sum::<Vector3<f64>>() / places.len().max(1) as f64;
    let scatter: Matrix3<f64> =
        places.iter().map(|place| (place - mean) * (place - mean).transpose()).sum();
    let eigen = scatter.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a: &usize, &b: &usize| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let axis = |at: usize| {
        let axis = eigen.eigenvectors.column(order[at]).into_owned();
        // Of an axis and its opposite, the one whose largest part is positive.
        axis * axis[axis.iamax()].signum()
    };
    let axes = [axis(0), axis(1)];
    places.iter().map(|place| axes.map(|axis| axis.dot(&(place - mean)))).collect()
}

/// What a record tells that an experiment has in another form.
#[derive(Debug, Clone, Default)]
pub struct Told {
    /// Which intrinsics move, in words.
    pub refine: Vec<String>,
    /// Where the truth is from.
    pub truth: Option<InputFile>,
}
