//! The spread: how far calibrations of one camera disagree, in pixels, over the image. Needs their rays only, so their models
//! may differ.

mod consensus;
mod difference;
mod fields;
mod rays;
mod region;
mod shape;
mod summary;
#[cfg(test)]
mod tests;

use nalgebra::{Vector2, Vector3};

use consensus::{Consensus, Lenses, Placement, consensus, rotation_vector};
pub(in crate::stability) use difference::difference_of_rays;
pub use difference::{Difference, DifferenceMeasure, difference};
pub(super) use fields::aligned_deviations;
use rays::{Deviations, deviations, turned_start, unturned_start};
pub(super) use region::MOST_WITHOUT_RAY;
pub use region::Region;
use region::mask;
pub(super) use region::{observation_counts, observed_cells};
pub(super) use shape::in_single_precision;
pub use shape::*;
use summary::{distances, radial_profile, spread_measure};
pub(super) use summary::{radial_rms, rms};

use crate::camera::{Grid, Intrinsics};
use crate::scene::Camera;
use crate::stats::{Sorted, degrees_of_distances, std_interval_factors_of_degrees};

/// One calibration among those that are compared.
#[derive(Debug, Clone)]
pub struct Calibration<'a> {
    /// The run it is from.
    pub run: &'a str,
    /// The camera's CAMERA_ID in it.
    pub camera_id: u32,
    /// The camera.
    pub camera: &'a Camera,
    /// Whether the run is suspect: it has no say in where the lenses are compared.
    pub is_flagged: bool,
    /// What its images observed; none without images.
    pub view: Option<View>,
}

/// What the images of one camera observed.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Of each cell of the image's grid, how many observations lie in it.
    pub observation_counts: Vec<usize>,
    /// Of each cell of the image's grid, whether something was observed in it or next to it.
    pub observed_cells: Vec<bool>,
    /// 10, 50 and 90 % quantiles of the distances to the observed points, in the unit of the scene; none without points.
    pub distances: Option<[f64; 3]>,
}

/// Why calibrations cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SpreadError {
    /// There are not two of them.
    #[error("fewer than two calibrations have no spread")]
    TooFew,
    /// Their images are not of one size.
    #[error("image sizes differ: {} of {} x {}, {} of {} x {}", .0[0].0, .0[0].1[0], .0[0].1[1], .0[1].0, .0[1].1[0], .0[1].1[1])]
    Sizes(Box<[(String, [u64; 2]); 2]>),
    /// Nowhere in the region do all of them have a ray.
    #[error("there is no part of the image where all of them have a ray")]
    NothingInCommon,
}

/// How far calibrations of one camera disagree; their order and names change no bit of it. The region is by default what was
/// observed, where all have images, and else the whole image.
pub fn spread(calibrations: &[Calibration], region: Option<Region>) -> Result<Spread, SpreadError> {
    Ok(Compared::new(calibrations, region)?.spread)
}

/// A spread with what is needed to look closer.
pub(super) struct Compared {
    pub spread: Spread,
    /// Distances between the calibrations of `spread.runs`, in px.
    pub distances: Vec<Vec<f64>>,
    /// The rays of the rotation-aligned consensus, of each cell.
    pub mean_rays: Vec<Vector3<f64>>,
}

impl Compared {
    pub(super) fn new(
        calibrations: &[Calibration],
        region: Option<Region>,
    ) -> Result<Self, SpreadError> {
        let size = one_size(calibrations)?;
        let grid = Grid::new(size[0], size[1]);
        let mut order: Vec<usize> = (0..calibrations.len()).collect();
        order.sort_by_key(|&index| content(calibrations[index].camera));
        let region = region.unwrap_or_else(|| default_region(calibrations));
        let (chosen, set_aside) = choose(calibrations, &order, region, &grid)?;
        if chosen.order.len() < 2 {
            return Err(SpreadError::TooFew);
        }
        let views = chosen.order.iter().map(|&index| &calibrations[index].view);
        let depths = depths(views);
        let found = Found::new(&chosen, depths.as_ref()).ok_or(SpreadError::NothingInCommon)?;
        let set_aside = set_aside
            .into_iter()
            .map(|(index, without_ray)| {
                let Calibration { run, camera_id, .. } = &calibrations[index];
                SetAside { run: (*run).to_owned(), camera_id: *camera_id, without_ray }
            })
            .collect();
        found.summarise(calibrations, chosen, Frame { grid, size, region, set_aside })
    }
}

