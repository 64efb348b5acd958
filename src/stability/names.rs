//! What image names have in common.

use std::collections::BTreeMap;

/// Pieces of a name, alternately without and with digits; the first has none and may be empty.
pub(super) fn pieces(name: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let mut rest = name;
    let mut digits = false;
    while !rest.is_empty() {
        let end = rest.find(|c: char| c.is_ascii_digit() != digits).unwrap_or(rest.len());
        let (piece, after) = rest.split_at(end);
        pieces.push(piece);
        rest = after;
        digits = !digits;
    }
    pieces
}

/// The folder that all of these names lie in; none when they lie in several.
pub(super) fn common_folder<'a>(names: &[&'a str]) -> Option<&'a str> {
    let folder = |name: &'a str| name.rsplit_once('/').map_or("", |(folder, _)| folder);
    let first = folder(names.first()?);
    names.iter().all(|name| folder(name) == first).then_some(first)
}

/// A pattern that all of these names fit, such as `*_cam0.jpg`: what differs is a star. None when they have nothing in common.
pub(super) fn common_pattern(names: &[&str]) -> Option<String> {
    let first = pieces(names.first()?);
    let mut same = vec![true; first.len()];
    for name in names {
        let these = pieces(name);
        if these.len() != first.len() {
            return None;
        }
        for (is_same, (one, other)) in same.iter_mut().zip(first.iter().zip(these)) {
            *is_same &= *one == other;
        }
    }
    let mut pattern = String::new();
    for (piece, is_same) in first.iter().zip(same) {
        if is_same {
            pattern.push_str(piece);
        } else if !pattern.ends_with('*') {
            pattern.push('*');
        }
    }
    (pattern != "*").then_some(pattern)
}

/// For each set of names, what sets it apart: the pieces that never differ within a set but differ between sets. A piece
/// of digits counts only where sets of one `place` differ in it: elsewhere it may number a session or a frame. None when
/// the names are not built alike.
pub(super) fn telling_pieces<'a>(sets: &[(usize, &[&'a str])]) -> Option<Vec<Vec<&'a str>>> {
    let split: Vec<Vec<Vec<&str>>> =
        sets.iter().map(|(_, names)| names.iter().map(|name| pieces(name)).collect()).collect();
    let count = split.first()?.first()?.len();
    if split.iter().any(Vec::is_empty) {
        return None;
    }
    if split.iter().flatten().any(|pieces| pieces.len() != count) {
        return None;
    }
    let mut first_of_place = BTreeMap::new();
    for (index, (place, _)) in sets.iter().enumerate() {
        first_of_place.entry(place).or_insert(index);
    }
    let tells = |piece: &usize| {
        let of = |set: usize| split[set][0][*piece];
        let is_number = piece % 2 == 1;
        let reference = |set: usize| if is_number { first_of_place[&sets[set].0] } else { 0 };
        let all = 0..split.len();
        let is_constant =
            all.clone().all(|set| split[set].iter().all(|name| name[*piece] == of(set)));
        is_constant && all.clone().any(|set| of(set) != of(reference(set)))
    };
    let telling: Vec<usize> = (0..count).filter(tells).collect();
    Some(split.iter().map(|set| telling.iter().map(|&piece| set[0][piece]).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_falls_into_text_and_digits() {
        assert_eq!(pieces("a12_cam0.jpg"), ["a", "12", "_cam", "0", ".jpg"]);
        assert_eq!(pieces("0001.jpg"), ["", "0001", ".jpg"]);
        assert_eq!(pieces(""), [""; 0]);
    }

    #[test]
    fn a_pattern_stars_what_differs() {
        let pattern = |names: &[&str]| common_pattern(names);
        assert_eq!(pattern(&["17_cam0.jpg", "234_cam0.jpg"]).as_deref(), Some("*_cam0.jpg"));
        assert_eq!(pattern(&["17_cam0.jpg", "234_cam1.jpg"]).as_deref(), Some("*_cam*.jpg"));
        assert_eq!(pattern(&["0003.jpg"]).as_deref(), Some("0003.jpg"));
        assert_eq!(pattern(&["1.jpg", "one.jpg"]), None);
    }

    #[test]
    fn the_folder_must_be_one() {
        assert_eq!(common_folder(&["left/1.jpg", "left/2.jpg"]), Some("left"));
        assert_eq!(common_folder(&["1.jpg"]), Some(""));
        assert_eq!(common_folder(&["left/1.jpg", "right/2.jpg"]), None);
    }

    #[test]
    fn the_camera_number_tells_and_the_frame_number_does_not() {
        let sets: [(usize, &[&str]); 4] = [
            (0, &["10_cam0.jpg", "11_cam0.jpg"]),
            (0, &["10_cam1.jpg", "11_cam1.jpg"]),
            (1, &["20_cam0.jpg", "21_cam0.jpg"]),
            (1, &["20_cam1.jpg"]),
        ];
        assert_eq!(telling_pieces(&sets).unwrap(), [["0"], ["1"], ["0"], ["1"]]);
    }

    #[test]
    fn a_session_number_tells_nothing_and_the_folder_of_a_camera_does() {
        let sets: [(usize, &[&str]); 4] = [
            (0, &["s1/left/10.jpg", "s1/left/11.jpg"]),
            (0, &["s1/right/10.jpg", "s1/right/11.jpg"]),
            (1, &["s2/left/10.jpg", "s2/left/12.jpg"]),
            (1, &["s2/right/10.jpg", "s2/right/12.jpg"]),
        ];
        let told = telling_pieces(&sets).unwrap();
        assert_eq!(told, [["/left/"], ["/right/"], ["/left/"], ["/right/"]]);
    }

    #[test]
    fn names_built_differently_tell_nothing() {
        let sets: [(usize, &[&str]); 2] = [(0, &["front.jpg"]), (0, &["cam2_1.jpg"])];
        assert_eq!(telling_pieces(&sets), None);
    }
}
