//! Which cameras of a group's runs are the same physical camera. CAMERA_IDs may differ from run to run; the images
//! that a camera took do not lie.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;

use super::names::{common_folder, telling_pieces};
use super::partition::Partition;
use super::run::CameraInRun;
use super::{MatchRule, Run};
use crate::scene::CameraId;

/// The rule that decided which cameras are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum DecidedBy {
    /// They took images of the same names.
    SharedImages,
    /// They took the images of the same folder.
    Folder,
    /// The names of their images have the same pattern.
    Pattern,
    /// They have the same CAMERA_ID.
    Id,
    /// Each run has one camera.
    Single,
    /// All were pooled on request.
    Pool,
}

/// Why cameras could not be matched.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MatchError {
    /// Two cameras of one run have an equal claim to be a camera of another.
    #[error(
        "group `{group}`: camera {} of {} shares {shared} images with each of the cameras {} and {} of {}: \
         `--match id` takes equal CAMERA_IDs for the same camera, `--match single` the only camera of each run",
        .camera.1, .camera.0, .rivals.1[0], .rivals.1[1], .rivals.0
    )]
    Tie {
        /// The group.
        group: String,
        /// A run and its camera.
        camera: (String, CameraId),
        /// Another run and the two of its cameras that could be the same.
        rivals: (String, [CameraId; 2]),
        /// How many image names the camera shares with either.
        shared: usize,
    },
    /// Image names lead from one camera of a run to another of the same run.
    #[error(
        "group `{group}`: by their images, the cameras {} and {} of {run} are one camera of another run: \
         `--match id` takes equal CAMERA_IDs for the same camera",
        .cameras[0], .cameras[1]
    )]
    Merged {
        /// The group.
        group: String,
        /// The run.
        run: String,
        /// The two cameras.
        cameras: [CameraId; 2],
    },
    /// `--match images`, and the images do not decide.
    #[error(
        "group `{group}`: the images of its runs have neither names nor a folder nor a pattern in common by which to match \
         cameras: `--match id` takes equal CAMERA_IDs for the same camera, `--match single` the only camera of each run"
    )]
    NoCommonImages {
        /// The group.
        group: String,
    },
    /// `--match single`, and a run has several cameras.
    #[error("group `{group}`: `--match single` wants one camera a run, {run} has {count}")]
    NotSingle {
        /// The group.
        group: String,
        /// The run.
        run: String,
        /// How many cameras it has.
        count: usize,
    },
}

/// The classes of the cameras of one group, and the rule that made them; none when there was nothing to match.
pub(super) struct Matched {
    pub classes: Partition,
    pub by: Option<DecidedBy>,
}

/// Matches the cameras of one group's runs; `cameras` come in the order of the runs.
pub(super) fn match_cameras(
    runs: &[Run],
    cameras: &[CameraInRun],
    rule: Option<MatchRule>,
    pool: bool,
) -> Result<Matched, MatchError> {
    let decided = |classes, by| Ok(Matched { classes, by: Some(by) });
    let places: BTreeSet<usize> = cameras.iter().map(|camera| camera.run).collect();
    if pool {
        return decided(Partition::by_key(&vec![(); cameras.len()]), DecidedBy::Pool);
    }
    if places.len() < 2 {
        return Ok(Matched { classes: Partition::singles(cameras.len()), by: None });
    }
    let by_id = || Partition::by_key(&cameras.iter().map(|camera| camera.id).collect::<Vec<_>>());
    match rule {
        Some(MatchRule::Id) => decided(by_id(), DecidedBy::Id),
        Some(MatchRule::Single) => decided(by_single(runs, cameras)?, DecidedBy::Single),
        Some(MatchRule::Images) => match by_images(runs, cameras)? {
            Some((classes, by)) => decided(classes, by),
            None => Err(MatchError::NoCommonImages { group: runs[cameras[0].run].group.clone() }),
        },
        None => match by_images(runs, cameras)? {
            Some((classes, by)) => decided(classes, by),
            None => decided(by_id(), DecidedBy::Id),
        },
    }
}

fn by_single(runs: &[Run], cameras: &[CameraInRun]) -> Result<Partition, MatchError> {
    for pair in cameras.windows(2) {
        if pair[0].run == pair[1].run {
            let run = &runs[pair[0].run];
            let count = cameras.iter().filter(|camera| camera.run == pair[0].run).count();
            let (group, run) = (run.group.clone(), run.name.clone());
            return Err(MatchError::NotSingle { group, run, count });
        }
    }
    Ok(Partition::by_key(&vec![(); cameras.len()]))
}

