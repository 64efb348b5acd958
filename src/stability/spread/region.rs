//! Which part of the image is compared: the region, and within it the cells where the lenses have rays.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::Serialize;

use crate::camera::Grid;

/// Which part of the image is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Region {
    /// Where at least half of the runs observed something: cells no further than one cell from an observation.
    Observed,
    /// The whole image.
    All,
    /// This share of width and height, about the image's centre.
    Center(f64),
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Observed => f.write_str("observed"),
            Self::All => f.write_str("all"),
            Self::Center(share) => write!(f, "center:{share}"),
        }
    }
}

impl FromStr for Region {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let share = |share: &str| share.parse().ok().filter(|share| *share > 0.0 && *share <= 1.0);
        match (text, text.strip_prefix("center:").map(share)) {
            ("observed", _) => Ok(Self::Observed),
            ("all", _) => Ok(Self::All),
            (_, Some(Some(share))) => Ok(Self::Center(share)),
            _ => Err(format!(
                "`{text}` is no region: wanted observed, all, or center:0.8 (any share of width and height up to 1)"
            )),
        }
    }
}

impl Serialize for Region {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl JsonSchema for Region {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Region".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "Which part of the image is compared: observed, all, or center: and a share of width and height.",
            "type": "string",
            "pattern": "^(observed|all|center:[0-9.e-]+)$",
        })
    }
}

impl Region {
    /// The cells of the region, in order. `observed` says of each run that has images which cells it observed.
    pub(in crate::stability) fn cells(self, grid: &Grid, observed: &[&[bool]]) -> Vec<usize> {
        let [columns, rows] = [grid.columns(), grid.rows()];
        let is_central = |share: f64, index: usize, count: usize| {
            let from_centre = (2 * index + 1).abs_diff(count) as f64 / count as f64;
            from_centre <= share
        };
        let is_in = |cell: &usize| match self {
            Self::All => true,
            Self::Center(share) => {
                is_central(share, cell % columns, columns)
                    && is_central(share, cell / columns, rows)
            }
            Self::Observed => {
                let count = observed.iter().filter(|cells| cells[*cell]).count();
                2 * count >= observed.len()
            }
        };
        (0..grid.cell_count()).filter(is_in).collect()
    }
}

/// How many observations lie in each cell; those outside the image in none.
pub fn observation_counts(grid: &Grid, observations: impl Iterator<Item = [f64; 2]>) -> Vec<usize> {
    let mut counts = vec![0; grid.cell_count()];
    for cell in observations.filter_map(|at| grid.cell_at(at)) {
        counts[cell] += 1;
    }
    counts
}

/// The cells no further than one cell from an observation.
pub fn observed_cells(grid: &Grid, counts: &[usize]) -> Vec<bool> {
    let [columns, rows] = [grid.columns(), grid.rows()];
    let mut is_near = vec![false; counts.len()];
    for cell in (0..counts.len()).filter(|&cell| counts[cell] > 0) {
        let (column, row) = (cell % columns, cell / columns);
        for row in row.saturating_sub(1)..rows.min(row + 2) {
            for column in column.saturating_sub(1)..columns.min(column + 2) {
                is_near[row * columns + column] = true;
            }
        }
    }
    is_near
}

/// A lens without a ray in more than this share of the cells where most have one is set aside: else one strange run would
/// decide where the others are looked at.
pub(in crate::stability) const MOST_WITHOUT_RAY: f64 = 0.1;

/// Which lenses and which cells are compared.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mask {
    /// Of the region's cells, those where every lens that is compared has a ray.
    pub is_seen: Vec<bool>,
    /// Which lenses are set aside, and the share of cells without a ray that was the reason.
    pub set_aside: Vec<Option<f64>>,
}

