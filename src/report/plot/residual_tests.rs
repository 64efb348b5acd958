//! What a reader of mean residuals relies on: arrows go where residuals lean, as long as it says, and bars reach as far as noise.

use super::test_data::{analysis, estimated, parameter, population};
use super::test_svg::{assert_words_are_legible, elements, number, points, words};
use super::{Figure, FigureKind, figures};
use crate::stability::{Analysis, CellMean, Mean, ResidualMap, Residuals, RingMean};

/// In cells of 160 x 160 px of an image of 640 x 400: below each other they lean by more and more to the right, the last row
/// being cut by the image's border; every other cell no further than noise. Rings lean outward, alternating.
fn leaning(px: f64) -> Residuals {
    let mean = |px: [f64; 2], p: f64| Mean { count: 40, px, std_error_px: [0.05, 0.1], p };
    let cell = |cell: usize| {
        let [column, row] = [cell % 4, cell / 4].map(|at| at as f64);
        let middle = [160.0 * column + 80.0, if row < 2.0 { 160.0 * row + 80.0 } else { 360.0 }];
        let p = if cell.is_multiple_of(2) { 1e-6 } else { 0.5 };
        CellMean { cell, middle, mean: mean([px * (row + 1.0), 0.0], p) }
    };
    let ring = |at: usize| {
        let outward = if at.is_multiple_of(2) { px } else { -px };
        RingMean { radius_px: 35.0 * (at as f64 + 0.5), mean: mean([outward, 0.0], 0.01) }
    };
    let map = ResidualMap {
        n: 6,
        columns: 4,
        rows: 3,
        cell_px: [160.0; 2],
        cells: (0..12).map(cell).collect(),
        rings: (0..10).map(ring).collect(),
    };
    Residuals { n: 6, p: 1e-9, effect_px: px, sigma_px: 0.5, tails: None, map, runs: vec![] }
}

fn analysis_of(groups: &[(&str, f64)]) -> Analysis {
    let of_group = |(group, px): &(&str, f64)| {
        let parameters = vec![parameter("fx", &estimated(&[1.0, 2.0, 4.0]))];
        let mut one = population(group, "camera 1", "OPENCV", parameters);
        (one.width, one.height, one.residuals) = (640, 400, Some(leaning(*px)));
        one
    };
    analysis(groups.iter().map(of_group).collect())
}

fn of_kind(analysis: &Analysis, kind: FigureKind) -> Vec<Figure> {
    figures(analysis).unwrap().into_iter().filter(|figure| figure.kind == kind).collect()
}

/// Tail and tip of an arrow, in the units of its SVG.
fn ends(arrow: &[[i64; 2]]) -> [[f64; 2]; 2] {
    let tail = [0, 1].map(|axis| (arrow[0][axis] + arrow[6][axis]) as f64 / 2.0);
    [tail, arrow[3].map(|value| value as f64)]
}

#[test]
fn arrows_lean_as_the_residuals_do_from_the_middles_of_their_cells() {
    let svg = of_kind(&analysis_of(&[("a", 0.2)]), FigureKind::Residuals)[0].to_svg().unwrap();
    let is_arrow = |element: &&str| points(element).len() == 7;
    let arrows: Vec<&str> = elements(&svg, "polygon").into_iter().filter(is_arrow).collect();
    assert_eq!(arrows.len(), 13, "twelve cells and the key");
    let words = words(&svg);
    let key = words.iter().find(|word| word.text.contains("arrows are")).unwrap();
    let factor = key.text.split("arrows are ").nth(1).unwrap().split(' ').next().unwrap();
    // 560 CSS px for 640, ten units of the SVG each.
    let scale = 560.0 / 640.0 * 10.0;
    let first = ends(&points(arrows[0]));
    for (cell, arrow) in arrows[..12].iter().enumerate() {
        let [tail, tip] = ends(&points(arrow));
        let row = cell / 4;
        let want = 0.2 * (row + 1) as f64 * factor.parse::<f64>().unwrap() * scale;
        assert!((tip[0] - tail[0] - want).abs() < 2.0, "{cell}: {tail:?} {tip:?} {want}");
        assert!((tip[1] - tail[1]).abs() < 2.0, "{cell}");
        let middle = |[tail, tip]: [[f64; 2]; 2]| [0, 1].map(|axis| 0.5 * (tail[axis] + tip[axis]));
        let (at, origin) = (middle([tail, tip]), middle(first));
        let height = [0.0, 160.0, 280.0][row];
        let want = [160.0 * (cell % 4) as f64, height].map(|px| px * scale);
        for axis in 0..2 {
            assert!((at[axis] - origin[axis] - want[axis]).abs() < 3.0, "{cell} {axis}");
        }
    }
    // What noise would do is paler.
    let [sign, noise] =
        [arrows[0], arrows[1]].map(|arrow| super::test_svg::attribute(arrow, "fill"));
    assert_ne!(sign, noise);
    assert!(arrows[..12].iter().step_by(2).all(|arrow| arrow.contains(sign)));
}

#[test]
fn bars_reach_two_standard_errors_and_zero_is_in_the_middle() {
    let svg =
        of_kind(&analysis_of(&[("a", 0.2)]), FigureKind::ResidualProfile)[0].to_svg().unwrap();
    // Circles are marks, one of them in the legend: ten rings outward, ten along the tangent.
    let marks: Vec<f64> =
        elements(&svg, "circle").iter().map(|circle| number(circle, "cy")).collect();
    assert_eq!(marks.len(), 21);
    let (up, down, level) = (marks[1], marks[2], marks[11]);
    assert!(((up + down) / 2.0 - level).abs() < 1.0, "{marks:?}");
    let px = (down - up) / 0.4;
    let upright: Vec<f64> = elements(&svg, "polyline")
        .iter()
        .map(|line| points(line))
        .filter(|points| points.len() == 2 && points[0][0] == points[1][0])
        .map(|points| (points[0][1] - points[1][1]).abs() as f64)
        .collect();
    let of_length = |error: f64| {
        let want = 2.0 * 1.96 * error * px;
        upright.iter().filter(|length| (*length - want).abs() < 3.0).count()
    };
    assert_eq!([of_length(0.05), of_length(0.1)], [10, 10], "{px} {upright:?}");
}

#[test]
fn words_of_residuals_stay_on_the_page_whatever_they_are() {
    let long = "a/very/long/path/".repeat(20);
    let many: Vec<(&str, f64)> = (0..9).map(|_| ("same", 0.1)).collect();
    let cases = [vec![("a", 0.0)], vec![("a", 1e-12), (&*long, 1e9), ("c", 0.3)], many];
    let mut count = 0;
    for case in cases {
        for figure in figures(&analysis_of(&case)).unwrap() {
            let svg = figure.to_svg().unwrap();
            assert_words_are_legible(&svg);
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{}", figure.stem);
            count += usize::from(figure.stem.contains("residual"));
        }
    }
    // Nine groups are three maps.
    assert_eq!(count, 2 + 2 + 4);
    let mut none = analysis_of(&[("a", 0.1)]);
    none.populations[0].residuals = None;
    assert!(figures(&none).unwrap().iter().all(|figure| !figure.stem.contains("residual")));
}
