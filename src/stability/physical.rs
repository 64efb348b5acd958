//! Which cameras of different groups are the same physical camera, and what to call it.

use std::collections::{BTreeMap, BTreeSet};

use super::names::common_pattern;
use super::partition::Partition;
use crate::scene::CameraId;

/// A camera of one group, over all of its runs.
#[derive(Debug, Clone, Default)]
pub(super) struct CameraOfGroup<'a> {
    /// Index of the group.
    pub group: usize,
    /// The CAMERA_IDs it has in the group's runs.
    pub ids: BTreeSet<CameraId>,
    /// The names of all images it took; empty when only cameras are known.
    pub image_names: BTreeSet<&'a str>,
}

/// The physical cameras: cameras of different groups that took the same images, each of no other camera's. A camera that
/// took the images of two others (one model shared by both) is one of its own. Where no images speak, equal ids do.
pub(super) fn physical_cameras(cameras: &[CameraOfGroup]) -> Partition {
    let relatives = relatives(cameras);
    let only_relative_in = |camera: usize, group: usize| {
        let mut there = relatives[camera].iter().filter(|&&other| cameras[other].group == group);
        there.next().filter(|_| there.next().is_none()).copied()
    };
    let mut classes = Partition::singles(cameras.len());
    for (camera, others) in relatives.iter().enumerate() {
        for &other in others {
            let is_mutual = only_relative_in(camera, cameras[other].group) == Some(other)
                && only_relative_in(other, cameras[camera].group) == Some(camera);
            if is_mutual {
                classes.join(camera, other);
            }
        }
    }
    if has_two_of_a_group(cameras, &classes, |_| true) {
        classes = Partition::singles(cameras.len());
    }
    let ids: BTreeSet<&BTreeSet<CameraId>> = cameras.iter().map(|camera| &camera.ids).collect();
    for ids in ids {
        join_by_id(cameras, &relatives, &mut classes, ids);
    }
    classes
}

/// The members of each physical camera that took several images, by its class, and with them the one camera that took its
/// images in a group that has no member: the model that it shares with others there.
pub(super) fn with_sharers(
    cameras: &[CameraOfGroup],
    classes: &Partition,
) -> BTreeMap<usize, Vec<usize>> {
    let relatives = relatives(cameras);
    let mut same: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, camera) in cameras.iter().enumerate() {
        if camera.image_names.len() != 1 {
            same.entry(classes.class(index)).or_default().push(index);
        }
    }
    for members in same.values_mut() {
        let groups: BTreeSet<usize> = members.iter().map(|&one| cameras[one].group).collect();
        let mut sharers: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for &other in members.iter().flat_map(|&one| &relatives[one]) {
            sharers.entry(cameras[other].group).or_default().insert(other);
        }
        let lone = sharers
            .iter()
            .filter(|(group, of_group)| !groups.contains(group) && of_group.len() == 1);
        members.extend(lone.flat_map(|(_, of_group)| of_group));
    }
    same
}

/// Cameras of other groups with which each shares an image name.
fn relatives(cameras: &[CameraOfGroup]) -> Vec<BTreeSet<usize>> {
    let mut takers: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (index, camera) in cameras.iter().enumerate() {
        for name in &camera.image_names {
            takers.entry(name).or_default().push(index);
        }
    }
    let mut relatives = vec![BTreeSet::new(); cameras.len()];
    for takers in takers.values() {
        for &one in takers {
            relatives[one]
                .extend(takers.iter().filter(|&&other| cameras[other].group != cameras[one].group));
        }
    }
    relatives
}

/// Joins the cameras that have just these ids, unless their images or a group that has two of them speak against it.
fn join_by_id(
    cameras: &[CameraOfGroup],
    relatives: &[BTreeSet<usize>],
    classes: &mut Partition,
    ids: &BTreeSet<CameraId>,
) {
    let same: Vec<usize> =
        (0..cameras.len()).filter(|&camera| cameras[camera].ids == *ids).collect();
    let mut joined = classes.clone();
    for pair in same.windows(2) {
        joined.join(pair[0], pair[1]);
    }
    let class = joined.class(same[0]);
    let is_of_class = |camera: usize| joined.class(camera) == class;
    let is_against = (0..cameras.len()).filter(|&camera| is_of_class(camera)).any(|camera| {
        relatives[camera]
            .iter()
            .any(|&other| is_of_class(other) && classes.class(other) != classes.class(camera))
    });
    if !is_against && !has_two_of_a_group(cameras, &joined, is_of_class) {
        *classes = joined;
    }
}

fn has_two_of_a_group(
    cameras: &[CameraOfGroup],
    classes: &Partition,
    matters: impl Fn(usize) -> bool,
) -> bool {
    let mut seen = BTreeSet::new();
    (0..cameras.len())
        .filter(|&camera| matters(camera))
        .any(|camera| !seen.insert((classes.class(camera), cameras[camera].group)))
}