/// `has_ray`: of each lens, of each cell of the region. A flagged lens has no say in the mask, and is set aside where it has no
/// ray in it.
pub(super) fn mask(has_ray: &[Vec<bool>], is_flagged: &[bool]) -> Mask {
    let cell_count = has_ray.first().map_or(0, Vec::len);
    let all_flagged = is_flagged.iter().all(|is_flagged| *is_flagged);
    let has_say = |is_flagged: bool| !is_flagged || all_flagged;
    let voters: Vec<&Vec<bool>> = has_ray
        .iter()
        .zip(is_flagged)
        .filter(|(_, f)| has_say(**f))
        .map(|(rays, _)| rays)
        .collect();
    let is_common: Vec<bool> = (0..cell_count)
        .map(|cell| 2 * voters.iter().filter(|rays| rays[cell]).count() > voters.len())
        .collect();
    let common_count = is_common.iter().filter(|is_common| **is_common).count();
    let lacking = |rays: &Vec<bool>, of: &[bool]| {
        rays.iter().zip(of).filter(|(has_ray, of)| **of && !**has_ray).count() as f64
    };
    let mut set_aside: Vec<Option<f64>> = has_ray
        .iter()
        .map(|rays| lacking(rays, &is_common) / common_count.max(1) as f64)
        .map(|share| (share > MOST_WITHOUT_RAY).then_some(share))
        .collect();
    let mut is_seen = is_common;
    for (index, rays) in has_ray.iter().enumerate() {
        if set_aside[index].is_none() && has_say(is_flagged[index]) {
            is_seen.iter_mut().zip(rays).for_each(|(seen, has_ray)| *seen &= has_ray);
        }
    }
    for (set_aside, rays) in set_aside.iter_mut().zip(has_ray) {
        let share = lacking(rays, &is_seen) / common_count.max(1) as f64;
        if set_aside.is_none() && share > 0.0 {
            *set_aside = Some(share);
        }
    }
    Mask { is_seen, set_aside }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_is_read_as_it_is_written_and_nonsense_is_refused() {
        for text in ["observed", "all", "center:0.8", "center:1"] {
            assert_eq!(text.parse::<Region>().unwrap().to_string(), text);
        }
        for text in ["", "centre", "center:0", "center:1.5", "center:nan", "center:"] {
            assert!(text.parse::<Region>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_centre_is_that_share_of_both_sides() {
        let grid = Grid::new(1200, 900);
        let cells = Region::Center(0.5).cells(&grid, &[]);
        // 30 of 60 columns; of 45 rows the 23 whose centres lie within the middle half
        assert_eq!(cells.len(), 30 * 23);
        assert_eq!(Region::All.cells(&grid, &[]).len(), 2700);
    }

    #[test]
    fn a_cell_is_observed_where_half_of_the_runs_looked_nearby() {
        let grid = Grid::new(1200, 900);
        let near = |observations: &[[f64; 2]]| {
            observed_cells(&grid, &observation_counts(&grid, observations.iter().copied()))
        };
        let one = near(&[[10.0, 10.0], [610.0, 410.0]]);
        // 2 x 2 in the corner, 3 x 3 inside
        assert_eq!(one.iter().filter(|near| **near).count(), 4 + 9);
        let none = near(&[]);
        assert_eq!(Region::Observed.cells(&grid, &[&one, &none]).len(), 13);
        assert_eq!(Region::Observed.cells(&grid, &[&one, &none, &none]).len(), 0);
    }

    #[test]
    fn observations_are_counted_in_the_cell_they_lie_in() {
        let at = [[30.0, 50.0], [39.9, 59.9], [20.0, 40.0], [19.9, 50.0], [-1.0, 50.0]];
        let counts = observation_counts(&Grid::new(1200, 900), at.into_iter());
        // cells of 20 px: the second column and third row, then the one left of it
        assert_eq!([counts[121], counts[120]], [3, 1]);
        assert_eq!(counts.iter().sum::<usize>(), 4);
    }

    #[test]
    fn one_strange_lens_is_set_aside_and_does_not_decide_the_mask() {
        let all = vec![true; 100];
        let mut few = all.clone();
        few[..5].fill(false);
        let mut strange = all.clone();
        strange[50..].fill(false);
        let found = mask(&[all.clone(), few, strange, all.clone()], &[false; 4]);
        assert_eq!(found.set_aside, [None, None, Some(0.5), None]);
        assert_eq!(found.is_seen.iter().filter(|seen| **seen).count(), 95);
    }

    #[test]
    fn where_all_fold_none_is_strange() {
        let folded: Vec<bool> = (0..100).map(|cell| cell >= 30).collect();
        let found = mask(&[folded.clone(), folded.clone(), folded], &[false; 3]);
        assert_eq!(found.set_aside, [None; 3]);
        assert_eq!(found.is_seen.iter().filter(|seen| **seen).count(), 70);
    }

    #[test]
    fn a_flagged_lens_has_no_say() {
        let all = vec![true; 100];
        let mut few = all.clone();
        few[..5].fill(false);
        let found = mask(&[all.clone(), all.clone(), few], &[false, false, true]);
        assert_eq!(found.set_aside, [None, None, Some(0.05)]);
        assert!(found.is_seen.iter().all(|seen| *seen));
    }
}
