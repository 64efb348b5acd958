//! Analyses to draw in tests, with the statistics that `stability` would give them.

use crate::stability::spread::{DeviationField, Region, Ring, RunDeviation, Spread, SpreadMeasure};
use crate::stability::{
    Analysis, Compensation, Correlations, Options, Parameter, ParameterClass, Population,
    Provenance, SCHEMA_VERSION, Sample, SampleState, Statistics, Verdict,
};
use crate::stats::{BoxPlot, Sorted, pearson};

/// One sample; `None` is a failed run.
pub type Value = Option<(SampleState, f64)>;

pub fn estimated(values: &[f64]) -> Vec<Value> {
    values.iter().map(|&value| Some((SampleState::Estimated, value))).collect()
}

pub fn held(value: f64, count: usize) -> Vec<Value> {
    vec![Some((SampleState::PresumedHeld, value)); count]
}

pub fn analysis(populations: Vec<Population>) -> Analysis {
    let provenance = Provenance { calibstab_version: "0".to_owned(), options: Options::default() };
    Analysis {
        schema_version: SCHEMA_VERSION,
        provenance,
        runs: Vec::new(),
        skipped: Vec::new(),
        populations,
        comparisons: Vec::new(),
        components: Vec::new(),
        findings: Vec::new(),
    }
}

pub fn parameter(name: &str, values: &[Value]) -> Parameter {
    let (class, unit) = match name.chars().next() {
        Some('f') => (ParameterClass::Focal, "px"),
        Some('c') => (ParameterClass::PrincipalPoint, "px"),
        _ => (ParameterClass::Extra, ""),
    };
    let is_estimated =
        |&(state, value): &(SampleState, f64)| state == SampleState::Estimated && value.is_finite();
    let sorted =
        Sorted::new(values.iter().flatten().filter(|v| is_estimated(v)).map(|v| v.1).collect());
    let statistics = sorted.as_ref().and_then(statistics);
    let box_plot = sorted.filter(|_| statistics.is_some()).map(|sorted| sorted.box_plot());
    let sample = |(index, value): (usize, &Value)| Sample {
        run: format!("run{index:02}"),
        camera_id: value.map(|_| 1),
        state: value.map_or(SampleState::Failed, |(state, _)| state),
        value: value.map(|(_, value)| value),
        predicted_std: None,
        is_outlier: value
            .filter(is_estimated)
            .zip(box_plot)
            .is_some_and(|((_, value), box_plot)| box_plot.is_outlier(value)),
    };
    let samples = values.iter().enumerate().map(sample).collect();
    let (name, unit) = (name.to_owned(), unit.to_owned());
    Parameter { name, class, unit, samples, statistics, predicted_std: None }
}

/// A population with a compensation of every focal length and distortion that vary.
pub fn population(
    group: &str,
    camera: &str,
    model: &str,
    parameters: Vec<Parameter>,
) -> Population {
    let of =
        |class| parameters.iter().filter(move |parameter: &&Parameter| parameter.class == class);
    let compensation = of(ParameterClass::Focal)
        .flat_map(|focal| {
            of(ParameterClass::Extra).map(move |distortion| compensation(focal, distortion))
        })
        .filter(|entry| entry.n > 0)
        .collect();
    let [group, camera, model] = [group, camera, model].map(str::to_owned);
    Population {
        group,
        camera,
        model,
        width: 752,
        height: 480,
        verdict: Verdict::default(),
        ray_share: Some(1.0),
        folds: Some(false),
        parameters,
        compensation,
        correlations: Correlations::default(),
        prediction: None,
        held: vec![],
        residuals: None,
        spread: None,
        without_spread: None,
        clusters: None,
        overlap: None,
        predicted_correlations: None,
        as_left: None,
    }
}

