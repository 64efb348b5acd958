//! The names of groups as they stand beside rows and in legends: short enough, and each its own.

use super::font::Font;
use super::page::BODY;
use super::subject::Subject;

/// Labels wider than this are shortened in their middle: a path for a name must not push the plot off the page.
const WIDEST: f64 = 300.0;

/// The labels of the subject's groups; two that would look the same get their number in front.
pub fn labels(subject: &Subject, font: &Font) -> Vec<String> {
    let shorten = |text: &str| font.shorten(text, BODY, WIDEST);
    let short: Vec<String> = subject.members.iter().map(|member| shorten(&member.group)).collect();
    let is_double = |label: &String| short.iter().filter(|other| *other == label).count() > 1;
    let numbered = |(index, label): (usize, &String)| match is_double(label) {
        true => shorten(&format!("{} {}", index + 1, subject.members[index].group)),
        false => label.clone(),
    };
    short.iter().enumerate().map(numbered).collect()
}

/// The width of the widest label.
pub fn widest(labels: &[String], font: &Font) -> f64 {
    labels.iter().map(|label| font.width(label, BODY)).fold(0.0, f64::max)
}
