//! What a reader of maps relies on: heights, directions and scales are those that stand beside them, and words can be read.

use super::drawing::{Drawing, Shape};
use super::font::Font;
use super::marker::Style;
use super::spreads::{SpreadOf, Spreads};
use super::test_data::{analysis, estimated, parameter, population, spread_over};
use super::test_svg::{assert_words_are_legible, elements, number, points, words};
use super::{Figure, FigureKind, deviation, figures, heat, profile};
use crate::stability::spread::{MovedSpread, Spread};
use crate::stability::{Analysis, Correlations};

/// A cone about the middle of an image of 640 x 480 px: its height is the distance in hundreds of px.
fn cone() -> Spread {
    spread_over([640, 480], |[x, y]| Some((x - 320.0).hypot(y - 240.0) / 100.0))
}

/// A cone with everything that may stand beside it.
fn crowded() -> Spread {
    let mut spread = spread_over([640, 480], |[x, y]| {
        (x < 500.0).then_some((x - 320.0).hypot(y - 240.0) / 100.0)
    });
    spread.masked_cells = (0..45).flat_map(|row| [row * 60 + 47, row * 60 + 48]).collect();
    spread.observation_counts = Some((0..2700).map(|cell| cell * cell % 11).collect());
    let measure = spread.rotated.clone();
    spread.moved = Some(MovedSpread { depths: [0.5, 1.0, 2.0], measure });
    spread
}

fn times(mut spread: Spread, factor: f64) -> Spread {
    for measure in [&mut spread.raw, &mut spread.rotated] {
        measure.map_px.iter_mut().for_each(|px| *px *= factor);
        for number in [&mut measure.rms_px, &mut measure.p95_px, &mut measure.max_px] {
            *number *= factor;
        }
    }
    spread.worst.px.iter_mut().flatten().for_each(|px| *px *= factor);
    for ring in &mut spread.radial_profile {
        ring.rms_px *= factor;
        ring.raw_rms_px *= factor;
    }
    spread
}

fn analysis_of(size: [u64; 2], spreads: Vec<(&str, Spread)>) -> Analysis {
    let of_group = |(group, spread): (&str, Spread)| {
        let parameters =
            ["fx", "k1", "p1"].map(|name| parameter(name, &estimated(&[1.0, 2.0, 4.0])));
        let mut one = population(group, "camera 1", "OPENCV", parameters.into());
        (one.width, one.height) = (size[0], size[1]);
        one.spread = Some(spread);
        one.correlations = Correlations {
            parameters: ["fx", "k1", "p1"].map(str::to_owned).to_vec(),
            matrix: vec![
                vec![Some(1.0), Some(-0.834), None],
                vec![Some(-0.834), Some(1.0), Some(0.056)],
                vec![None, Some(0.056), Some(1.0)],
            ],
        };
        one
    };
    analysis(spreads.into_iter().map(of_group).collect())
}

/// Whether a line ends where it begins, to the last bit.
fn is_closed(line: &[[f64; 2]]) -> bool {
    let ends = [line.first(), line.last()].map(|at| at.map(|at| at.map(f64::to_bits)));
    ends[0] == ends[1]
}

fn of_kind(analysis: &Analysis, kind: FigureKind) -> Vec<Figure> {
    figures(analysis).unwrap().into_iter().filter(|figure| figure.kind == kind).collect()
}

