//! The one font: its letters, how wide they are, and how text fits into a width.

use ab_glyph::{Font as _, FontRef, GlyphId};

use super::PlotError;

/// Roboto Regular, subset; `font/README.md` says whence.
const BYTES: &[u8] = include_bytes!("font/Roboto-Regular-subset.ttf");

/// What an SVG asks for: the font that we measure with, then near ones.
pub const FAMILY: &str = "Roboto, Arial, sans-serif";

/// How much wider text may be where Roboto is not installed: DejaVu Sans, the widest of the usual fallbacks, is.
/// Without it labels run into each other there.
const FALLBACK_WIDER: f64 = 1.17;

/// Width in em of a letter that the font lacks: a Chinese one in any font.
const UNKNOWN_LETTER: f64 = 1.0;

/// The letters.
#[derive(Debug, Clone)]
pub struct Font {
    pub face: FontRef<'static>,
    /// Units of the face in an em.
    pub units: f32,
}

impl Font {
    pub fn load() -> Result<Self, PlotError> {
        let face = FontRef::try_from_slice(BYTES).map_err(|_| PlotError::Font)?;
        let units = face.units_per_em().ok_or(PlotError::Font)?;
        Ok(Self { face, units })
    }

    /// How far the pen moves for this letter, in em.
    pub fn advance(&self, letter: char) -> f64 {
        match self.face.glyph_id(letter) {
            GlyphId(0) => UNKNOWN_LETTER,
            id => f64::from(self.face.h_advance_unscaled(id) / self.units),
        }
    }

    /// The width that a text may need at this font size, in any of the fonts that an SVG may meet.
    pub fn width(&self, text: &str, size: f64) -> f64 {
        text.chars().map(|letter| self.advance(letter)).sum::<f64>() * size * FALLBACK_WIDER
    }

    /// The text, or its two ends round an ellipsis, in at most this width.
    pub fn shorten(&self, text: &str, size: f64, width: f64) -> String {
        if self.width(text, size) <= width {
            return text.to_owned();
        }
        let letters: Vec<char> = text.chars().collect();
        for kept in (2..letters.len()).rev() {
            let (head, tail) = (kept.div_ceil(2), kept / 2);
            let short: String = letters[..head]
                .iter()
                .chain(&['…'])
                .chain(&letters[letters.len() - tail..])
                .collect();
            if self.width(&short, size) <= width {
                return short;
            }
        }
        "…".to_owned()
    }

    /// The text in lines of at most this width, broken between words; within one only where it fills a line alone.
    pub fn wrap(&self, text: &str, size: f64, width: f64) -> Vec<String> {
        let mut lines = vec![String::new()];
        for word in text.split(' ').filter(|word| !word.is_empty()) {
            self.append(&mut lines, word, size, width);
        }
        lines.retain(|line| !line.is_empty());
        lines
    }

    fn append(&self, lines: &mut Vec<String>, word: &str, size: f64, width: f64) {
        let Some(last) = lines.last_mut() else { return };
        let longer = if last.is_empty() { word.to_owned() } else { format!("{last} {word}") };
        if self.width(&longer, size) <= width {
            *last = longer;
            return;
        }
        let mut line = String::new();
        for letter in word.chars() {
            line.push(letter);
            if self.width(&line, size) > width && line.chars().count() > 1 {
                line.pop();
                lines.push(std::mem::replace(&mut line, letter.to_string()));
            }
        }
        lines.push(line);
    }
}

/// The text without what XML forbids, breaks a line, or turns the direction of reading.
pub fn clean(text: &str) -> String {
    let is_odd = |c: char| {
        c.is_control()
            || matches!(c, '\u{200E}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2066}'..='\u{2069}' | '\u{FFFE}' | '\u{FFFF}')
    };
    text.chars().map(|c| if is_odd(c) { '\u{FFFD}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advances_are_those_of_the_font_file() {
        // In 1/2048 em, by fontTools: hmtx of the glyphs for "m", "i", "7" and the minus sign.
        let font = Font::load().unwrap();
        for (letter, units) in [('m', 1796.0), ('i', 498.0), ('7', 1151.0), ('−', 1171.0)] {
            assert!((font.advance(letter) * 2048.0 - units).abs() < 1e-3, "{letter}");
        }
    }

    #[test]
    fn shortened_text_fits_and_keeps_both_ends() {
        let font = Font::load().unwrap();
        let short = font.shorten("first_part_of_a_long_name_and_its_end", 12.0, 120.0);
        assert!(font.width(&short, 12.0) <= 120.0);
        assert!(
            short.starts_with("first") && short.contains('…') && short.ends_with("_end"),
            "{short}"
        );
        assert_eq!(font.shorten("short", 12.0, 120.0), "short");
    }

    #[test]
    fn wrapped_text_keeps_every_word_and_breaks_the_longest() {
        let font = Font::load().unwrap();
        let text = format!("a few words and {} again", "x".repeat(80));
        let lines = font.wrap(&text, 11.0, 150.0);
        assert!(lines.iter().all(|line| font.width(line, 11.0) <= 150.0), "{lines:?}");
        let letters = |text: &str| text.chars().filter(|c| !c.is_whitespace()).collect::<String>();
        assert_eq!(letters(&lines.concat()), letters(&text));
    }
}
