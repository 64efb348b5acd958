//! The verdicts on the cameras, which stand before all else.

use std::fmt::Write;

use anstyle::{AnsiColor, Style};

use super::table::escaped;
use super::{number, sections};
use crate::stability::{Analysis, Finding, Population, Verdict, VerdictKind};

/// Of more cameras than this a terminal names the reasons only.
const MOST_REASONED: usize = 12;

const LIMITS_OF_IT: &str = "Repeatable is not right: what is wrong in all runs alike shows in no spread, and takes a known calibration \
    (`calibstab compare --reference`). `calibstab explain ID` says more of a reason.";

/// Every verdict and its reasons, for a terminal; nothing without a camera.
pub(super) fn terminal(analysis: &Analysis) -> String {
    let mut out = String::new();
    let (bold, faint) = (Style::new().bold(), Style::new().dimmed());
    let _ = writeln!(out, "{bold}Verdict{bold:#}");
    for one in &analysis.populations {
        let style = style(one.verdict.kind);
        let title = sections::population_title(one);
        let _ = write!(out, "  {title}: {style}{}{style:#}", words(&one.verdict));
        let reasons = &one.verdict.reasons;
        if analysis.populations.len() > MOST_REASONED {
            let ids: Vec<&str> = reasons.iter().map(|reason| reason.id.name()).collect();
            let _ = writeln!(out, "{}{}", if ids.is_empty() { "" } else { ": " }, ids.join(", "));
            continue;
        }
        out.push('\n');
        for reason in reasons {
            let _ = writeln!(out, "    - {}: {}", reason.id.name(), reason.text);
        }
    }
    let _ = writeln!(out, "{faint}{LIMITS_OF_IT}{faint:#}\n");
    if analysis.populations.is_empty() { String::new() } else { out }
}

/// The same in Markdown.
pub(super) fn markdown(analysis: &Analysis) -> String {
    let mut out = String::from("\n## Verdict\n\n");
    for one in &analysis.populations {
        let title = escaped(&sections::population_title(one));
        let _ = writeln!(out, "- {title}: **{}**", words(&one.verdict));
        for reason in &one.verdict.reasons {
            let _ = writeln!(out, "  - `{}`: {}", reason.id.name(), escaped(&reason.text));
        }
    }
    let _ = writeln!(out, "\n{LIMITS_OF_IT}");
    if analysis.populations.is_empty() { String::new() } else { out }
}

/// Whether a finding stands among the reasons of a verdict, and need not be said again.
pub(super) fn is_reason(analysis: &Analysis, finding: &Finding) -> bool {
    let is_about = |one: &&Population| {
        finding.group.as_ref() == Some(&one.group) && finding.camera.as_ref() == Some(&one.camera)
    };
    let mut about = analysis.populations.iter().filter(is_about);
    about.any(|one| one.verdict.reasons.iter().any(|reason| reason.id == finding.id))
}

/// A verdict without its reasons.
fn words(verdict: &Verdict) -> String {
    let Verdict { kind, n, spread_px, spread_interval_95, .. } = verdict;
    let interval = spread_interval_95.map_or(String::new(), |interval| {
        let [low, high] = interval.map(number::std);
        format!("95 %: {low} .. {high} px, ")
    });
    let basis = format!("({interval}n = {n})");
    let px = spread_px.map(number::std);
    match (kind, px) {
        (VerdictKind::Repeatable, Some(px)) => format!("repeatable to {px} px {basis}"),
        (VerdictKind::Repeatable, None) => format!("repeatable {basis}"),
        (VerdictKind::Doubtful, Some(px)) => format!("doubtful, spread {px} px {basis}"),
        (VerdictKind::Doubtful, None) => format!("doubtful {basis}"),
        (VerdictKind::NotDetermined, _) => format!("not determined (n = {n})"),
    }
}