#[test]
fn words_stay_on_the_page_and_off_each_other_and_no_number_is_missing() {
    const SIZE: [u64; 2] = [640, 480];
    let long = "a/very/long/path/".repeat(20);
    let [tall, flat] = [[100, 1000], [1000, 100]];
    let narrow = |[x, y]: [f64; 2]| Some(x * y / 1e3);
    let some = |[x, _]: [f64; 2]| (x < 25.0).then_some(x);
    let cases = [
        (SIZE, vec![("a", cone())]),
        (SIZE, vec![("a", cone()), ("b", crowded())]),
        (SIZE, vec![("a", cone()), ("wild", times(crowded(), 120.0)), (&long, cone())]),
        (SIZE, (0..9).map(|_| ("same", crowded())).collect()),
        (SIZE, vec![("equal", times(cone(), 0.0)), ("level", spread_over(SIZE, |_| Some(7.0)))]),
        (SIZE, vec![("tiny", times(cone(), 1e-9)), ("huge", times(cone(), 1e9))]),
        (SIZE, vec![("two cells", spread_over(SIZE, some))]),
        (tall, vec![("tall", spread_over(tall, narrow)), ("tall too", spread_over(tall, narrow))]),
        (flat, vec![("flat", spread_over(flat, narrow))]),
    ];
    let mut count = 0;
    for (size, spreads) in cases {
        for figure in figures(&analysis_of(size, spreads)).unwrap() {
            let svg = figure.to_svg().unwrap();
            assert_words_are_legible(&svg);
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{}", figure.stem);
            let is_map = matches!(figure.kind, FigureKind::Spread | FigureKind::Deviation);
            count += usize::from(is_map);
        }
    }
    assert!(count >= 20, "{count}");
}

#[test]
fn lines_lie_at_the_height_that_their_number_says() {
    let size = [640, 480];
    let spread = cone();
    let members = vec![SpreadOf {
        label: "a".to_owned(),
        style: Style::of_group(0),
        spread: &spread,
        predicted: None,
    }];
    let spreads = Spreads { camera: "c".to_owned(), size, members, runs_in_words: Vec::new() };
    let font = Font::load().unwrap();
    let drawing = heat::draw(&spreads, &font).unwrap();
    // Lines of more than two points are contours: circles about the middle of their panel, 380 px for 640.
    let radii = |drawing: &Drawing| -> Vec<f64> {
        let mut radii = Vec::new();
        for shape in &drawing.shapes {
            let Shape::Line { points, .. } = shape else { continue };
            if points.len() > 20 && is_closed(points) {
                let xs = points.iter().map(|at| at[0]);
                let (low, high) = (xs.clone().fold(f64::MAX, f64::min), xs.fold(0.0, f64::max));
                radii.push((high - low) / 2.0 / 380.0 * 640.0);
            }
        }
        radii.sort_by(f64::total_cmp);
        radii
    };
    let found = radii(&drawing);
    // In both panels; higher ones leave the image.
    let wanted = [50.0, 50.0, 100.0, 100.0, 200.0, 200.0];
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    for (found, want) in found.iter().zip(wanted) {
        assert!((found - want).abs() < 1.0, "{found} {want}");
    }
    let texts: Vec<&str> = drawing
        .shapes
        .iter()
        .filter_map(|shape| if let Shape::Text(text) = shape { Some(&*text.text) } else { None })
        .collect();
    for label in ["0.5", "1", "2"] {
        assert!(texts.iter().filter(|text| **text == label).count() >= 2, "{label}: {texts:?}");
    }
}

#[test]
fn arrows_have_the_length_that_is_said_and_point_where_the_run_is_off() {
    let svg = of_kind(&analysis_of([640, 480], vec![("a", cone())]), FigureKind::Deviation)[0]
        .to_svg()
        .unwrap();
    let arrows: Vec<Vec<[i64; 2]>> =
        elements(&svg, "polygon").iter().map(|e| points(e)).filter(|p| p.len() == 7).collect();
    let dots = elements(&svg, "circle").len();
    let field = cone().worst;
    assert_eq!(arrows.len() + dots, field.cells.len() + 1);
    let words = words(&svg);
    let key = words.iter().find(|word| word.text.contains("arrows are")).unwrap();
    let (reference, rest) = key.text.split_once(" px; arrows are ").unwrap();
    let factor: f64 = rest.split(' ').next().unwrap().parse().unwrap();
    // 560 CSS px for 640, ten units of the SVG each.
    let scale = factor * 560.0 / 640.0 * 10.0;
    let length = |arrow: &[[i64; 2]]| {
        let tail =
            [arrow[0][0] + arrow[6][0], arrow[0][1] + arrow[6][1]].map(|sum| sum as f64 / 2.0);
        [arrow[3][0] as f64 - tail[0], arrow[3][1] as f64 - tail[1]]
    };
    let (last, others) = arrows.split_last().unwrap();
    let want = reference.parse::<f64>().unwrap() * scale;
    assert!((length(last)[0] - want).abs() < 2.0, "{} {want}", length(last)[0]);
    let longest = others.iter().map(|arrow| length(arrow)[1]).fold(0.0, f64::max);
    let want = field.px.iter().map(|px| px[1]).fold(0.0, f64::max) * scale;
    assert!((longest - want).abs() < 2.0, "{longest} {want}");
    assert!(others.iter().all(|arrow| length(arrow)[1] > 0.0 && length(arrow)[0].abs() < 2.0));
}

