//! One draw: what each heuristic chooses from one pool at one size, and what lens its choice gives.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ground::{Ground, Repeat, request};
use super::held_out;
use super::plan::Plan;
use crate::bundle::{self, Options};
use crate::scene::Scene;
use crate::stability::failure_of_sample;

/// A repeat of a model at a size: all heuristics choose from the same pool, and see the same noise.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
pub struct Draw {
    /// The model, by its place among the models.
    pub model: usize,
    /// How many images or frames are chosen.
    pub size: usize,
    /// The repeat, from 0 on.
    pub repeat: usize,
}

/// What came of one choice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Sample {
    /// From what was chosen.
    #[serde(flatten)]
    pub draw: Draw,
    /// By which heuristic.
    pub heuristic: String,
    /// The images chosen, by their places among the model's, ascending.
    pub images: Vec<usize>,
    /// Why there is no calibration.
    pub failure: Option<String>,
    /// The wanted cameras as the images give them; none after a failure.
    pub cameras: Vec<SampledCamera>,
    /// The median distance in px by which points are seen off in the images that were not chosen.
    pub held_out_px: Option<f64>,
}

/// A camera as some images give it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SampledCamera {
    /// Its CAMERA_ID.
    pub camera_id: u32,
    /// All parameters, in file order.
    pub params: Vec<f64>,
}

/// What an adjustment of some images gives.
#[derive(Debug, Clone, Default)]
struct Given {
    failure: Option<String>,
    cameras: Vec<SampledCamera>,
    held_out_px: Option<f64>,
}

/// What each heuristic makes of a draw, in their order.
pub(super) fn samples(ground: &Ground, plan: &Plan, draw: Draw) -> Vec<Sample> {
    let repeat = Repeat::new(plan, draw.model, draw.repeat);
    let pool = ground.pool(plan, &repeat);
    let seen = ground.seen(plan, &repeat);
    // Heuristics that choose the same images get the same lens.
    let mut known: BTreeMap<Vec<usize>, Given> = BTreeMap::new();
    let sample = |heuristic: &&'static super::super::Heuristic| {
        let chosen = pool.clone().and_then(|pool| {
            let request = request(&pool, draw.size, repeat.heuristic_seed, plan);
            heuristic.choose(&ground.candidates, &request)
        });
        let (images, given) = match chosen {
            Ok(choices) => {
                let mut images: Vec<usize> =
                    choices.into_iter().flat_map(|choice| choice.images).collect();
                images.sort_unstable();
                let given = known
                    .entry(images.clone())
                    .or_insert_with(|| give(ground, plan, &seen, &images));
                let given = given.clone();
                (images, given)
            }
            Err(error) => {
                let failure = Some(format!("nothing chosen: {error}"));
                (Vec::new(), Given { failure, ..Given::default() })
            }
        };
        let Given { failure, cameras, held_out_px } = given;
        let heuristic = heuristic.name.to_owned();
        Sample { draw, heuristic, images, failure, cameras, held_out_px }
    };
    plan.heuristics.iter().map(sample).collect()
}

fn give(ground: &Ground, plan: &Plan, seen: &Scene, images: &[usize]) -> Given {
    let failed = |failure: String| Given { failure: Some(failure), ..Given::default() };
    let options = Options { refine: plan.refine.clone(), ..Options::default() };
    let subset = seen.with_images(&ground.ids(images));
    let adjusted = match bundle::adjust(subset, &options, &mut |_| {}) {
        Ok(adjusted) => adjusted,
        Err(error) => return failed(error.to_string()),
    };
    let mut cameras = Vec::with_capacity(ground.wanted.len());
    for &id in &ground.wanted {
        if let Some(failure) = failure_of_sample(&adjusted.outcome, id) {
            return failed(format!("camera {id}: {failure}"));
        }
        let params = adjusted.scene.cameras[&id].intrinsics.params().to_vec();
        cameras.push(SampledCamera { camera_id: id.0, params });
    }
    Given { failure: None, cameras, held_out_px: held_out::median_px(seen, &adjusted.scene) }
}
