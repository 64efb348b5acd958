//! From lenses to errors: how far each is off over the image, and what of that is bias and what spread.

use std::collections::BTreeMap;

use super::super::candidates::CELLS_PER_PART;
use super::ground::Ground;
use super::result::{CameraCell, Cell, ErrorParts, ScoredSample};
use super::sample::Sample;
use crate::camera::Grid;
use crate::scene::{Camera, CameraId};
use crate::stability::Statistics;
use crate::stability::spread::{
    Calibration, Difference, DifferenceMeasure, SpreadError, difference,
};
use crate::stats::{Sorted, rms_interval};

/// A lens without a ray in more than this share of what the full reconstruction observed is no calibration of it.
const MOST_WITHOUT_RAY: f64 = 0.1;
const CONFIDENCE: f64 = 0.95;

/// The same heuristic, model and size: its samples with their errors, and what they show together.
pub(super) fn scored(
    ground: &Ground,
    samples: &[Sample],
    is_independent: bool,
) -> (Vec<ScoredSample>, Cell) {
    let mut scored = Vec::with_capacity(samples.len());
    let mut found: Vec<Vec<Off>> = Vec::new();
    let all_cells = ground.all_cells();
    for sample in samples {
        let mut sample = sample.clone();
        let off = if sample.failure.is_none() {
            ground.off(&sample, &all_cells)
        } else {
            Err(String::new())
        };
        let squares = |of: &dyn Fn(&Difference) -> f64, off: &[Off]| {
            let sum: f64 = off.iter().map(|off| of(&off.difference).powi(2)).sum();
            (sum / off.len() as f64).sqrt()
        };
        let (mut error_px, mut raw_error_px) = (None, None);
        match off {
            Ok(off) => {
                error_px = Some(squares(&|it| it.rotated.rms_px, &off));
                raw_error_px = Some(squares(&|it| it.raw.rms_px, &off));
                found.push(off);
            }
            Err(failure) => {
                sample.failure = sample.failure.or(Some(failure));
                sample.cameras.clear();
            }
        }
        scored.push(ScoredSample { sample, error_px, raw_error_px });
    }
    let cell = cell(ground, &scored, &found, is_independent);
    (scored, cell)
}

/// How far a camera is off.
struct Off {
    difference: Difference,
    /// From the full reconstruction, where that is not what it is compared with.
    from_full: Option<Difference>,
}

impl Ground {
    /// How far each camera of a sample is off, or why that cannot be told.
    fn off(&self, sample: &Sample, all_cells: &[Option<usize>]) -> Result<Vec<Off>, String> {
        let off = |(id, params, all): (CameraId, &[f64], Option<usize>)| {
            let full = self.refined[&id];
            let intrinsics = full.intrinsics.model().with_params(params);
            let intrinsics = intrinsics.map_err(|error| error.to_string())?;
            let own = Camera { intrinsics, ..full };
            let difference = |from: &Camera, to: &Camera| {
                let found =
                    difference(&self.calibration(id, from), &self.calibration(id, to), None);
                found.map_err(|error: SpreadError| error.to_string())
            };
            let reference = &self.references[&id];
            let found = difference(reference, &own)?;
            let all = all.ok_or("what it is compared with has no ray")?;
            let missing = 1.0 - found.cells.len() as f64 / all as f64;
            if missing > MOST_WITHOUT_RAY {
                let percent = 100.0 * missing;
                return Err(format!(
                    "camera {id} has no ray in {percent:.0} % of what was observed"
                ));
            }
            let from_full = self.has_truth.then(|| difference(&full, &own)).transpose()?;
            Ok(Off { difference: found, from_full })
        };
        let cameras = sample.cameras.iter();
        let cameras = cameras.zip(all_cells);
        cameras.map(|(it, all)| off((CameraId(it.camera_id), &it.params, *all))).collect()
    }

    /// In how many cells each wanted camera can be compared at most.
    fn all_cells(&self) -> Vec<Option<usize>> {
        let count = |(id, reference): (&CameraId, &Camera)| {
            let own = self.calibration(*id, reference);
            difference(&own, &own, None).ok().map(|it| it.cells.len())
        };
        self.references.iter().map(count).collect()
    }

    /// The free parameters of a camera over the repeats.
    fn parameters(&self, id: CameraId, scored: &[ScoredSample]) -> Vec<(String, Statistics)> {
        let own = |scored: &ScoredSample, place: usize| {
            let camera = scored.sample.cameras.iter().find(|it| it.camera_id == id.0)?;
            camera.params.get(place).copied()
        };
        let free = self.candidates.params().iter().filter(|param| param.camera == id);
        free.filter_map(|param| {
            let values = scored.iter().filter_map(|it| own(it, param.place)).collect();
            Some((param.name.to_owned(), Statistics::of(&Sorted::new(values)?)?))
        })
        .collect()
    }