/// Model, parameters and image size of a camera: what it is sorted by, as names say nothing.
fn content(camera: &Camera) -> (&'static str, Vec<u64>) {
    let bits = |value: &f64| value.to_bits();
    (camera.intrinsics.model().name, camera.intrinsics.params().iter().map(bits).collect())
}

/// The size of all images; different ones are refused.
fn one_size(calibrations: &[Calibration]) -> Result<[u64; 2], SpreadError> {
    let size = |one: &Calibration| [one.camera.width, one.camera.height];
    let first = calibrations.first().ok_or(SpreadError::TooFew)?;
    match calibrations.iter().find(|one| size(one) != size(first)) {
        None => Ok(size(first)),
        Some(other) => {
            let told = |one: &Calibration| (one.run.to_owned(), size(one));
            Err(SpreadError::Sizes(Box::new([told(first), told(other)])))
        }
    }
}

fn default_region(calibrations: &[Calibration]) -> Region {
    let has_images = calibrations.iter().all(|one| one.view.is_some());
    if has_images { Region::Observed } else { Region::All }
}

/// What is compared: which calibrations, in the order of their content, where, and the rays there.
struct Chosen<'a> {
    order: Vec<usize>,
    cameras: Vec<&'a Intrinsics>,
    cells: Vec<usize>,
    /// Cells of the region that are not compared, as not every lens has a ray there.
    masked_cells: Vec<usize>,
    pixels: Vec<Vector2<f64>>,
    /// Lens by lens.
    rays: Vec<Vec<Vector3<f64>>>,
    /// Where the search starts.
    start: Vec<Vector3<f64>>,
}

/// The lenses and cells that are compared, frozen before any alignment, and who is set aside for lack of rays.
fn choose<'a>(
    calibrations: &[Calibration<'a>],
    order: &[usize],
    region: Region,
    grid: &Grid,
) -> Result<(Chosen<'a>, Vec<(usize, f64)>), SpreadError> {
    let views = calibrations.iter().filter_map(|one| one.view.as_ref());
    let observed: Vec<&[bool]> = views.map(|view| view.observed_cells.as_slice()).collect();
    let cells = region.cells(grid, &observed);
    let pixels: Vec<Vector2<f64>> = cells.iter().map(|&cell| grid.pixel(cell)).collect();
    let cameras: Vec<&Intrinsics> =
        order.iter().map(|&index| &calibrations[index].camera.intrinsics).collect();
    let rays = rays::all_rays(&cameras, &pixels);
    let has_ray: Vec<Vec<bool>> =
        rays.iter().map(|rays| rays.iter().map(Option::is_some).collect()).collect();
    let is_flagged: Vec<bool> = order.iter().map(|&index| calibrations[index].is_flagged).collect();
    let mask = mask(&has_ray, &is_flagged);
    let aside = order.iter().zip(&mask.set_aside);
    let set_aside = aside.filter_map(|(&index, share)| Some((index, (*share)?))).collect();
    let kept: Vec<usize> =
        (0..order.len()).filter(|&lens| mask.set_aside[lens].is_none()).collect();
    let kept_cameras: Vec<&Intrinsics> = kept.iter().map(|&lens| cameras[lens]).collect();
    let kept_rays: Vec<&[Option<Vector3<f64>>]> =
        kept.iter().map(|&lens| rays[lens].as_slice()).collect();
    let start = unturned_start(&kept_cameras, &pixels, &kept_rays);
    let is_in = |cell: &usize| mask.is_seen[*cell] && start[*cell].is_some();
    let (seen, masked): (Vec<usize>, Vec<usize>) = (0..cells.len()).partition(is_in);
    let chosen = Chosen {
        order: kept.iter().map(|&lens| order[lens]).collect(),
        cells: seen.iter().map(|&cell| cells[cell]).collect(),
        masked_cells: masked.iter().map(|&cell| cells[cell]).collect(),
        pixels: seen.iter().map(|&cell| pixels[cell]).collect(),
        rays: kept_rays.iter().map(|rays| seen.iter().filter_map(|&c| rays[c]).collect()).collect(),
        start: seen.iter().filter_map(|&cell| start[cell]).collect(),
        cameras: kept_cameras,
    };
    if chosen.cells.is_empty() {
        return Err(SpreadError::NothingInCommon);
    }
    Ok((chosen, set_aside))
}

