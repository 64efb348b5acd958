//! One draw: what each heuristic chooses from one pool at one size, and what lens its choice gives.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ground::{Ground, Repeat, request};
use super::held_out;
use super::plan::Plan;
use crate::bundle::{BundleError, Sight};
use crate::camera::Intrinsics;
use crate::scene::CameraId;
use crate::stability;

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
    let (pixels, start) = ground.seen(plan, &repeat);
    let sight = ground.subsets.seen(&pixels, &start);
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
                let given =
                    known.entry(images.clone()).or_insert_with(|| give(ground, &sight, &images));
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

fn give(ground: &Ground, sight: &Result<Sight<'_>, BundleError>, images: &[usize]) -> Given {
    let refit = |sight: &Sight<'_>| {
        let refit = sight.adjust(&ground.ids(images)).map_err(|error| error.to_string())?;
        let open = refit.open();
        let failure = |&id: &CameraId| {
            Some(format!("camera {id}: {}", stability::failure_of_refit(&refit, &open, id)?))
        };
        match ground.wanted.iter().find_map(failure) {
            Some(failure) => Err(failure),
            None => Ok((held_out::median_px(sight, &refit), refit.intrinsics)),
        }
    };
    match sight.as_ref().map_err(BundleError::to_string).and_then(refit) {
        Err(failure) => Given { failure: Some(failure), ..Given::default() },
        Ok((held_out_px, intrinsics)) => {
            let is_wanted = |(id, _): &&(CameraId, Intrinsics)| ground.wanted.contains(id);
            let camera = |(id, lens): &(CameraId, Intrinsics)| SampledCamera {
                camera_id: id.0,
                params: lens.params().to_vec(),
            };
            let cameras = intrinsics.iter().filter(is_wanted).map(camera).collect();
            Given { failure: None, cameras, held_out_px }
        }
    }
}
