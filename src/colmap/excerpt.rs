//! The part of a line that an error shows, safe to print on a terminal.

/// A line, or what stands near the column that matters when the line is long.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Excerpt {
    /// The text, control characters escaped, `…` where it was cut.
    pub text: String,
    /// How many characters of `text` stand before the one that matters.
    pub caret: usize,
}

/// Bytes shown on either side of the column: together they fill a terminal of 100 columns.
const REACH: usize = 45;

/// Longer words from the file are cut in messages: a whole file may be one word.
const LONGEST_WORD: usize = 40;

impl Excerpt {
    /// The surroundings of this byte of a line.
    pub(super) fn of(line: &[u8], at: usize) -> Self {
        let start = character_start(line, at.saturating_sub(REACH));
        let end = character_start(line, at.saturating_add(REACH));
        let cut = |is_cut| if is_cut { "…" } else { "" };
        let before = format!("{}{}", cut(start > 0), escaped(&line[start..at]));
        let after = format!("{}{}", escaped(&line[at..end]), cut(end < line.len()));
        Self { caret: before.chars().count(), text: before + &after }
    }
}

/// The first byte of the character that this byte belongs to.
fn character_start(line: &[u8], mut at: usize) -> usize {
    const LONGEST_CHARACTER: usize = 4;
    if at >= line.len() {
        return line.len();
    }
    for _ in 1..LONGEST_CHARACTER {
        let continues = line[at] & 0b1100_0000 == 0b1000_0000;
        at -= usize::from(continues && at > 0);
    }
    at
}

/// A word from a file, cut when it is long.
pub(super) fn cut(word: &[u8]) -> String {
    let end = character_start(word, LONGEST_WORD);
    let more = if end < word.len() { "…" } else { "" };
    String::from_utf8_lossy(&word[..end]).into_owned() + more
}

/// A word from a file, made fit for a message: cut when long, control characters escaped.
pub(super) fn clipped(word: &[u8]) -> String {
    escaped(cut(word).as_bytes())
}

/// The text, or what can be made of it, with control characters escaped.
pub(super) fn escaped(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for character in String::from_utf8_lossy(bytes).chars() {
        if is_harmless(character) {
            text.push(character);
        } else {
            text.extend(character.escape_default());
        }
    }
    text
}

/// Whether printing it moves no cursor, changes no colour and turns no direction of writing.
fn is_harmless(character: char) -> bool {
    let turns = matches!(character, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    !character.is_control() && !turns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_line_is_shown_whole() {
        let excerpt = Excerpt::of(b"1 OPENCV 640", 2);
        assert_eq!(excerpt, Excerpt { text: "1 OPENCV 640".to_owned(), caret: 2 });
    }

    #[test]
    fn the_caret_of_a_long_line_stands_under_its_byte() {
        let mut line = vec![b'-'; 10_000];
        line[6_000] = b'X';
        let excerpt = Excerpt::of(&line, 6_000);
        assert_eq!(excerpt.text.chars().nth(excerpt.caret), Some('X'));
        assert!(excerpt.text.starts_with('…') && excerpt.text.ends_with('…'));
        assert!(excerpt.text.chars().count() < 100);
    }

    #[test]
    fn the_caret_may_stand_after_the_last_character() {
        let excerpt = Excerpt::of("ä ö".as_bytes(), 5);
        assert_eq!(excerpt, Excerpt { text: "ä ö".to_owned(), caret: 3 });
    }

    #[test]
    fn nothing_that_a_terminal_would_obey_is_shown() {
        let hostile = "\u{1b}[31m\u{202e}\r\u{7f}é\0".as_bytes();
        let excerpt = Excerpt::of(hostile, hostile.len());
        assert_eq!(excerpt.text, r"\u{1b}[31m\u{202e}\r\u{7f}é\u{0}");
        assert_eq!(excerpt.caret, excerpt.text.chars().count());
        assert_eq!(clipped(hostile), excerpt.text);
    }

    #[test]
    fn cutting_splits_no_character() {
        let line = "€".repeat(100);
        for at in 0..line.len() {
            let text = Excerpt::of(line.as_bytes(), at - at % 3).text;
            assert!(text.chars().all(|character| "€…".contains(character)), "{at}: {text}");
        }
        assert_eq!(clipped(line.as_bytes()), format!("{}…", "€".repeat(13)));
    }
}