fn statistics(sample: &Sorted) -> Option<Statistics> {
    let BoxPlot { q1, q3, whiskers } = sample.box_plot();
    Some(Statistics {
        n: sample.n(),
        mean: sample.mean(),
        std: sample.std()?,
        std_px: Some(sample.std()? * 2.0),
        relative_std: Some(sample.std()? / sample.mean().abs()),
        std_interval_95: [0.0, 0.0],
        min: sample.min(),
        q1,
        median: sample.median(),
        q3,
        max: sample.max(),
        mad_std: sample.mad_std(),
        whiskers,
    })
}

fn compensation(focal: &Parameter, distortion: &Parameter) -> Compensation {
    let pairs: Vec<[f64; 2]> = focal
        .samples
        .iter()
        .zip(&distortion.samples)
        .filter(|(x, y)| [x, y].iter().all(|sample| sample.state == SampleState::Estimated))
        .filter_map(|(x, y)| Some([x.value?, y.value?]))
        .collect();
    let (n, correlation) = (pairs.len(), pearson(&pairs));
    Compensation { focal: focal.name.clone(), distortion: distortion.name.clone(), n, correlation }
}

/// A spread of three runs over those cells of the image, of 60 columns, that have a height in px there, given the px of their
/// middles. The odd run is off by a third of it, downwards.
pub fn spread_over([width, height]: [u64; 2], map: impl Fn([f64; 2]) -> Option<f64>) -> Spread {
    let rows = usize::try_from(60 * height / width).unwrap().max(1);
    let middle = |cell: usize| {
        let at = [cell % 60, cell / 60].map(|index| index as f64 + 0.5);
        [at[0] * width as f64 / 60.0, at[1] * height as f64 / rows as f64]
    };
    let (cells, map_px): (Vec<usize>, Vec<f64>) =
        (0..60 * rows).filter_map(|cell| Some((cell, map(middle(cell))?))).unzip();
    let max_px = map_px.iter().copied().fold(0.0, f64::max);
    let rms_px = 0.7 * max_px;
    let told: Vec<usize> = (0..cells.len()).filter(|at| at % 9 == 4).collect();
    let measure = SpreadMeasure {
        rms_px,
        p95_px: 0.9 * max_px,
        max_px,
        max_at: [0.5, 0.5],
        rms_deg: 0.0,
        p95_deg: 0.0,
        max_deg: 0.0,
        median_based_px: rms_px,
        map_px: map_px.clone(),
    };
    Spread {
        n: 3,
        region: Region::All,
        columns: 60,
        rows,
        cell_share: cells.len() as f64 / (60 * rows) as f64,
        masked_cells: Vec::new(),
        observation_counts: None,
        raw: measure.clone(),
        degrees: 2.0,
        rotated_interval_95: [0.52, 6.3].map(|factor| factor * rms_px),
        rotated: measure,
        moved: None,
        runs: ["run1", "odd", "run3"].map(|run| run_deviation(run, max_px)).to_vec(),
        set_aside: Vec::new(),
        worst: DeviationField {
            run: "odd".to_owned(),
            camera_id: 1,
            pitch: 3,
            cells: told.iter().map(|&at| cells[at]).collect(),
            px: told.iter().map(|&at| [0.0, map_px[at] / 3.0]).collect(),
        },
        radial_profile: (0..10_u8)
            .map(|ring| Ring {
                radius_px: width as f64 / 20.0 * (f64::from(ring) + 0.5),
                cell_count: 7,
                raw_rms_px: max_px * f64::from(ring) / 9.0,
                rms_px: max_px * f64::from(ring) / 10.0,
            })
            .collect(),
        distances_px: None,
        cells,
    }
}

fn run_deviation(run: &str, max_px: f64) -> RunDeviation {
    RunDeviation {
        run: run.to_owned(),
        camera_id: 1,
        rms_px: 0.7 * max_px,
        raw_rms_px: 0.7 * max_px,
        max_px,
        max_at: [0.5, 0.5],
        rotation_deg: 0.0,
    }
}
