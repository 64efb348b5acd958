//! Samples to statistics: what is known of each sample, and the summary of those that were estimated.

use super::refinement::Origin;
use super::run::CameraInRun;
use super::{Compensation, Parameter, ParameterClass, Run, Sample, SampleState, Statistics};
use crate::camera::{Model, Param, ParamClass};
use crate::scene::Camera;
use crate::stats::{Sorted, pearson, std_interval_factors};

/// A mean is far from zero, and a relative standard deviation means something, when all samples have its sign and it is at
/// least this many standard deviations away.
const FAR_FROM_ZERO: f64 = 2.0;

/// One sample's place: the run, and its camera unless the run lacks it.
pub(super) type Place<'a> = (&'a Run, Option<&'a CameraInRun<'a>>);

/// The parameters of one population.
pub(super) fn parameters(model: &'static Model, places: &[Place]) -> Vec<Parameter> {
    let mut coordinates = 0;
    let parameter = |(index, param): (usize, &Param)| {
        let value = |camera: &Camera| camera.intrinsics.params().get(index).copied();
        let values: Vec<Option<f64>> =
            places.iter().map(|(_, camera)| value(camera.as_ref()?.calibration()?)).collect();
        let is_centred = param.class == ParamClass::PrincipalPoint && {
            coordinates += 1;
            let is_x = coordinates == 1;
            places
                .iter()
                .all(|(_, camera)| camera.is_none_or(|c| is_at_centre(c.camera, index, is_x)))
        };
        let is_held = is_centred || param.class == ParamClass::Metadata;
        let known = places.iter().map(|(_, camera)| known_state(camera.as_ref()?, index));
        let guessed = states(&values, is_held);
        let states = known.zip(guessed).map(|(known, guessed)| known.unwrap_or(guessed)).collect();
        summarised((index, param), places, &values, states)
    };
    model.params.iter().enumerate().map(parameter).collect()
}

/// Whether this coordinate of the principal point is exactly at the centre of the image: bits must match.
fn is_at_centre(camera: &Camera, index: usize, is_x: bool) -> bool {
    let side = if is_x { camera.width } else { camera.height };
    let centre = side as f64 / 2.0;
    camera.intrinsics.params().get(index).is_some_and(|value| value.to_bits() == centre.to_bits())
}

/// What our own refinement knows of the sample of a parameter; nothing where values are as COLMAP left them.
fn known_state(camera: &CameraInRun, index: usize) -> Option<SampleState> {
    match &camera.origin {
        Origin::Left => None,
        Origin::Refined { free, .. } if free.contains(&index) => Some(SampleState::Estimated),
        Origin::Refined { .. } => Some(SampleState::Held),
        Origin::Failed => Some(SampleState::Failed),
    }
}

fn summarised(
    (index, param): (usize, &Param),
    places: &[Place],
    values: &[Option<f64>],
    states: Vec<SampleState>,
) -> Parameter {
    let estimated = values.iter().zip(&states);
    let estimated: Vec<f64> = estimated
        .filter(|(_, state)| **state == SampleState::Estimated)
        .filter_map(|(v, _)| *v)
        .collect();
    let sorted = Sorted::new(estimated);
    let statistics = sorted.as_ref().and_then(Statistics::of);
    let box_plot = sorted.filter(|_| statistics.is_some()).map(|sorted| sorted.box_plot());
    let samples =
        places.iter().zip(values.iter().zip(states)).map(|((run, camera), (value, state))| {
            let is_outlier = state == SampleState::Estimated
                && value.zip(box_plot).is_some_and(|(value, box_plot)| box_plot.is_outlier(value));
            let camera_id = camera.map(|camera| camera.id.0);
            let predicted_std = camera.and_then(|camera| camera.origin.predicted_std(index));
            let (run, value) = (run.name.clone(), *value);
            Sample { run, camera_id, state, value, predicted_std, is_outlier }
        });
    let samples: Vec<Sample> = samples.collect();
    let (name, unit) = (param.name.to_owned(), param.unit.to_owned());
    let predicted_std = predicted_std(&samples);
    Parameter { name, class: param.class.into(), unit, samples, statistics, predicted_std }
}

/// RMS of what the adjustments predict of the samples that were estimated: the root of the mean variance. Summed in the order of
/// size, as names say nothing.
fn predicted_std(samples: &[Sample]) -> Option<f64> {
    let estimated = samples.iter().filter(|sample| sample.state == SampleState::Estimated);
    let stds: Vec<f64> = estimated.map(|sample| sample.predicted_std).collect::<Option<_>>()?;
    Some(Sorted::new(stds.into_iter().map(|std| std * std).collect())?.mean().sqrt())
}