#[test]
fn profiles_show_every_ring_of_every_group_even_where_one_is_far_above() {
    for factor in [1.0, 1000.0] {
        let all = analysis_of([640, 480], vec![("a", cone()), ("b", times(cone(), factor))]);
        let svg = of_kind(&all, FigureKind::Profile)[0].to_svg().unwrap();
        // Circles are the first group's marks, one of them in the legend.
        let circles = elements(&svg, "circle");
        assert_eq!(circles.len(), 2 * 10 + 1, "{factor}");
        let heights: Vec<f64> = circles[1..].iter().map(|circle| number(circle, "cy")).collect();
        let span = heights.iter().copied().fold(0.0, f64::max)
            - heights.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(span > 500.0, "{factor}: {span}");
        assert_eq!(svg.contains("goes by ratio"), factor > 1.0);
    }
}

#[test]
fn correlations_are_written_into_their_cells_and_missing_ones_are_told() {
    let all = analysis_of([640, 480], vec![("a", cone())]);
    let svg = of_kind(&all, FigureKind::Correlations)[0].to_svg().unwrap();
    let words = words(&svg);
    let count = |text: &str| words.iter().filter(|word| word.text == text).count();
    assert_eq!([count("−0.83"), count("0.06"), count("1.00")], [2, 2, 3]);
    assert!(svg.contains("Without a number"));
}

#[test]
fn many_groups_go_on_in_further_figures_with_names_of_their_own() {
    let all = analysis_of([640, 480], (0..9).map(|_| ("g", cone())).collect());
    let stems: Vec<String> = figures(&all).unwrap().into_iter().map(|figure| figure.stem).collect();
    for (index, stem) in stems.iter().enumerate() {
        assert!(!stems[..index].contains(stem), "{stem}");
    }
    let spreads: Vec<&String> = stems.iter().filter(|stem| stem.contains("-spread")).collect();
    assert_eq!(
        spreads,
        ["", "-2", "-3"].map(|end| format!("camera-1-opencv-640x480-spread{end}")).each_ref()
    );
}

#[test]
fn same_spreads_same_bytes_and_the_page_is_drawn_whole_as_png() {
    let draw = || figures(&analysis_of([640, 480], vec![("a", crowded())])).unwrap();
    let [first, second] = [draw(), draw()];
    assert_eq!(first.len(), 7);
    for (a, b) in first.iter().zip(&second) {
        assert_eq!(a.to_svg().unwrap(), b.to_svg().unwrap());
        assert_eq!(a.to_png().unwrap(), b.to_png().unwrap());
    }
}

#[test]
fn without_a_spread_or_a_deviation_there_is_no_figure_of_it() {
    let font = Font::load().unwrap();
    let of = |spread| Spreads {
        camera: String::new(),
        size: [640, 480],
        members: vec![SpreadOf {
            label: String::new(),
            style: Style::of_group(0),
            spread,
            predicted: None,
        }],
        runs_in_words: Vec::new(),
    };
    let [none, some] = [times(cone(), 0.0), cone()];
    assert!(deviation::draw(&of(&none), &font).is_none());
    assert!(deviation::draw(&of(&some), &font).is_some());
    let empty = Spreads { members: Vec::new(), ..of(&some) };
    assert!(heat::draw(&empty, &font).is_none() && profile::draw(&empty, &font).is_none());
}