fn style(kind: VerdictKind) -> Style {
    let color = match kind {
        VerdictKind::Repeatable => AnsiColor::Green,
        VerdictKind::Doubtful => AnsiColor::Yellow,
        VerdictKind::NotDetermined => AnsiColor::Red,
    };
    Style::new().bold().fg_color(Some(color.into()))
}

#[cfg(test)]
mod tests {
    use super::super::plot::test_data::{analysis, population};
    use super::*;
    use crate::stability::{FindingId, Reason};

    fn verdict(kind: VerdictKind, ids: &[FindingId]) -> Verdict {
        let reason = |id: &FindingId| Reason { id: *id, text: format!("why_{}", id.name()) };
        let (spread_px, spread_interval_95) = (Some(0.6913), Some([0.43, 1.72]));
        Verdict {
            kind,
            n: 6,
            spread_px,
            spread_interval_95,
            reasons: ids.iter().map(reason).collect(),
        }
    }

    fn judged(group: &str, verdict: Verdict) -> Population {
        Population { verdict, ..population(group, "camera 1", "OPENCV", vec![]) }
    }

    fn plain(text: &str) -> String {
        anstream::adapter::strip_str(text).to_string()
    }

    #[test]
    fn a_verdict_says_its_interval_its_n_and_its_reasons() {
        let doubtful = verdict(VerdictKind::Doubtful, &[FindingId::Clusters, FindingId::Fold]);
        let none = Verdict { n: 1, ..Verdict::default() };
        let analysis = analysis(vec![
            judged("a", verdict(VerdictKind::Repeatable, &[])),
            judged("b", doubtful),
            judged("c", none),
        ]);
        let shown = plain(&terminal(&analysis));
        let want = "\
Verdict
  a: camera 1, OPENCV 752 x 480: repeatable to 0.69 px (95 %: 0.43 .. 1.7 px, n = 6)
  b: camera 1, OPENCV 752 x 480: doubtful, spread 0.69 px (95 %: 0.43 .. 1.7 px, n = 6)
    - clusters: why_clusters
    - fold: why_fold
  c: camera 1, OPENCV 752 x 480: not determined (n = 1)
";
        assert!(shown.starts_with(want), "{shown}");
        let shown = markdown(&analysis);
        assert!(shown.contains("**repeatable to 0.69 px (95 %: 0.43 .. 1.7 px, n = 6)**"));
        assert!(shown.contains("\n  - `clusters`: why\\_clusters\n"), "{shown}");
    }

    #[test]
    fn of_many_cameras_a_terminal_names_the_reasons_on_one_line() {
        let one = |group: usize| {
            judged(&group.to_string(), verdict(VerdictKind::Doubtful, &[FindingId::FewRuns]))
        };
        let shown = plain(&terminal(&analysis((0..13).map(one).collect())));
        let line = "  3: camera 1, OPENCV 752 x 480: doubtful, spread 0.69 px (95 %: 0.43 .. 1.7 px, n = 6): few-runs";
        assert!(shown.lines().any(|found| found == line), "{shown}");
        assert!(!shown.contains("why"));
    }

    #[test]
    fn a_reason_is_not_said_again_among_the_findings() {
        let finding = |id| Finding {
            id,
            group: Some("a".to_owned()),
            camera: Some("camera 1".to_owned()),
            runs: vec![],
            text: String::new(),
        };
        let analysis =
            analysis(vec![judged("a", verdict(VerdictKind::Doubtful, &[FindingId::Fold]))]);
        assert!(is_reason(&analysis, &finding(FindingId::Fold)));
        assert!(!is_reason(&analysis, &finding(FindingId::Clusters)));
        assert!(!is_reason(&analysis, &Finding { camera: None, ..finding(FindingId::Fold) }));
        let elsewhere = Finding { group: Some("b".to_owned()), ..finding(FindingId::Fold) };
        assert!(!is_reason(&analysis, &elsewhere));
    }

    #[test]
    fn an_analysis_without_cameras_has_no_verdicts() {
        assert_eq!((terminal(&analysis(vec![])), markdown(&analysis(vec![]))), Default::default());
    }
}