/// The observations in each cell of the image, of all runs together; none unless all have images.
fn observation_counts_of<'a>(views: impl Iterator<Item = &'a Option<View>>) -> Option<Vec<usize>> {
    let counts: Vec<&Vec<usize>> =
        views.map(|view| Some(&view.as_ref()?.observation_counts)).collect::<Option<_>>()?;
    let cell_count = counts.first()?.len();
    Some((0..cell_count).map(|cell| counts.iter().map(|counts| counts[cell]).sum()).collect())
}

/// 10, 50 and 90 % quantiles of the observed distances over their median, median over the runs; none unless all runs have them.
fn depths<'a>(views: impl Iterator<Item = &'a Option<View>>) -> Option<[f64; 3]> {
    let of_runs: Vec<[f64; 3]> =
        views.map(|view| view.as_ref()?.distances).collect::<Option<_>>()?;
    let median = |index: usize| {
        Some(Sorted::new(of_runs.iter().map(|of| of[index] / of[1]).collect())?.median())
    };
    Some([median(0)?, 1.0, median(2)?])
}

/// The consensus of the chosen lenses, three times.
struct Found {
    raw: Deviations,
    rotated: Deviations,
    moved: Option<(Deviations, [f64; 3])>,
    consensus: Consensus,
}

impl Found {
    fn new(chosen: &Chosen, depths: Option<&[f64; 3]>) -> Option<Self> {
        let lenses =
            Lenses { cameras: &chosen.cameras, pixels: &chosen.pixels, inverse_depths: &[0.0] };
        let unmoved = vec![Placement::unmoved(); chosen.cameras.len()];
        let start = Consensus { rays: chosen.start.clone(), placements: unmoved };
        let raw = consensus::<0>(lenses, start)?;
        let raw_deviations = deviations(lenses, &raw)?;
        let squares = |deviations: &Deviations| -> f64 {
            deviations.px.iter().map(Vector2::norm_squared).sum()
        };
        // The closed form minimises angles; in px it may lead astray, and then the search starts from no turn at all.
        let turned = turned_start(&raw, &chosen.rays)
            .and_then(|start| consensus::<3>(lenses, start))
            .and_then(|turned| Some((deviations(lenses, &turned)?, turned)))
            .filter(|(turned, _)| squares(turned) <= squares(&raw_deviations));
        let (rotated_deviations, rotated) = match turned {
            Some(found) => found,
            None => {
                let turned = consensus::<3>(lenses, raw.clone())?;
                (deviations(lenses, &turned)?, turned)
            }
        };
        let moved = depths.and_then(|depths| {
            let inverse = depths.map(|depth| 1.0 / depth);
            let lenses = Lenses { inverse_depths: &inverse, ..lenses };
            let moved = consensus::<6>(lenses, rotated.clone())?;
            Some((deviations(lenses, &moved)?, *depths))
        });
        Some(Self { raw: raw_deviations, rotated: rotated_deviations, moved, consensus: rotated })
    }

