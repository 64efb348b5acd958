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
    /// Of the pixels that a ray meets, over the whole image. None when no part of it is seen in all runs.
    pub image: Option<ImageComponents>,
    /// Of every parameter that was estimated in two groups, and in one of them at least twice.
    pub parameters: Vec<ParameterComponents>,
}

/// The components of the variance of a camera's pixels.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ImageComponents {
    /// Share of the image that is seen in all runs.
    pub image_share: f64,
    /// In px: root of the mean square over these cells of the deviations, x and y, from the mean ray of all runs.
    pub raw: VarianceComponents,
    /// The same after all runs were rotated onto each other, as poses absorb a rotation. None where that search failed.
    pub aligned: Option<VarianceComponents>,
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
    let n: Vec<usize> = groups.iter().map(Vec::len).collect();
    let seen = deviations::together(&groups, [family[0].width, family[0].height])?;
    let components = |rows: Vec<Vec<Vec<f64>>>| {
        let present = rows.into_iter().filter(|group| !group.is_empty()).collect();
        Some(VarianceComponents::from((n.clone(), one_way(present)?)))
    };
    Some(ImageComponents {
        image_share: seen.image_share,
        raw: components(seen.raw)?,
        aligned: seen.aligned.and_then(components),
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{run, simple_radial};
    use super::super::{Analysis, Options, Run, analyze};
    use super::*;

    fn analysis(runs: Vec<Run>) -> Analysis {
        analyze(runs, vec![], Options::default()).unwrap()
    }

    /// Runs of one SIMPLE_PINHOLE camera, principal point free.
    fn pinholes(group: &str, values: &[[f64; 3]]) -> Vec<Run> {
        let named = (1..).zip(values);
        let run = |(i, values): (i32, &[f64; 3])| {
            run(group, &format!("run{i}"), &[(1, "SIMPLE_PINHOLE", values)])
        };
        named.map(run).collect()
    }

    /// Six repeats that vary by an RMS of about a pixel, moved as a whole.
    fn repeats(group: &str, df: f64, dx: f64) -> Vec<Run> {
        let noise = [
            [-1.0, 0.5, 0.3],
            [0.5, -1.2, 0.9],
            [1.5, 0.8, -1.05],
            [-0.65, -0.55, 0.2],
            [0.4, 1.1, 0.8],
            [-0.75, -0.65, -1.15],
        ];
        let moved = noise.map(|[f, x, y]| [1000.0 + df + f, 640.5 + dx + x, 480.5 + y]);
        pinholes(group, &moved)
    }

    fn found<'a>(components: &'a Components, name: &str) -> &'a VarianceComponents {
        &components.parameters.iter().find(|one| one.parameter == name).unwrap().components
    }

    #[test]
    fn a_shift_of_a_group_is_found_in_the_parameter_and_in_pixels() {
        let runs = ["a", "b", "c"].iter().zip([0.0, 30.0, -30.0]);
        let analysis = analysis(runs.flat_map(|(group, dx)| repeats(group, 0.0, dx)).collect());
        let [components] = &analysis.components[..] else { panic!("one camera") };
        assert_eq!(components.groups, ["a", "b", "c"]);
        // Means 0 and +-30 have a std of 30; that of repeats takes a little away.
        let cx = found(components, "cx");
        let repeatability = cx.repeatability_std;
        assert!((cx.between_std.powi(2) - (900.0 - repeatability.powi(2) / 6.0)).abs() < 1e-9);
        assert!(cx.p < 1e-6 && cx.between_interval_95[0] > 10.0);
        // cy was not moved: its groups are closer together than repeats allow.
        let cy = found(components, "cy");
        assert!(cy.between_std <= 0.0 && cy.between_variance < 0.0 && cy.p > 0.99);
        assert!((cy.reproducibility_std - cy.repeatability_std).abs() < 1e-12);
        assert!((cx.reproducibility_limit - 2.8 * cx.reproducibility_std).abs() < 1e-12);
        // A moved principal point moves every pixel by as much.
        let image = &components.image.as_ref().unwrap().raw;
        assert!((image.between_std - 30.0).abs() < 0.1, "{}", image.between_std);
        assert!(image.p < 1e-6);
        let sum = cx.repeatability_std.hypot(cy.repeatability_std);
        assert!(image.repeatability_std > sum, "the focal length adds to {sum}");
    }

    #[test]
    fn equal_groups_have_nothing_between() {
        // A group is not a copy of another: the runs come in another order, and each moved a little.
        let analysis = analysis([repeats("a", 0.0, 0.0), repeats("b", 1e-6, 1e-6)].concat());
        let components = &analysis.components[0];
        let image = &components.image.as_ref().unwrap().raw;
        for found in components.parameters.iter().map(|one| &one.components).chain([image]) {
            assert!(found.between_std <= 0.0 && found.p > 0.99, "{found:?}");
            assert_eq!(found.between_interval_95[0].to_bits(), 0);
        }
    }

    #[test]
    fn groups_are_compared_with_those_of_their_parent() {
        let groups = ["day1/sift", "day1/disk", "day2/sift", "day2/disk", "odd"];
        let runs = groups.iter().zip(1..);
        let runs = runs.flat_map(|(group, i)| repeats(group, 0.1 * f64::from(i), 0.0)).collect();
        let found: Vec<(String, Vec<String>)> =
            analysis(runs).components.into_iter().map(|one| (one.parent, one.groups)).collect();
        let want = |day: &str| (day.to_owned(), vec![format!("{day}/disk"), format!("{day}/sift")]);
        assert_eq!(found, [want("day1"), want("day2")]);
    }

    #[test]
    fn paths_are_shared_in_whole_parts() {
        assert_eq!(shared_path("day1/a", "day1/b"), "day1");
        assert_eq!(shared_path("day1/a", "day10/a"), "");
        assert_eq!(shared_path("a/b/c", "a/b"), "a/b");
        assert_eq!(shared_path("a", "a"), "a");
    }

    #[test]
    fn names_and_order_of_groups_and_runs_change_no_bit() {
        let [a, b] = [repeats("a", 0.0, 3.0), repeats("b", 2.0, 0.0)];
        let mut turned: Vec<Run> = [repeats("z", 0.0, 3.0), repeats("y", 2.0, 0.0)].concat();
        for (index, run) in turned.iter_mut().enumerate() {
            run.name = format!("x{}", 50 - index);
        }
        let [one, other] = [[a, b].concat(), turned].map(|runs| analysis(runs).components);
        let bits = |components: &[Components]| {
            let image = &components[0].image.as_ref().unwrap().raw;
            [image, found(&components[0], "cx")].map(|found| {
                [found.between_std, found.repeatability_std, found.between_interval_95[1], found.p]
                    .map(f64::to_bits)
            })
        };
        assert_eq!(bits(&one), bits(&other));
    }

    #[test]
    fn a_camera_of_one_group_or_held_in_all_has_no_components() {
        assert!(
            analysis(simple_radial("a", &[[1000.0, 0.1], [1001.0, 0.2]])).components.is_empty()
        );
        let lone = [simple_radial("a", &[[1000.0, 0.1]]), simple_radial("b", &[[1001.0, 0.2]])];
        assert!(analysis(lone.concat()).components.is_empty());
    }
}
