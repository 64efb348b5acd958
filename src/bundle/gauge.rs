//! What no observation can tell: place, direction and size of each connected part of a scene.
//!
//! Two images fix them, as in COLMAP: one whose pose stays, and one of which a coordinate stays, so that its distance is kept.

use super::chunk::Sighted;
use super::linearize::Placed;

/// The parts of a scene that no point connects: for each image its part; none for an image that sees nothing.
pub(super) fn components(images: usize, points: &[Sighted]) -> (Vec<Option<usize>>, usize) {
    let mut parent: Vec<usize> = (0..images).collect();
    let mut is_seen = vec![false; images];
    for track in points {
        for pair in track.windows(2) {
            let [one, other] = [0, 1].map(|at| root(&mut parent, pair[at].image as usize));
            parent[one.max(other)] = one.min(other);
        }
        track.iter().for_each(|sighting| is_seen[sighting.image as usize] = true);
    }
    let mut count = 0;
    let mut numbers: Vec<Option<usize>> = vec![None; images];
    for image in (0..images).filter(|&image| is_seen[image]) {
        let root = root(&mut parent, image);
        numbers[image] = match numbers[root] {
            Some(number) => Some(number),
            None => {
                count += 1;
                numbers[root] = Some(count - 1);
                numbers[root]
            }
        };
    }
    (numbers, count)
}

fn root(parent: &mut [usize], mut at: usize) -> usize {
    while parent[at] != at {
        parent[at] = parent[parent[at]];
        at = parent[at];
    }
    at
}

/// The coordinates that stay, as indices of unknowns, six an image: seven a part that has two images in different places. Of images
/// in one place it is the points that no observation puts anywhere, and every distance between the images is observed.
pub(super) fn held(
    components: &[Option<usize>],
    count: usize,
    sightings: &[usize],
    poses: &[Placed],
) -> Vec<usize> {
    /// Of the scene's size: the smallest parallax that rounding leaves visible.
    const SAME_PLACE: f64 = 1e-7;
    let mut held = Vec::new();
    for component in 0..count {
        let members = || (0..poses.len()).filter(|&image| components[image] == Some(component));
        // The image that sees most, the first of equals.
        let Some(first) = members().max_by_key(|&image| (sightings[image], usize::MAX - image))
        else {
            continue;
        };
        held.extend(6 * first..6 * first + 6);
        let centre = |image: usize| -poses[image].rotation.tr_mul(&poses[image].translation);
        let baseline = |image: usize| centre(image) - centre(first);
        let others = members().filter(|&image| image != first);
        let farthest = others
            .max_by(|&a, &b| baseline(a).norm().total_cmp(&baseline(b).norm()).then(b.cmp(&a)));
        if let Some(second) = farthest.filter(|&image| baseline(image).norm() > SAME_PLACE) {
            held.push(6 * second + 3 + baseline(second).iamax());
        }
    }
    held
}