/// What to call each camera: `camera 1` where the id tells, with the pattern of its images where it does not; by its image
/// where it took but one.
pub(super) fn labels(cameras: &[CameraOfGroup], classes: &Partition) -> Vec<String> {
    let mut physical: BTreeMap<usize, CameraOfGroup> = BTreeMap::new();
    for (index, camera) in cameras.iter().enumerate() {
        let whole = physical.entry(classes.class(index)).or_default();
        whole.ids.extend(&camera.ids);
        whole.image_names.extend(&camera.image_names);
    }
    let by_id = |camera: &CameraOfGroup| match camera.ids.iter().collect::<Vec<_>>()[..] {
        [id] => format!("camera {id}"),
        _ => "camera".to_owned(),
    };
    let of_many = || physical.values().filter(|camera| camera.image_names.len() != 1);
    let ids: BTreeSet<String> = of_many().map(by_id).collect();
    let needs_images = ids.len() < of_many().count() || ids.contains("camera");
    let mut taken: BTreeMap<String, usize> = BTreeMap::new();
    let mut named = BTreeMap::new();
    for (class, camera) in &physical {
        let names: Vec<&str> = camera.image_names.iter().copied().collect();
        let label = match (&names[..], common_pattern(&names)) {
            ([name], _) => format!("camera of {name}"),
            (_, Some(pattern)) if needs_images => format!("{} ({pattern})", by_id(camera)),
            _ => by_id(camera),
        };
        let count = taken.entry(label.clone()).or_default();
        *count += 1;
        named.insert(class, if *count == 1 { label } else { format!("{label} #{count}") });
    }
    (0..cameras.len()).map(|camera| named[&classes.class(camera)].clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(group: usize, id: u32, names: &[&'static str]) -> CameraOfGroup<'static> {
        let (ids, image_names) = ([CameraId(id)].into(), names.iter().copied().collect());
        CameraOfGroup { group, ids, image_names }
    }

    fn labels_of(cameras: &[CameraOfGroup]) -> Vec<String> {
        labels(cameras, &physical_cameras(cameras))
    }

    #[test]
    fn a_camera_that_took_the_images_of_two_is_neither() {
        let cameras = [
            camera(0, 1, &["1_cam0.jpg", "2_cam0.jpg"]),
            camera(0, 2, &["1_cam1.jpg", "2_cam1.jpg"]),
            camera(1, 1, &["1_cam0.jpg", "2_cam1.jpg"]),
            camera(2, 1, &["2_cam0.jpg", "3_cam0.jpg"]),
            camera(2, 2, &["1_cam1.jpg", "3_cam1.jpg"]),
        ];
        let shared = "camera 1 (*_cam*.jpg)";
        let (left, right) = ("camera 1 (*_cam0.jpg)", "camera 2 (*_cam1.jpg)");
        assert_eq!(labels_of(&cameras), [left, right, shared, left, right]);
    }

    #[test]
    fn a_shared_model_stands_for_each_camera_that_shares_it() {
        let cameras = [
            camera(0, 1, &["1_cam0.jpg", "2_cam0.jpg"]),
            camera(0, 2, &["1_cam1.jpg", "2_cam1.jpg"]),
            camera(1, 1, &["1_cam0.jpg", "2_cam0.jpg", "1_cam1.jpg", "2_cam1.jpg"]),
            camera(2, 1, &["2_cam0.jpg", "3_cam0.jpg"]),
            camera(2, 2, &["2_cam1.jpg", "3_cam1.jpg"]),
        ];
        let same: Vec<Vec<usize>> =
            with_sharers(&cameras, &physical_cameras(&cameras)).into_values().collect();
        assert_eq!(same, [vec![0, 3, 2], vec![1, 4, 2], vec![2]]);
    }

    #[test]
    fn without_images_equal_ids_are_one_camera() {
        let cameras = [camera(0, 1, &[]), camera(0, 2, &[]), camera(1, 2, &[])];
        assert_eq!(labels_of(&cameras), ["camera 1", "camera 2", "camera 2"]);
    }

    #[test]
    fn images_overrule_ids() {
        let cameras = [
            camera(0, 1, &["left/1.jpg", "left/2.jpg"]),
            camera(0, 2, &["right/1.jpg", "right/2.jpg"]),
            camera(1, 2, &["left/2.jpg"]),
            camera(1, 1, &["right/2.jpg"]),
        ];
        let labels = labels_of(&cameras);
        assert_eq!(labels[..2], ["camera (left/*.jpg)", "camera (right/*.jpg)"]);
        assert_eq!(labels[2..], labels[..2]);
    }

    #[test]
    fn a_camera_of_one_image_is_called_by_it() {
        let cameras = [
            camera(0, 1, &["1.jpg", "2.jpg", "3.jpg"]),
            camera(1, 1, &["1.jpg"]),
            camera(1, 2, &["2.jpg"]),
        ];
        assert_eq!(labels_of(&cameras), ["camera 1", "camera of 1.jpg", "camera of 2.jpg"]);
    }

    #[test]
    fn two_cameras_never_have_one_name() {
        let cameras =
            [camera(0, 1, &["a.jpg"]), camera(1, 1, &["a.jpg"]), camera(1, 2, &["a.jpg"])];
        let labels: BTreeSet<String> = labels_of(&cameras).into_iter().collect();
        assert_eq!(labels.len(), 3);
    }
}