/// What is known of each sample of one parameter. No two runs of a population are copies of each other: so two equal values
/// are a value that was not refined, as no estimate repeats to the last bit.
fn states(values: &[Option<f64>], is_held: bool) -> Vec<SampleState> {
    let mut bits: Vec<u64> = values.iter().flatten().map(|value| value.to_bits()).collect();
    bits.sort_unstable();
    let count = |value: f64| {
        let bits_of_value = value.to_bits();
        bits.partition_point(|&b| b <= bits_of_value) - bits.partition_point(|&b| b < bits_of_value)
    };
    let state = |value: f64| match count(value) {
        _ if is_held => SampleState::PresumedHeld,
        1 if bits.len() == 1 => SampleState::Unknown,
        1 => SampleState::Estimated,
        _ => SampleState::PresumedHeld,
    };
    values.iter().map(|value| value.map_or(SampleState::Failed, state)).collect()
}

impl Statistics {
    /// Of a sample, its effect on the image left open; none for a single value.
    pub fn of(sample: &Sorted) -> Option<Self> {
        let (mean, std) = (sample.mean(), sample.std()?);
        let factors = std_interval_factors(sample.n(), 0.95)?;
        let has_one_sign = sample.min() > 0.0 || sample.max() < 0.0;
        let is_far_from_zero = has_one_sign && mean.abs() >= FAR_FROM_ZERO * std;
        let box_plot = sample.box_plot();
        Some(Self {
            n: sample.n(),
            mean,
            std,
            std_px: None,
            relative_std: is_far_from_zero.then(|| std / mean.abs()),
            std_interval_95: factors.map(|factor| factor * std),
            min: sample.min(),
            q1: box_plot.q1,
            median: sample.median(),
            q3: box_plot.q3,
            max: sample.max(),
            mad_std: sample.mad_std(),
            whiskers: box_plot.whiskers,
        })
    }
}

/// How every estimated distortion parameter went with the first estimated focal length.
pub(super) fn compensation(parameters: &[Parameter]) -> Vec<Compensation> {
    let has_samples = |parameter: &&Parameter| parameter.statistics.is_some();
    let of_class = |class| parameters.iter().filter(move |p| p.class == class).filter(has_samples);
    let Some(focal) = of_class(ParameterClass::Focal).next() else { return Vec::new() };
    of_class(ParameterClass::Extra)
        .map(|distortion| {
            let pairs: Vec<[f64; 2]> = estimated(focal)
                .zip(estimated(distortion))
                .filter_map(|(focal, distortion)| Some([focal?, distortion?]))
                .collect();
            Compensation {
                focal: focal.name.clone(),
                distortion: distortion.name.clone(),
                n: pairs.len(),
                correlation: pearson(&pairs),
            }
        })
        .collect()
}

/// The value of each sample that was estimated.
fn estimated(parameter: &Parameter) -> impl Iterator<Item = Option<f64>> {
    parameter
        .samples
        .iter()
        .map(|sample| sample.value.filter(|_| sample.state == SampleState::Estimated))
}

impl From<ParamClass> for ParameterClass {
    fn from(class: ParamClass) -> Self {
        match class {
            ParamClass::Focal => Self::Focal,
            ParamClass::PrincipalPoint => Self::PrincipalPoint,
            ParamClass::Extra => Self::Extra,
            ParamClass::Metadata => Self::Metadata,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use SampleState::{Estimated, Failed, PresumedHeld, Unknown};

    #[test]
    fn equal_bits_are_held_and_the_rest_is_estimated() {
        let values = [Some(1.5), Some(1.5), None, Some(1.25), Some(1.0)];
        let want = [PresumedHeld, PresumedHeld, Failed, Estimated, Estimated];
        assert_eq!(states(&values, false), want);
    }

    #[test]
    fn one_run_cannot_tell_unless_the_value_is_a_centre() {
        assert_eq!(states(&[Some(1.5), None], false), [Unknown, Failed]);
        assert_eq!(states(&[Some(1.5)], true), [PresumedHeld]);
    }

    #[test]
    fn a_mean_near_zero_has_no_relative_std() {
        let relative = |values: [f64; 3]| {
            Statistics::of(&Sorted::new(values.to_vec()).unwrap()).unwrap().relative_std
        };
        assert_eq!(relative([10.0, 11.0, 12.0]), Some(1.0 / 11.0));
        assert_eq!(relative([-12.0, -11.0, -10.0]), Some(1.0 / 11.0));
        assert_eq!(relative([-1.0, 0.5, 1.0]), None);
        assert_eq!(relative([0.1, 1.0, 5.0]), None);
    }
}