    /// How many of the images chosen see something in each part of a camera's image, mean over the repeats.
    fn coverage(&self, id: CameraId, scored: &[ScoredSample]) -> Vec<f64> {
        let [columns, rows] = parts_of(&self.refined[&id]);
        let mut counts = vec![0.0; columns * rows];
        let images = scored.iter().flat_map(|it| &it.sample.images);
        for &image in images.filter(|image| self.candidates.camera(**image) == id) {
            self.candidates.cells_of[image].iter().for_each(|&part| counts[part] += 1.0);
        }
        counts.into_iter().map(|count| count / scored.len() as f64).collect()
    }

    fn calibration<'a>(&self, id: CameraId, camera: &'a Camera) -> Calibration<'a> {
        let view = self.views.get(&id).cloned();
        Calibration { run: "", camera_id: id.0, camera, is_flagged: false, view }
    }
}

fn cell(
    ground: &Ground,
    scored: &[ScoredSample],
    found: &[Vec<Off>],
    is_independent: bool,
) -> Cell {
    let of_camera = |(at, id): (usize, &CameraId)| {
        let own: Vec<&Off> = found.iter().map(|off| &off[at]).collect();
        let parts = |of: fn(&Difference) -> &DifferenceMeasure| {
            parts(&own.iter().map(|off| (&off.difference, of(&off.difference))).collect::<Vec<_>>())
        };
        let from_full: Option<Vec<_>> =
            own.iter().map(|off| off.from_full.as_ref().map(|it| (it, &it.rotated))).collect();
        Some(CameraCell {
            camera_id: id.0,
            error: parts(|it| &it.rotated)?,
            raw: parts(|it| &it.raw)?,
            bias_from_full_px: from_full.and_then(|all| Some(self::parts(&all)?.bias_px)),
            parameters: ground.parameters(*id, scored),
            coverage: ground.coverage(*id, scored),
        })
    };
    let cameras: Vec<CameraCell> = ground.wanted.iter().enumerate().filter_map(of_camera).collect();
    let squares: Vec<f64> = scored.iter().filter_map(|it| Some(it.error_px?.powi(2))).collect();
    let held_out = scored.iter().filter_map(|it| it.sample.held_out_px).collect();
    let first = &scored[0].sample;
    let times_chosen = |image: usize| {
        let has = |it: &&ScoredSample| it.sample.images.binary_search(&image).is_ok();
        scored.iter().filter(has).count()
    };
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    for reason in scored.iter().filter_map(|it| it.sample.failure.as_deref()) {
        *reasons.entry(reason).or_default() += 1;
    }
    Cell {
        model: first.draw.model,
        size: first.draw.size,
        heuristic: first.heuristic.clone(),
        n: found.len(),
        failures: scored.len() - found.len(),
        error: joined(cameras.iter().map(|it| it.error)),
        interval_95: is_independent.then(|| rms_interval(&squares, CONFIDENCE)).flatten(),
        raw: joined(cameras.iter().map(|it| it.raw)),
        held_out_px: Sorted::new(held_out).map(|sorted| sorted.median()),
        overlap: overlap(scored),
        cameras,
        chosen: (0..ground.candidates.image_count()).map(times_chosen).collect(),
        reasons: reasons.into_iter().map(|(reason, count)| (reason.to_owned(), count)).collect(),
    }
}

/// Columns and rows of the parts of a camera's image.
pub(super) fn parts_of(camera: &Camera) -> [usize; 2] {
    let grid = Grid::new(camera.width, camera.height);
    [grid.columns(), grid.rows()].map(|count| count.div_ceil(CELLS_PER_PART))
}

