//! Runs that settled in different basins: by their distances in px, never by their names.

use schemars::JsonSchema;
use serde::Serialize;

/// Fewer runs cannot show that one is out of line.
pub(super) const FEWEST: usize = 5;
/// A gap that no one would see in the image is none.
pub(super) const LEAST_GAP_PX: f64 = 0.1;

/// The runs of a population that disagree by more than chance, in parts.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Clusters {
    /// The parts, the largest first.
    pub parts: Vec<Part>,
}

/// Runs that agree with each other.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Part {
    /// Its runs; with pooled cameras, with their CAMERA_ID behind a colon.
    pub runs: Vec<String>,
    /// The least distance to a run of another part, in px, rotation-aligned; none for a run that was set aside.
    pub gap_px: Option<f64>,
    /// The spread of this part alone: RMS in px as they are, and rotation-aligned. None with fewer than two runs.
    pub spread_px: Option<[f64; 2]>,
    /// The parameters over this part alone; none with fewer than two runs.
    pub parameters: Vec<PartParameter>,
}

/// Mean and std of one parameter over one part.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PartParameter {
    /// Its name.
    pub name: String,
    /// How many samples.
    pub n: usize,
    /// Their mean.
    pub mean: f64,
    /// Their std, with n - 1.
    pub std: f64,
}

/// A gap between two parts of n normal samples is this many median distances within the parts in less than one case of a
/// hundred, even when the samples differ along one direction only (simulated; in more directions it is smaller still).
pub(super) fn least_ratio(n: usize) -> f64 {
    (60.0 / n as f64).max(2.5)
}

/// Splits runs at the gaps in their distances; one part when there is no gap.
pub(super) fn parts(distances: &[Vec<f64>]) -> Vec<Vec<usize>> {
    let mut parts = split((0..distances.len()).collect(), distances);
    parts.sort_by_key(|part| (usize::MAX - part.len(), part[0]));
    parts
}

fn split(members: Vec<usize>, distances: &[Vec<f64>]) -> Vec<Vec<usize>> {
    if members.len() < FEWEST {
        return vec![members];
    }
    let (gap, one, other) = widest_gap(&members, distances);
    let mut within: Vec<f64> = Vec::new();
    for part in [&one, &other] {
        for (index, &a) in part.iter().enumerate() {
            within.extend(part[..index].iter().map(|&b| distances[a][b]));
        }
    }
    within.sort_by(f64::total_cmp);
    let typical = within[within.len() / 2];
    if gap < LEAST_GAP_PX || gap < least_ratio(members.len()) * typical {
        return vec![members];
    }
    let mut parts = split(one, distances);
    parts.extend(split(other, distances));
    parts
}

/// The longest edge of the shortest tree that joins all members (Prim), and the two sides of it.
fn widest_gap(members: &[usize], distances: &[Vec<f64>]) -> (f64, Vec<usize>, Vec<usize>) {
    let mut left: Vec<(f64, usize)> =
        members[1..].iter().map(|&member| (distances[members[0]][member], member)).collect();
    let mut joined = vec![members[0]];
    let mut edges: Vec<f64> = Vec::new();
    while let Some(nearest) = (0..left.len()).min_by(|&a, &b| left[a].0.total_cmp(&left[b].0)) {
        let (edge, member) = left.swap_remove(nearest);
        edges.push(edge);
        joined.push(member);
        for (distance, other) in &mut left {
            *distance = distance.min(distances[member][*other]);
        }
    }
    let longest = edges.iter().copied().fold(0.0, f64::max);
    // What is reached from the first member by shorter edges is one side.
    let mut side = vec![members[0]];
    let mut rest: Vec<usize> = members[1..].to_vec();
    while let Some(at) = rest.iter().position(|&m| side.iter().any(|&s| distances[s][m] < longest))
    {
        side.push(rest.remove(at));
    }
    side.sort_unstable();
    (longest, side, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_a_line(places: &[f64]) -> Vec<Vec<f64>> {
        places.iter().map(|a| places.iter().map(|b| (a - b).abs()).collect()).collect()
    }

    #[test]
    fn a_lone_wrong_basin_is_one_part() {
        let found = parts(&on_a_line(&[1.0, 1.4, 120.0, 0.7, 1.1, 1.9]));
        assert_eq!(found, [vec![0, 1, 3, 4, 5], vec![2]]);
    }

    #[test]
    fn two_basins_are_split_and_two_lone_runs_too() {
        let found = parts(&on_a_line(&[1.0, 51.0, 1.3, 50.6, 1.2, 51.5, 0.9]));
        assert_eq!(found, [vec![0, 2, 4, 6], vec![1, 3, 5]]);
        let found = parts(&on_a_line(&[1.0, 1.4, 90.0, 0.7, 1.1, -4000.0, 1.9, 1.2]));
        assert_eq!(found, [vec![0, 1, 3, 4, 6, 7], vec![2], vec![5]]);
    }

    #[test]
    fn evenly_scattered_few_or_equal_runs_are_one_part() {
        for places in [
            &[1.0, 2.0, 2.5, 4.0, 3.2, 6.0][..],
            &[0.0, 1000.0, 0.1, 0.2],
            &[5.0; 8],
            &[0.0, 1e-3, 2e-3, 0.09, 3e-3, 1e-3],
        ] {
            assert_eq!(parts(&on_a_line(places)).len(), 1, "{places:?}");
        }
    }

    #[test]
    fn normal_samples_are_rarely_split() {
        // A fixed sequence of uniform numbers (Knuth's generator); sums of twelve are normal enough.
        let mut state = 1_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        for n in [5, 6, 8, 10, 20] {
            let is_split = |_: &usize| {
                let places: Vec<f64> = (0..n).map(|_| 10.0 * normal()).collect();
                parts(&on_a_line(&places)).len() > 1
            };
            let count = (0..500).filter(is_split).count();
            assert!(count <= 15, "{count} of 500 with n = {n}");
        }
    }
}
