//! What is to be said of a population's spread, of its parts and of what its runs share.

use super::super::overlap::MOST_SHARED;
use super::super::remarks::{listed, of_camera};
use super::super::verdict::calibration_count;
use super::super::{Finding, FindingId, Part, Population};

/// Everything that a population's disagreement calls for.
pub(in crate::stability) fn of_population(one: &Population) -> Vec<Finding> {
    let mut findings = Vec::new();
    if one.spread.is_none() && calibration_count(one) > 1 {
        let reason = one.without_spread.as_deref();
        let reason =
            reason.unwrap_or("fewer than two of its calibrations have rays where the others have");
        let text = format!("{}: no spread in px: {reason}", one.camera);
        findings.push(of_camera(FindingId::NoSpread, one, Vec::new(), text));
    }
    findings.extend(set_aside(one));
    findings.extend(parts(one));
    findings.extend(shared_observations(one));
    findings
}

fn set_aside(one: &Population) -> Vec<Finding> {
    let aside = one.spread.iter().flat_map(|spread| &spread.set_aside);
    let finding = |aside: &super::super::spread::SetAside| {
        let text = format!(
            "{}: the lens of {} sees nothing in {:.0} % of what the other runs see: it is left out of the spread",
            one.camera,
            aside.run,
            (100.0 * aside.without_ray).max(1.0)
        );
        of_camera(FindingId::OutlierRun, one, vec![aside.run.clone()], text)
    };
    aside.map(finding).collect()
}

fn parts(one: &Population) -> Vec<Finding> {
    let (Some(clusters), Some(spread)) = (&one.clusters, &one.spread) else { return Vec::new() };
    let compared = clusters.parts.iter().filter(|part| part.gap_px.is_some());
    let (basins, lone): (Vec<&Part>, Vec<&Part>) = compared.partition(|part| part.runs.len() > 1);
    let mut findings = Vec::new();
    let without = clusters.parts[0].spread_px.map_or(String::new(), |[_, rotated]| {
        format!(", {rotated:.2} px among the {} that agree", clusters.parts[0].runs.len())
    });
    for part in &lone {
        let text = format!(
            "{}: {} is {:.2} px away from every other run; the spread is {:.2} px with all{without}",
            one.camera,
            listed(&part.runs),
            part.gap_px.unwrap_or_default(),
            spread.rotated.rms_px
        );
        findings.push(of_camera(FindingId::OutlierRun, one, part.runs.clone(), text));
    }
    if basins.len() > 1 {
        let told = basins.iter().map(|part| {
            let px = part.spread_px.map_or(0.0, |[_, rotated]| rotated);
            format!("{} ({px:.2} px among them)", listed(&part.runs))
        });
        let gap = basins.iter().filter_map(|part| part.gap_px).fold(f64::INFINITY, f64::min);
        let text = format!(
            "{}: its runs settled in {} places at least {gap:.2} px apart: {}; one mean describes none of them",
            one.camera,
            basins.len(),
            told.collect::<Vec<_>>().join(" and "),
        );
        findings.push(of_camera(FindingId::Clusters, one, Vec::new(), text));
    }
    findings
}

fn shared_observations(one: &Population) -> Option<Finding> {
    let overlap = one.overlap.as_ref().filter(|overlap| overlap.shared_fraction > MOST_SHARED)?;
    let text = format!(
        "{}: its runs share {:.0} % of their observations: these repeats show the solver's repeatability only",
        one.camera,
        100.0 * overlap.shared_fraction
    );
    Some(of_camera(FindingId::SharedObservations, one, Vec::new(), text))
}
