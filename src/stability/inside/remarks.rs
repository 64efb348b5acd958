//! What runs give away against themselves, as findings.

use super::held::{HeldClass, LEAST_EFFECT_PX, MOST_P};
use super::population::HeldTest;
use crate::stability::remarks::{of_camera, p_in_words};
use crate::stability::{Finding, FindingId, Population};

/// What there is to say of one population.
pub(in crate::stability) fn of_population(one: &Population) -> Vec<Finding> {
    one.held.iter().filter_map(|test| held(one, test)).collect()
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
