//! File stems of figures: safe on every file system, and each its own.

use super::subject::Subject;

/// Longer labels are cut: file systems take 255 bytes of name.
const LONGEST_LABEL: usize = 60;

/// A stem for each subject, such as `camera-1-opencv-752x480`.
pub fn stems(subjects: &[Subject]) -> Vec<String> {
    let mut stems: Vec<String> = Vec::new();
    for Subject { camera, model, width, height, .. } in subjects {
        let stem =
            format!("{}-{}-{width}x{height}", plain(camera, "camera"), plain(model, "model"));
        let numbered = (2_u64..).map(|number| format!("{stem}-{number}"));
        let free = std::iter::once(stem.clone()).chain(numbered).find(|stem| !stems.contains(stem));
        stems.extend(free);
    }
    stems
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
