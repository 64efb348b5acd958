//! Components of variance of runs in groups that repeat each other: how much comes from the groups (the matching, the session),
//! how much from the repeats within. The names are those of ISO 5725-2.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::deviations::{self, cameras};
use super::{Population, SampleState};
use crate::stats::{OneWay, one_way};

/// Two results differ by more than this many std in one case of twenty: sqrt(2) times 1.96, as ISO 5725-6 rounds it.
const LIMIT: f64 = 2.8;

/// The components of variance of one camera under one model, over groups that repeat one experiment.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Components {
    /// The physical camera.
    pub camera: String,
    /// Its camera model.
    pub model: String,
    /// Width of its images, in px.
    pub width: u64,
    /// Height of its images, in px.
    pub height: u64,
    /// What the names of the groups have in common, up to a slash; empty when nothing.
    pub parent: String,
    /// The groups.
    pub groups: Vec<String>,
    /// Of the pixels that a ray meets, over the whole image, in px: deviations in x and y from the mean ray of all runs, as they
    /// are. None when no part of the image is seen in all runs.
    pub image: Option<ImageComponents>,
    /// Of every parameter that was estimated in two groups, and in one of them at least twice.
    pub parameters: Vec<ParameterComponents>,
}

/// The components of the variance of a camera's pixels.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ImageComponents {
    /// Share of the image that is seen in all runs.
    pub image_share: f64,
    /// In px: root of the mean square over these cells.
    pub components: VarianceComponents,
}

/// The components of one parameter's variance.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ParameterComponents {
    /// Its name.
    pub parameter: String,
    /// The unit of its values, such as `px`; empty where they have none.
    pub unit: String,
    /// In that unit.
    pub components: VarianceComponents,
}

/// How far repeats vary within a group, and how far the groups do. Estimates by analysis of variance (Searle, Casella and
/// McCulloch 1992), intervals by the modified large sample method (Burdick and Graybill 1992); both hold for normal samples
/// and groups drawn at random from many.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct VarianceComponents {
    /// How many samples each group has.
    pub n: Vec<usize>,
    /// Std among repeats within a group: the repeatability standard deviation, s_r.
    pub repeatability_std: f64,
    /// 95 % confidence interval of it.
    pub repeatability_interval_95: [f64; 2],
    /// Std among the groups' true means, s_L: zero when the groups differ no more than their repeats explain.
    pub between_std: f64,
    /// 95 % confidence interval of it.
    pub between_interval_95: [f64; 2],
    /// The estimate of its square as it came out: below zero when chance put the groups closer together than repeats allow.
    pub between_variance: f64,
    /// Std among repeats in a new group each: the reproducibility standard deviation, s_R = sqrt(s_r^2 + s_L^2).
    pub reproducibility_std: f64,
    /// 95 % confidence interval of it.
    pub reproducibility_interval_95: [f64; 2],
    /// Two runs of one group differ by more in one case of twenty: 2.8 s_r.
    pub repeatability_limit: f64,
    /// Two runs of different groups differ by more in one case of twenty: 2.8 s_R.
    pub reproducibility_limit: f64,
    /// The mean square between the groups over that within.
    pub f: f64,
    /// Degrees of freedom of f, numerator first. For pixels times the independent columns of their deviations (Box 1954).
    pub degrees: [f64; 2],
    /// How often so large an f comes from groups that do not differ.
    pub p: f64,
}

impl From<(Vec<usize>, OneWay)> for VarianceComponents {
    fn from((n, found): (Vec<usize>, OneWay)) -> Self {
        let (within, total) = (found.within.sqrt(), found.total.sqrt());
        let roots = |interval: [f64; 2]| interval.map(f64::sqrt);
        Self {
            n,
            repeatability_std: within,
            repeatability_interval_95: roots(found.within_interval),
            between_std: found.between.max(0.0).sqrt(),
            between_interval_95: roots(found.between_interval),
            between_variance: found.between,
            reproducibility_std: total,
            reproducibility_interval_95: roots(found.total_interval),
            repeatability_limit: LIMIT * within,
            reproducibility_limit: LIMIT * total,
            f: found.f,
            degrees: found.degrees,
            p: found.p,
        }
    }
}