    fn summarise(
        self,
        calibrations: &[Calibration],
        chosen: Chosen,
        frame: Frame,
    ) -> Result<Compared, SpreadError> {
        let count = chosen.order.len();
        let Frame { grid, size, region, set_aside } = frame;
        let measure = |deviations: &Deviations| {
            spread_measure(deviations, count, &chosen.pixels).ok_or(SpreadError::NothingInCommon)
        };
        let [raw, rotated] = [measure(&self.raw)?, measure(&self.rotated)?];
        let moved = match &self.moved {
            Some((deviations, depths)) => {
                Some(MovedSpread { depths: *depths, measure: measure(deviations)? })
            }
            None => None,
        };
        // Back to the order in which they were given.
        let mut given: Vec<usize> = (0..count).collect();
        given.sort_by_key(|&lens| chosen.order[lens]);
        let told: Vec<RunDeviation> = given
            .iter()
            .map(|&lens| self.run_deviation(&calibrations[chosen.order[lens]], &chosen, lens))
            .collect();
        let greatest = |&a: &usize, &b: &usize| told[a].rms_px.total_cmp(&told[b].rms_px);
        let worst = (0..count).max_by(greatest).unwrap_or(0);
        let field = self.rotated.px.iter().skip(given[worst]).step_by(count);
        let worst = deviation_field(&told[worst], &grid, &chosen.cells, field);
        let views = chosen.order.iter().map(|&index| &calibrations[index].view);
        let observation_counts = observation_counts_of(views);
        let by_content = distances(&self.rotated.px, count);
        let distances: Vec<Vec<f64>> =
            given.iter().map(|&a| given.iter().map(|&b| by_content[a][b]).collect()).collect();
        let degrees = degrees_of_distances(&by_content);
        let factors =
            std_interval_factors_of_degrees(degrees, 0.95).ok_or(SpreadError::NothingInCommon)?;
        /// A matrix of more is no figure that anyone reads.
        const MOST_DISTANCES: usize = 50;
        let spread = Spread {
            n: count,
            region,
            columns: grid.columns(),
            rows: grid.rows(),
            cell_share: chosen.cells.len() as f64 / grid.cell_count() as f64,
            radial_profile: radial_profile(
                &grid,
                size,
                &chosen.cells,
                [&raw.map_px, &rotated.map_px],
            ),
            cells: chosen.cells,
            masked_cells: chosen.masked_cells,
            observation_counts,
            rotated_interval_95: factors.map(|factor| factor * rotated.rms_px),
            degrees,
            raw,
            rotated,
            moved,
            runs: told,
            set_aside,
            worst,
            distances_px: (count <= MOST_DISTANCES).then(|| distances.clone()),
        };
        Ok(Compared { spread, distances, mean_rays: self.consensus.rays })
    }

    fn run_deviation(&self, of: &Calibration, chosen: &Chosen, lens: usize) -> RunDeviation {
        let count = chosen.order.len();
        let sizes = |deviations: &Deviations| -> Vec<f64> {
            deviations.px.iter().skip(lens).step_by(count).map(Vector2::norm).collect()
        };
        let rotated = sizes(&self.rotated);
        let at = (0..rotated.len()).max_by(|&a, &b| rotated[a].total_cmp(&rotated[b])).unwrap_or(0);
        RunDeviation {
            run: of.run.to_owned(),
            camera_id: of.camera_id,
            rms_px: rms(&rotated),
            raw_rms_px: rms(&sizes(&self.raw)),
            max_px: rotated[at],
            max_at: chosen.pixels[at].into(),
            rotation_deg: rotation_vector(&self.consensus.placements[lens].rotation)
                .norm()
                .to_degrees(),
        }
    }
}

/// The deviations of a run, in evenly spaced cells.
fn deviation_field<'a>(
    run: &RunDeviation,
    grid: &Grid,
    cells: &[usize],
    px: impl Iterator<Item = &'a Vector2<f64>>,
) -> DeviationField {
    /// More arrows are a thicket.
    const MOST_CELLS: usize = 320;
    let is_told = |cell: usize, pitch: usize| {
        [cell % grid.columns(), cell / grid.columns()].iter().all(|at| at % pitch == pitch / 2)
    };
    let is_enough =
        |pitch: &usize| cells.iter().filter(|cell| is_told(**cell, *pitch)).count() <= MOST_CELLS;
    let pitch = (1..).find(is_enough).unwrap_or(1);
    let told = cells.iter().zip(px).filter(|(cell, _)| is_told(**cell, pitch));
    let (cells, px) = told.map(|(cell, px)| (*cell, <[f64; 2]>::from(*px))).unzip();
    DeviationField { run: run.run.clone(), camera_id: run.camera_id, pitch, cells, px }
}

/// What a spread is told with, besides its numbers.
struct Frame {
    grid: Grid,
    size: [u64; 2],
    region: Region,
    set_aside: Vec<SetAside>,
}
