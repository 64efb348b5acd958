//! File stems of figures: safe on every file system, and each its own.

/// Longer labels are cut: file systems take 255 bytes of name.
const LONGEST_LABEL: usize = 60;

/// The stems given so far.
#[derive(Default)]
pub struct Stems(Vec<String>);

impl Stems {
    /// A stem of these words, each with what stands for it if no letter is left, such as `camera-1-opencv-752x480`.
    pub fn of(&mut self, words: &[(&str, &str)], [width, height]: [u64; 2]) -> String {
        let mut stem: String =
            words.iter().map(|(word, otherwise)| plain(word, otherwise) + "-").collect();
        stem.push_str(&format!("{width}x{height}"));
        let numbered = (2_u64..).map(|number| format!("{stem}-{number}"));
        let mut candidates = std::iter::once(stem.clone()).chain(numbered);
        let free = candidates.find(|stem| !self.0.contains(stem)).unwrap_or(stem);
        self.0.push(free.clone());
        free
    }
}

/// The text in lower case (some file systems tell no other), all but ASCII letters, digits and `_` as single hyphens.
fn plain(text: &str, otherwise: &str) -> String {
    let mut plain = String::new();
    for letter in text.chars().take(LONGEST_LABEL) {
        match letter {
            'a'..='z' | '0'..='9' | '_' => plain.push(letter),
            'A'..='Z' => plain.push(letter.to_ascii_lowercase()),
            _ if !plain.is_empty() && !plain.ends_with('-') => plain.push('-'),
            _ => {}
        }
    }
    let plain = plain.trim_end_matches('-');
    if plain.is_empty() { otherwise.to_owned() } else { plain.to_owned() }
}
