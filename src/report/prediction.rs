//! What the adjustments predict, in sentences.

use super::number;
use crate::stability::{Consistency, Direction, MOST_BIRGE, Parameter, ParameterClass, Population};

/// A parameter that takes less part in a direction than this share of its std is not named.
const LEAST_PART: f64 = 0.3;

/// The predicted spread, beside the observed one where there is one.
pub(super) fn predicted_words(population: &Population) -> Option<String> {
    let predicted = population.prediction.as_ref()?.spread.as_ref()?;
    let px = number::computed(predicted.rms_px);
    let Some(ratio) = predicted.observed_ratio else {
        let share = 100.0 * predicted.cell_share;
        return Some(format!(
            "By its adjustment, repeats of this run with other noise would spread by {px} px (turned, {share:.0} % of the image)"
        ));
    };
    let mut words = format!(
        "The adjustments predict a spread of {px} px, turned; it is {} times that",
        number::computed(ratio)
    );
    let corrected = predicted.independent_ratio.filter(|other| is_another(*other, ratio));
    if let Some(ratio) = corrected {
        words.push_str(&format!(", of independent runs {} times", number::computed(ratio)));
    }
    Some(words)
}

/// The Birge ratio, and what it can and cannot show.
pub(super) fn birge_words(population: &Population) -> Option<String> {
    let prediction = population.prediction.as_ref()?;
    let Consistency { degrees, found, independent, .. } = prediction.consistency.as_ref()?;
    let mut words = format!(
        "Birge ratio {:.2} (T = {} on {degrees} degrees, p = {})",
        found.birge,
        number::computed(found.statistic),
        number::probability(found.p)
    );
    let told = independent.unwrap_or(*found);
    if let Some(ratio) = independent.filter(|other| is_another(other.birge, found.birge)) {
        let p = number::probability(ratio.p);
        words
            .push_str(&format!(", corrected for what the runs share {:.2} (p = {p})", ratio.birge));
    }
    words.push_str(match told.birge > MOST_BIRGE {
        true => ": more varies between the runs than the noise of their keypoints",
        false => ": no sign of more than noise, and none of being right: what is wrong in all runs alike does not show in it",
    });
    Some(words)
}

/// Whether a number is worth being told beside another one.
fn is_another(value: f64, beside: f64) -> bool {
    (value / beside - 1.0).abs() > 0.005
}

/// What the mean covariance leaves most and least visible in the image.
pub(super) fn direction_words(population: &Population) -> Option<String> {
    let prediction = population.prediction.as_ref()?;
    let [strongest, .., weakest] = prediction.directions.as_slice() else { return None };
    let told = |direction| in_words(population, &prediction.parameters, direction);
    Some(format!(
        "One std by the adjustments: {} (the most visible change), and {} (the least)",
        told(strongest),
        told(weakest)
    ))
}

/// Such as "fx +1.9 % with k1 -0.03 moves the image by 0.02 px".
fn in_words(population: &Population, names: &[String], direction: &Direction) -> String {
    let changes = names.iter().zip(&direction.changes);
    let parts: Vec<String> = changes
        .filter_map(|(name, change)| {
            let parameter = population.parameters.iter().find(|one| one.name == *name)?;
            let is_named = change.abs() >= LEAST_PART * parameter.predicted_std?;
            is_named.then(|| format!("{name} {}", amount(parameter, *change)))
        })
        .collect();
    let px = number::std(direction.moves_px);
    format!("{} moves the image by {px} px", parts.join(" with "))
}

/// A focal length's change in percent, any other's in its own unit.
fn amount(parameter: &Parameter, change: f64) -> String {
    let sign = if change < 0.0 { '-' } else { '+' };
    let values: Vec<f64> = parameter.samples.iter().filter_map(|sample| sample.value).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let share = number::percent((change / mean).abs());
    let plain = number::std(change.abs());
    match parameter.class {
        ParameterClass::Focal => format!("{sign}{share}"),
        _ if parameter.unit.is_empty() => format!("{sign}{plain}"),
        _ => format!("{sign}{plain} {}", parameter.unit),
    }
}
