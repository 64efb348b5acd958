//! How well a lens found from some images fits the others.
//!
//! Nothing that is measured is fitted: points stay where the chosen images put them, the lens too, and of each other image half
//! of the observations of such points settle its pose and the other half are measured.

use crate::bundle::{Refit, Seen, Sight};
use crate::stats::Sorted;

/// With fewer observations a pose fits whatever it is given.
const LEAST_FOR_A_POSE: usize = 8;

/// The median distance in px between where the other images see points and where the lens, the points of the chosen images, and
/// poses from other observations put them. None where no image sees enough of them, or one finds no pose.
pub(super) fn median_px(sight: &Sight<'_>, refit: &Refit) -> Option<f64> {
    let mut distances_px = Vec::new();
    for other in sight.bystanders(refit) {
        let (by, measured) = halves(&other.seen);
        if by.len().min(measured.len()) >= LEAST_FOR_A_POSE {
            distances_px.extend(other.distances_px(&by, &measured)?);
        }
    }
    Some(Sorted::new(distances_px)?.median())
}

/// The first, third and so on, and the others.
fn halves(seen: &[Seen]) -> (Vec<Seen>, Vec<Seen>) {
    (seen.iter().step_by(2).copied().collect(), seen.iter().skip(1).step_by(2).copied().collect())
}
