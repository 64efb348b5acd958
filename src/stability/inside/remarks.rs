//! What runs give away against themselves, as findings.

use super::held::{HeldClass, LEAST_EFFECT_PX, MOST_P};
use super::population::HeldTest;
use super::residuals::{Residuals, Tails};
use crate::stability::remarks::{of_camera, p_in_words};
use crate::stability::{Finding, FindingId, Population};

/// A pattern of less than this in the residuals makes no finding, however surely it is there. Lens models that are right leave 0.03
/// to 0.06 px in real keypoints (castle_p30 and euroc_v1_a with all intrinsics free); a missing radial term or a principal point
/// held 10 px off, which move the lens by 1 to 3 px, leave 0.15 to 0.25 px there, as poses and points take most of it.
pub(in crate::stability) const LEAST_PATTERN_PX: f64 = 0.1;
/// Sigma above this multiple of the robust sigma: about half of the sum of squares, which the adjustment made least, is then of points
/// that fit worse than normal noise would let them.
pub(in crate::stability) const MOST_SIGMA_RATIO: f64 = 1.4;

/// What there is to say of one population.
pub(in crate::stability) fn of_population(one: &Population) -> Vec<Finding> {
    let residuals = one.residuals.iter();
    let of_residuals = residuals.flat_map(|found| [pattern(one, found), tails(one, found)]);
    one.held.iter().map(|test| held(one, test)).chain(of_residuals).flatten().collect()
}

fn pattern(one: &Population, found: &Residuals) -> Option<Finding> {
    let Residuals { n, p, effect_px, sigma_px, .. } = found;
    let text = format!(
        "{}: the residuals have a pattern over the image of {effect_px:.2} px (RMS, noise of {sigma_px:.2} px removed; \
         {}, median of {n} runs): the lens model does not fit",
        one.camera,
        p_in_words(*p)
    );
    let is_found = *p < MOST_P && *effect_px > LEAST_PATTERN_PX;
    is_found.then(|| of_camera(FindingId::ResidualPattern, one, Vec::new(), text))
}

fn tails(one: &Population, found: &Residuals) -> Option<Finding> {
    let Tails { robust_sigma_px, sigma_ratio, beyond_share, p, .. } = found.tails?;
    let text = format!(
        "{}: {:.1} % of the points fit worse than all but 0.1 % should: they make sigma {sigma_ratio:.1} times \
         the {robust_sigma_px:.2} px of most",
        one.camera,
        100.0 * beyond_share
    );
    let is_found = p < MOST_P && sigma_ratio > MOST_SIGMA_RATIO;
    is_found.then(|| of_camera(FindingId::HeavyTails, one, Vec::new(), text))
}

fn held(one: &Population, test: &HeldTest) -> Option<Finding> {
    let px = test.effect_px.filter(|px| *px > LEAST_EFFECT_PX && test.p < MOST_P)?;
    let focal = test.focal_change.map_or(String::new(), |change| {
        format!(" and the focal length by {:+.2} %", 100.0 * change)
    });
    let moved: Vec<String> = test
        .parameters
        .iter()
        .filter(|parameter| test.freed.contains(&parameter.name))
        .map(|one| format!("{} {} to {}", one.name, short(one.before), short(one.after)))
        .collect();
    let what = match test.class {
        HeldClass::PrincipalPoint => "the held principal point",
        HeldClass::OneFocal => "one focal length for both directions",
        HeldClass::NextRadial => "a lens without the next radial term",
    };
    let (p, n, camera) = (p_in_words(test.p), test.n, &one.camera);
    let text = format!(
        "{camera}: {what} does not fit: freed, it moves the lens by {px:.2} px{focal} \
         ({}; {p}, median of {n} runs)",
        moved.join(", ")
    );
    Some(of_camera(FindingId::HeldParameter, one, Vec::new(), text))
}

/// Four significant digits.
fn short(value: f64) -> String {
    let rounded = format!("{value:.3e}").parse::<f64>();
    rounded.map_or_else(|_| value.to_string(), |rounded| rounded.to_string())
}