/// Bias and spread of fields over the cells that all of them have.
fn parts(fields: &[(&Difference, &DifferenceMeasure)]) -> Option<ErrorParts> {
    let (first, _) = fields.first()?;
    let mut times = vec![0_usize; first.columns * first.rows];
    fields.iter().flat_map(|(it, _)| &it.cells).for_each(|&cell| times[cell] += 1);
    let count = fields.len() as f64;
    let mut sums = vec![[0.0; 2]; times.len()];
    let mut squares = 0.0;
    let common = |it: &Difference, px: &DifferenceMeasure| {
        let both = it.cells.iter().copied().zip(px.px.iter().copied());
        both.filter(|(cell, _)| times[*cell] == fields.len()).collect::<Vec<_>>()
    };
    let own: Vec<Vec<(usize, [f64; 2])>> = fields.iter().map(|(it, px)| common(it, px)).collect();
    for &(cell, [x, y]) in own.iter().flatten() {
        sums[cell] = [sums[cell][0] + x / count, sums[cell][1] + y / count];
        squares += x * x + y * y;
    }
    let cells = own[0].len() as f64;
    let bias = own[0].iter().map(|(cell, _)| sums[*cell]).map(|[x, y]| x * x + y * y).sum::<f64>();
    let deviations: f64 = own
        .iter()
        .flatten()
        .map(|&(cell, [x, y])| (x - sums[cell][0]).powi(2) + (y - sums[cell][1]).powi(2))
        .sum();
    (cells > 0.0).then(|| ErrorParts {
        rms_px: (squares / cells / count).sqrt(),
        bias_px: (bias / cells).sqrt(),
        spread_px: (count > 1.0).then(|| (deviations / cells / (count - 1.0)).sqrt()),
    })
}

/// Over cameras: roots of mean squares.
fn joined(parts: impl Iterator<Item = ErrorParts> + Clone) -> Option<ErrorParts> {
    let count = parts.clone().count() as f64;
    let root = |of: &dyn Fn(&ErrorParts) -> Option<f64>| {
        let squares: Option<f64> = parts.clone().map(|it| Some(of(&it)?.powi(2))).sum();
        squares.map(|sum| (sum / count).sqrt())
    };
    (count > 0.0).then_some(())?;
    Some(ErrorParts {
        rms_px: root(&|it| Some(it.rms_px))?,
        bias_px: root(&|it| Some(it.bias_px))?,
        spread_px: root(&|it| it.spread_px),
    })
}

/// The share of their images that two choices have in common, mean over all pairs.
fn overlap(scored: &[ScoredSample]) -> Option<f64> {
    let chosen: Vec<&[usize]> =
        scored.iter().map(|it| &*it.sample.images).filter(|it| !it.is_empty()).collect();
    let (mut sum, mut count) = (0.0, 0.0);
    for (at, one) in chosen.iter().enumerate() {
        for other in &chosen[..at] {
            let both = one.iter().filter(|image| other.binary_search(image).is_ok()).count();
            sum += both as f64 / one.len().min(other.len()) as f64;
            count += 1.0;
        }
    }
    (count > 0.0).then_some(sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(px: &[[f64; 2]]) -> (Difference, DifferenceMeasure) {
        let measure = DifferenceMeasure {
            rms_px: 0.0,
            p95_px: 0.0,
            max_px: 0.0,
            max_at: [0.0; 2],
            px: px.to_vec(),
        };
        let difference = Difference {
            from: String::new(),
            to: String::new(),
            columns: px.len(),
            rows: 1,
            cells: (0..px.len()).collect(),
            cell_share: 1.0,
            raw: measure.clone(),
            rotated: measure.clone(),
            rotation_deg: [0.0; 3],
            rotation_angle_deg: 0.0,
        };
        (difference, measure)
    }

    #[test]
    fn bias_and_spread_add_up_to_the_error() {
        let fields = [field(&[[3.0, 0.0], [0.0, 1.0]]), field(&[[1.0, 0.0], [0.0, 5.0]])];
        let parts = parts(&fields.iter().map(|(it, px)| (it, px)).collect::<Vec<_>>()).unwrap();
        // Means 2 and 3; deviations of 1 and 2 either way.
        assert!((parts.bias_px - 6.5_f64.sqrt()).abs() < 1e-14);
        assert!((parts.spread_px.unwrap() - 5.0_f64.sqrt()).abs() < 1e-14);
        assert!((parts.rms_px - 9.0_f64.sqrt()).abs() < 1e-14);
        let n = 2.0;
        let both = parts.bias_px.powi(2) + (n - 1.0) / n * parts.spread_px.unwrap().powi(2);
        assert!((parts.rms_px.powi(2) - both).abs() < 1e-12);
    }

    #[test]
    fn a_cell_that_one_lacks_counts_for_none() {
        let mut fields = [field(&[[3.0, 0.0], [0.0, 1.0]]), field(&[[1.0, 0.0], [0.0, 5.0]])];
        fields[1].0.cells = vec![0];
        fields[1].1.px = vec![[1.0, 0.0]];
        let parts = parts(&fields.iter().map(|(it, px)| (it, px)).collect::<Vec<_>>()).unwrap();
        assert!((parts.bias_px - 2.0).abs() < 1e-14);
        assert!((parts.spread_px.unwrap() - 2.0_f64.sqrt()).abs() < 1e-14);
    }
}