/// The components of every camera that groups of one parent have under one model.
pub(super) fn components(populations: &[Population]) -> Vec<Components> {
    let mut families: BTreeMap<(&str, &str, [u64; 2]), Vec<&Population>> = BTreeMap::new();
    for one in populations {
        let size = [one.width, one.height];
        families.entry((&one.camera, &one.model, size)).or_default().push(one);
    }
    let mut all: Vec<Components> =
        families.values().flat_map(|family| by_parent(family)).filter_map(of_family).collect();
    all.sort_by(|a, b| {
        natord::compare(&a.camera, &b.camera).then(natord::compare(&a.parent, &b.parent))
    });
    all
}

/// Populations by the longest path that the group of each shares with another one.
fn by_parent<'a>(
    family: &[&'a Population],
) -> impl Iterator<Item = (String, Vec<&'a Population>)> + use<'a> {
    let mut parents: BTreeMap<String, Vec<&Population>> = BTreeMap::new();
    for (index, one) in family.iter().enumerate() {
        let others = family.iter().enumerate().filter(|(other, _)| *other != index);
        let shared = others.map(|(_, other)| shared_path(&one.group, &other.group));
        if let Some(parent) = shared.max_by_key(|path| path.len()) {
            parents.entry(parent.to_owned()).or_default().push(one);
        }
    }
    parents.into_iter()
}

/// The path that two names have in common, in whole parts.
fn shared_path<'a>(one: &'a str, other: &str) -> &'a str {
    let parts = one.split('/').zip(other.split('/')).take_while(|(a, b)| a == b);
    let length: usize = parts.map(|(part, _)| part.len() + 1).sum();
    &one[..length.saturating_sub(1).min(one.len())]
}

fn of_family((parent, family): (String, Vec<&Population>)) -> Option<Components> {
    let first = *family.first().filter(|_| family.len() > 1)?;
    let parameters: Vec<ParameterComponents> =
        (0..first.parameters.len()).filter_map(|index| of_parameter(&family, index)).collect();
    if parameters.is_empty() {
        return None;
    }
    Some(Components {
        camera: first.camera.clone(),
        model: first.model.clone(),
        width: first.width,
        height: first.height,
        parent,
        groups: family.iter().map(|one| one.group.clone()).collect(),
        image: of_image(&family),
        parameters,
    })
}

fn of_parameter(family: &[&Population], index: usize) -> Option<ParameterComponents> {
    let estimated = |population: &&Population| -> Vec<f64> {
        let samples = population.parameters[index].samples.iter();
        // A group of one run cannot tell that its value was estimated; the other groups do.
        let is_estimate = |state| matches!(state, SampleState::Estimated | SampleState::Unknown);
        samples
            .filter(|sample| is_estimate(sample.state))
            .filter_map(|sample| sample.value)
            .collect()
    };
    let values: Vec<Vec<f64>> = family.iter().map(estimated).collect();
    let n = values.iter().map(Vec::len).collect();
    let groups = values.into_iter().filter(|group| !group.is_empty());
    let rows = groups.map(|group| group.into_iter().map(|value| vec![value]).collect()).collect();
    let parameter = &family[0].parameters[index];
    Some(ParameterComponents {
        parameter: parameter.name.clone(),
        unit: parameter.unit.clone(),
        components: (n, one_way(rows)?).into(),
    })
}

fn of_image(family: &[&Population]) -> Option<ImageComponents> {
    let groups: Vec<_> = family.iter().map(|one| cameras(one)).collect();
    let n = groups.iter().map(Vec::len).collect();
    let seen = deviations::together(&groups, [family[0].width, family[0].height])?;
    let rows = seen.rows.into_iter().filter(|group| !group.is_empty()).collect();
    Some(ImageComponents { image_share: seen.image_share, components: (n, one_way(rows)?).into() })
}