/// The first of the rules about images that joins all runs and no two cameras of one run.
fn by_images(
    runs: &[Run],
    cameras: &[CameraInRun],
) -> Result<Option<(Partition, DecidedBy)>, MatchError> {
    let Some(names) =
        cameras.iter().map(|camera| camera.image_names.as_deref()).collect::<Option<Vec<_>>>()
    else {
        return Ok(None);
    };
    let mut classes = by_equal_names(&names);
    if merged_pair(cameras, &classes).is_some() {
        classes = by_most_shared_names(runs, cameras, &names)?;
    }
    if joins_all_runs(cameras, &classes) {
        return Ok(Some((classes, DecidedBy::SharedImages)));
    }
    let sets: Vec<(usize, &[&str])> =
        cameras.iter().zip(&names).map(|(camera, &names)| (camera.run, names)).collect();
    let folders: Option<Vec<&str>> = names.iter().map(|names| common_folder(names)).collect();
    let by_folder = folders.map(|keys| (Partition::by_key(&keys), DecidedBy::Folder));
    let by_pattern = || Some((Partition::by_key(&telling_pieces(&sets)?), DecidedBy::Pattern));
    let decides = |(classes, _): &(Partition, DecidedBy)| {
        merged_pair(cameras, classes).is_none() && joins_all_runs(cameras, classes)
    };
    Ok(by_folder.filter(decides).or_else(|| by_pattern().filter(decides)))
}

/// Two cameras of one run in one class.
fn merged_pair(cameras: &[CameraInRun], classes: &Partition) -> Option<[usize; 2]> {
    let mut seen = BTreeMap::new();
    (0..cameras.len()).find_map(|index| {
        let other = seen.insert((cameras[index].run, classes.class(index)), index)?;
        Some([other, index])
    })
}

/// Whether the classes lead from every run to every other.
fn joins_all_runs(cameras: &[CameraInRun], classes: &Partition) -> bool {
    let runs: Vec<usize> = cameras.iter().map(|camera| camera.run).collect();
    let mut joined = Partition::by_key(&runs);
    for index in 0..cameras.len() {
        joined.join(index, classes.class(index));
    }
    joined.is_whole()
}

/// An image was taken by one camera: equal names, equal camera.
fn by_equal_names(names: &[&[&str]]) -> Partition {
    let mut classes = Partition::singles(names.len());
    let mut taker = HashMap::new();
    for (camera, names) in names.iter().enumerate() {
        for name in *names {
            classes.join(camera, *taker.entry(*name).or_insert(camera));
        }
    }
    classes
}

/// For each camera and each other run, the camera there with which it shares the most image names.
fn by_most_shared_names(
    runs: &[Run],
    cameras: &[CameraInRun],
    names: &[&[&str]],
) -> Result<Partition, MatchError> {
    let sets: Vec<BTreeSet<&str>> =
        names.iter().map(|names| names.iter().copied().collect()).collect();
    let group = || runs[cameras[0].run].group.clone();
    let run_name = |camera: usize| runs[cameras[camera].run].name.clone();
    let mut classes = Partition::singles(cameras.len());
    for camera in 0..cameras.len() {
        let mut candidates: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
        for other in (0..cameras.len()).filter(|&other| cameras[other].run != cameras[camera].run) {
            let shared = sets[camera].intersection(&sets[other]).count();
            candidates.entry(cameras[other].run).or_default().push((shared, other));
        }
        for mut candidates in candidates.into_values() {
            candidates.sort_by_key(|&(shared, other)| (Reverse(shared), other));
            match candidates[..] {
                [(0, _), ..] => {}
                [(shared, one), (also, other), ..] if shared == also => {
                    return Err(MatchError::Tie {
                        group: group(),
                        camera: (run_name(camera), cameras[camera].id),
                        rivals: (run_name(one), [one, other].map(|rival| cameras[rival].id)),
                        shared,
                    });
                }
                [(_, best), ..] => classes.join(camera, best),
                [] => {}
            }
        }
    }
    match merged_pair(cameras, &classes) {
        None => Ok(classes),
        Some([one, other]) => Err(MatchError::Merged {
            group: group(),
            run: run_name(one),
            cameras: [cameras[one].id, cameras[other].id],
        }),
    }
}

impl fmt::Display for DecidedBy {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::SharedImages => "the names of the images they share",
            Self::Folder => "the folder of their images",
            Self::Pattern => "the pattern of their images' names",
            Self::Id => "their CAMERA_ID",
            Self::Single => "being the only camera of their run, as asked",
            Self::Pool => "pooling all, as asked",
        })
    }
}
