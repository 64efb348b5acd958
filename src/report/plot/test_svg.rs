//! An SVG taken apart again, with rules of its own: what it shows, and where its words are.

use super::font::Font;

/// A text of an SVG, with the room that it may take.
#[derive(Debug)]
pub struct Word {
    pub text: String,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

pub fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
    let key = format!("{name}=\"");
    let is_whole = |start: &usize| *start == 0 || element[..*start].ends_with(' ');
    let mut places = element.match_indices(&key).map(|(start, _)| start);
    let start = places.find(is_whole).unwrap() + key.len();
    &element[start..][..element[start..].find('"').unwrap()]
}

pub fn number(element: &str, name: &str) -> f64 {
    attribute(element, name).parse().unwrap()
}

pub fn elements<'a>(svg: &'a str, tag: &str) -> Vec<&'a str> {
    svg.split(&format!("<{tag} ")).skip(1).map(|rest| rest.split_once('>').unwrap().0).collect()
}

pub fn words(svg: &str) -> Vec<Word> {
    let font = Font::load().unwrap();
    let mut words = Vec::new();
    for rest in svg.split("<text").skip(1) {
        let (element, rest) = rest.split_once('>').unwrap();
        let text = rest.split_once("</text>").unwrap().0.trim();
        let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"");
        let text = text.replace("&apos;", "'").replace("&amp;", "&");
        let (x, y, size) =
            (number(element, "x"), number(element, "y"), number(element, "font-size"));
        let width = font.width(&text, size);
        let left = match attribute(element, "text-anchor") {
            "start" => x,
            "middle" => x - 0.5 * width,
            "end" => x - width,
            other => panic!("unknown anchor {other}"),
        };
        // y is the middle of an x; capitals reach 0.45 em above it, descenders 0.47 em below.
        words.push(Word {
            text,
            left,
            right: left + width,
            top: y - 0.45 * size,
            bottom: y + 0.47 * size,
        });
    }
    words
}

pub fn assert_words_are_legible(svg: &str) {
    let view: Vec<f64> =
        attribute(svg, "viewBox").split(' ').map(|text| text.parse().unwrap()).collect();
    let size = [view[2], view[3]];
    let words = words(svg);
    assert!(words.len() > 3);
    for (index, word) in words.iter().enumerate() {
        let is_inside =
            word.left >= 0.0 && word.top >= 0.0 && word.right <= size[0] && word.bottom <= size[1];
        assert!(is_inside, "{word:?} leaves the page of {size:?}");
        for other in &words[..index] {
            let is_apart = word.left >= other.right
                || word.right <= other.left
                || word.top >= other.bottom
                || word.bottom <= other.top;
            assert!(is_apart, "{word:?} covers {other:?}");
        }
    }
    for element in svg.split("<text").skip(1) {
        assert!(number(element, "font-size") >= 109.9, "{element}");
    }
}

pub fn points(element: &str) -> Vec<[i64; 2]> {
    let pair = |text: &str| {
        let (x, y) = text.split_once(',').unwrap();
        [x.parse().unwrap(), y.parse().unwrap()]
    };
    attribute(element, "points").split_whitespace().map(pair).collect()
}

/// Samples that a box plot shows: dots, crosses of two slanting lines, arrows with one number or a count of them.
pub fn shown_in_boxes(svg: &str) -> usize {
    let is_slanting = |element: &&str| {
        let points = points(element);
        points.len() == 2 && points[0][0] != points[1][0] && points[0][1] != points[1][1]
    };
    let crosses = elements(svg, "polyline").iter().filter(|element| is_slanting(element)).count();
    let arrows =
        elements(svg, "polygon").iter().filter(|element| points(element).len() == 3).count();
    let counted = |word: &Word| -> Option<usize> {
        let (count, rest) = word.text.split_once(": ")?;
        rest.contains(" to ").then_some(count.parse().ok()?)
    };
    let more: usize = words(svg).iter().filter_map(counted).map(|count| count - 1).sum();
    elements(svg, "circle").len() + crosses / 2 + arrows + more
}

pub fn count_of_color(svg: &str, color: &str) -> usize {
    let is_of_color = |element: &&str| attribute(element, "fill") == color;
    let of = |tag: &str| elements(svg, tag).iter().filter(|element| is_of_color(element)).count();
    of("circle") + of("polygon") + of("rect")
}
