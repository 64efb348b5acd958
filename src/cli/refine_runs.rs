//! Refines the runs of an analysis, several at a time.

use std::cmp::Reverse;
use std::collections::BTreeSet;

use indicatif::ProgressBar;
use rayon::ThreadPool;

use super::failure::Failure;
use super::inputs::progress_bar;
use super::pools::{on_pools, pools};
use crate::bundle::{self, BundleError, Options, Outcome, Refine, Which};
use crate::scene::Scene;
use crate::stability::spread::Region;
use crate::stability::{Inside, Run};

/// What became of the run of this index.
type Refined = (usize, Result<(Outcome, Option<Inside>), BundleError>);

/// Refines every run of each group whose runs all have images and points; what comes of it stands in the run. Tells how many were
/// tried.
pub(super) fn refine(
    runs: &mut [Run],
    options: &Options,
    region: Option<Region>,
    quiet: bool,
) -> Result<usize, Failure> {
    let hindered: BTreeSet<&str> =
        runs.iter().filter(|run| !run.is_refinable()).map(|run| run.group.as_str()).collect();
    let is_wanted = |index: &usize| !hindered.contains(runs[*index].group.as_str());
    let mut wanted: Vec<usize> = (0..runs.len()).filter(is_wanted).collect();
    if wanted.is_empty() {
        return Ok(0);
    }
    check_names(wanted.iter().map(|&index| &runs[index].scene), &options.refine)?;
    // The longest first, so that none is left over for one thread at the end.
    wanted.sort_by_key(|&index| Reverse(observation_count(&runs[index].scene)));
    let progress = progress_bar("refining runs", wanted.len(), quiet);
    let threads = rayon::current_num_threads();
    let side_by_side = threads.min(wanted.len());
    let share = options.memory.map(|bytes| bytes / side_by_side);
    let shared = Options { memory: share, ..options.clone() };
    let how = (&shared, region);
    let done = on_threads(runs, &wanted, how, pools(side_by_side, threads)?, &progress);
    let is_too_large = |(_, result): &Refined| matches!(result, Err(BundleError::Memory { .. }));
    let (again, mut done): (Vec<Refined>, Vec<Refined>) = done.into_iter().partition(is_too_large);
    if !again.is_empty() {
        // What does not fit beside others may fit alone.
        let alone: Vec<usize> = again.into_iter().map(|(index, _)| index).collect();
        let hidden = ProgressBar::hidden();
        done.extend(on_threads(runs, &alone, (options, region), pools(1, threads)?, &hidden));
    }
    progress.finish_and_clear();
    for (index, result) in done {
        (runs[index].refinement, runs[index].inside) = match result {
            Ok((outcome, inside)) => (Some(Ok(outcome)), inside),
            Err(error) => (Some(Err(error)), None),
        };
    }
    Ok(wanted.len())
}

fn observation_count(scene: &Scene) -> usize {
    scene.geometry.as_ref().map_or(0, |geometry| geometry.points.observation_count())
}

/// Adjusts the runs of these indices, one at a time in each pool.
fn on_threads(
    runs: &[Run],
    indices: &[usize],
    (options, region): (&Options, Option<Region>),
    pools: Vec<ThreadPool>,
    progress: &ProgressBar,
) -> Vec<Refined> {
    on_pools(pools, indices, |&index| {
        let scene = &runs[index].scene;
        let own = Options { refine: of_scene(&options.refine, scene), ..options.clone() };
        let adjust = || {
            let (adjusted, optimum) = bundle::adjust_to_optimum(scene.clone(), &own, &mut |_| ())?;
            let inside = Inside::of(&adjusted.outcome, &optimum, region);
            Ok((adjusted.outcome, inside))
        };
        let adjusted = adjust();
        progress.inc(1);
        (index, adjusted)
    })
}

/// The wishes less those for cameras and parameters that this run does not have: others have them.
fn of_scene(refine: &Refine, scene: &Scene) -> Refine {
    let known = |which: &[Which], of: &dyn Fn(&Which) -> bool| -> Vec<Which> {
        which.iter().filter(|one| of(one)).cloned().collect()
    };
    let cameras = refine.cameras.iter().filter(|(id, _)| scene.cameras.contains_key(id));
    Refine {
        others: known(&refine.others, &|which| is_somewhere(which, scene)),
        cameras: cameras
            .map(|(id, wanted)| {
                let camera = &scene.cameras[id];
                let has = |which: &Which| is_of(which, camera);
                (*id, known(wanted, &has))
            })
            .collect(),
    }
}

fn is_somewhere(which: &Which, scene: &Scene) -> bool {
    scene.cameras.values().any(|camera| is_of(which, camera))
}

/// Whether the camera has a parameter of this name; a class may be empty.
fn is_of(which: &Which, camera: &crate::scene::Camera) -> bool {
    let mut params = camera.intrinsics.model().params.iter();
    matches!(which, Which::Class(_)) || params.any(|param| which.is(param))
}

/// Every camera and parameter that was named is one of some run.
fn check_names<'a>(
    scenes: impl Iterator<Item = &'a Scene> + Clone,
    refine: &Refine,
) -> Result<(), Failure> {
    let refused = |text: String| Err(Failure::Input(format!("--refine: {text}")));
    for (id, wanted) in &refine.cameras {
        let cameras: Vec<_> = scenes.clone().filter_map(|scene| scene.cameras.get(id)).collect();
        if cameras.is_empty() {
            return refused(format!("no run has a camera {id}"));
        }
        let is_unknown = |which: &&Which| !cameras.iter().any(|camera| is_of(which, camera));
        if let Some(Which::Named(name)) = wanted.iter().find(is_unknown) {
            return refused(format!("no run has a camera {id} with a parameter `{name}`"));
        }
    }
    let is_unknown = |which: &&Which| !scenes.clone().any(|scene| is_somewhere(which, scene));
    match refine.others.iter().find(is_unknown) {
        Some(Which::Named(name)) => {
            refused(format!("no camera of any run has a parameter `{name}`"))
        }
        Some(Which::Class(_)) | None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rayon::ThreadPoolBuilder;

    use super::super::inputs::read_one;
    use super::*;

    /// Two runs of the fixtures, refined by two threads in so much memory.
    fn refined(memory: usize) -> Vec<Result<Outcome, BundleError>> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/renumbered");
        let read = |name: &str| read_one(&folder.join(name), name).ok().unwrap();
        let mut runs = vec![read("run1"), read("run2")];
        let options = Options { memory: Some(memory), ..Options::default() };
        let two = ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        assert_eq!(two.install(|| refine(&mut runs, &options, None, true)).ok(), Some(2));
        runs.into_iter().map(|run| run.refinement.unwrap()).collect()
    }

    #[test]
    fn a_run_that_does_not_fit_beside_others_is_refined_alone() {
        let missing = |result: &Result<Outcome, BundleError>| match result {
            Err(BundleError::Memory { needed, .. }) => Some(*needed),
            _ => None,
        };
        // A run is refused as soon as a part of it is known not to fit: what it says to need may grow.
        let mut needed = 1;
        while let Some(more) = refined(needed).iter().filter_map(missing).max() {
            assert!(more > needed);
            needed = more;
        }
        assert!(needed > 1);
        // Half of it each is too little, all of it is enough.
        let alone = refined(needed);
        assert!(alone.iter().all(Result::is_ok));
        assert_eq!(alone, refined(4 * needed));
        assert!(refined(needed - 1).iter().any(Result::is_err));
    }
}
