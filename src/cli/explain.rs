//! `calibstab explain`.

use std::io::Write;

use clap::Args;
use terminal_size::{Width, terminal_size_of};

use super::failure::Failure;
use crate::stability::{Explanation, FindingId, VerdictKind};

/// Say what a finding means, how it is found and what to do about it; without an ID, list them
#[derive(Args)]
pub(super) struct Explain {
    /// A finding, as a verdict or analysis.json names it
    id: Option<String>,
}

const HEAD: &str = "What an analysis may find; `calibstab explain ID` says more.\n\n";

impl Explain {
    pub(super) fn run(&self, out: &mut impl Write) -> Result<(), Failure> {
        let Some(name) = &self.id else { return list(out) };
        let id = FindingId::all().find(|id| id.name() == name);
        let id = id.ok_or_else(|| Failure::Input(unknown(name)))?;
        let Explanation { short, meaning, found, advice } = id.explanation();
        let bearing = match id.at_best() {
            VerdictKind::Repeatable => "It does not bear on the verdict.".to_owned(),
            kind => format!("A camera with it is {} at best.", kind.name().replace('-', " ")),
        };
        /// Longer lines are hard to read.
        const WIDEST: usize = 100;
        let width = terminal_size_of(std::io::stdout()).map_or(WIDEST, |(Width(w), _)| w.into());
        writeln!(out, "{name}: {short}")?;
        for text in [
            meaning,
            &bearing,
            &format!("How it is found: {found}"),
            &format!("What to do: {advice}"),
        ] {
            writeln!(out, "\n{}", wrapped(text, width.min(WIDEST)))?;
        }
        Ok(())
    }
}

fn list(out: &mut impl Write) -> Result<(), Failure> {
    let width = FindingId::all().map(|id| id.name().len()).max().unwrap_or(0);
    out.write_all(HEAD.as_bytes())?;
    for kind in VerdictKind::ALL.into_iter().rev() {
        let title = match kind {
            VerdictKind::NotDetermined => "A camera is not determined, with",
            VerdictKind::Doubtful => "A camera is doubtful at best, with",
            VerdictKind::Repeatable => "Said beside the verdict",
        };
        writeln!(out, "{title}:")?;
        for id in FindingId::all().filter(|id| id.at_best() == kind) {
            writeln!(out, "  {:<width$}  {}", id.name(), id.explanation().short)?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Below this similarity a guess would be noise.
const NEAR: f64 = 0.6;

fn unknown(name: &str) -> String {
    let similarity =
        |id: &FindingId| strsim::normalized_damerau_levenshtein(&name.to_lowercase(), id.name());
    let near = FindingId::all().filter(|id| similarity(id) >= NEAR);
    let near = near.max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
    let hint = match near {
        Some(id) => format!("did you mean {}?", id.name()),
        None => "`calibstab explain` lists them".to_owned(),
    };
    format!("there is no finding `{name}`: {hint}")
}

/// Lines no wider than so many characters, words longer than that excepted.
fn wrapped(text: &str, width: usize) -> String {
    let mut out = String::new();
    let mut taken = 0;
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if taken > 0 && taken + 1 + length > width {
            out.push('\n');
            taken = 0;
        } else if taken > 0 {
            out.push(' ');
            taken += 1;
        }
        out.push_str(word);
        taken += length;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_between_words_where_they_would_be_too_wide() {
        assert_eq!(wrapped("one two three four", 9), "one two\nthree\nfour");
        assert_eq!(wrapped("incomprehensible word", 5), "incomprehensible\nword");
    }

    #[test]
    fn a_slip_of_the_keyboard_is_guessed_and_noise_is_not() {
        assert!(unknown("cluster").ends_with("did you mean clusters?"));
        assert!(unknown("Few-Run").ends_with("did you mean few-runs?"));
        assert!(unknown("banana").contains("lists them"));
    }
}
