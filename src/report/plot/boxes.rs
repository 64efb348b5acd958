//! Box plots: a panel a parameter, a row a group, so that long names and many groups never overlap.

use crate::stability::Parameter;

use super::axis::{Axis, Side};
use super::color::{GREY, INK};
use super::columns::{Columns, PanelWidth};
use super::drawing::{Drawing, Pinned, Rect};
use super::font::Font;
use super::frame::{level_axis, level_ticks};
use super::labels::{labels, widest};
use super::marker::{Style, arrow, cross};
use super::notes::{held_values, notes};
use super::page::{BODY, Page, SMALL};
use super::range::span;
use super::subject::{Row, Subject, drawn};

/// Fewer samples than this have no quartiles worth a box.
const LEAST_FOR_A_BOX: usize = 5;

/// Width of a plot: alone on its line, or one of two.
const PLOT_WIDTHS: [f64; 2] = [500.0, 340.0];
const ROW_HEIGHT: f64 = 26.0;
const CAPTION_HEIGHT: f64 = 24.0;
const TICKS_HEIGHT: f64 = 22.0;
const PANEL_GAP: f64 = 18.0;
const COUNT_WIDTH: f64 = 60.0;
const LABEL_GAP: f64 = 10.0;
const HALF_BOX: f64 = 7.0;

/// The figure; none where nothing varies.
pub fn draw(subject: &Subject, font: &Font) -> Option<Drawing> {
    let rows = subject.rows();
    let figure = Boxes {
        title: subject.words(),
        subtitle: "Each parameter over the runs of each group".to_owned(),
        labels: labels(subject, font),
        styles: subject.members.iter().map(|member| member.style).collect(),
        notes: notes(subject, &rows),
        dot: "run",
    };
    figure.draw(&rows, font)
}

/// A page of box plots: a panel a row, in it a line for each label.
pub struct Boxes {
    pub title: String,
    pub subtitle: String,
    pub labels: Vec<String>,
    pub styles: Vec<Style>,
    pub notes: Vec<String>,
    /// What a dot is.
    pub dot: &'static str,
}

impl Boxes {
    /// The figure; none where nothing varies.
    pub fn draw(self, rows: &[Row], font: &Font) -> Option<Drawing> {
        let shown: Vec<&Row> = rows.iter().filter(|row| row.varies()).collect();
        if shown.is_empty() {
            return None;
        }
        let labels = &self.labels;
        let width = PanelWidth { left: 0.0, plot: PLOT_WIDTHS, right: COUNT_WIDTH };
        let columns = Columns::new(shown.len(), widest(labels, font) + LABEL_GAP, &width);
        let width = columns.page_width;
        let mut page = Page::new(font, width, &self.title, &self.subtitle);
        let mut has_arrow = false;
        for line in shown.chunks(columns.lefts.len()) {
            let top = page.y + CAPTION_HEIGHT;
            names(&mut page, labels, columns.lefts[0], top);
            for (row, &left) in line.iter().zip(&columns.lefts) {
                let right = left + columns.plot_width;
                let outer = Rect { left, top, right, bottom: top + rows_height(labels) };
                has_arrow |= panel(&mut page, &self.styles, row, outer);
            }
            page.y = top + rows_height(labels) + TICKS_HEIGHT + PANEL_GAP;
        }
        let mut below = vec![key(self.dot, &shown, has_arrow)];
        below.extend(self.notes);
        Some(page.finish(&below))
    }
}

fn rows_height(labels: &[String]) -> f64 {
    labels.iter().map(|_| ROW_HEIGHT).sum()
}

fn middle_of(top: f64, member: usize) -> f64 {
    top + ROW_HEIGHT * (0.5 + u32::try_from(member).map_or(0.0, f64::from))
}

fn names(page: &mut Page, labels: &[String], left: f64, top: f64) {
    for (member, label) in labels.iter().enumerate() {
        page.drawing.text(
            label,
            [left - LABEL_GAP, middle_of(top, member)],
            Pinned::Right,
            BODY,
            INK,
        );
    }
}

/// What the marks mean.
fn key(dot: &str, shown: &[&Row], has_arrow: bool) -> String {
    let counts =
        || shown.iter().flat_map(|row| &row.cells).map(|(_, parameter)| sample_count(parameter));
    let mut key = format!("A dot is a {dot}, a black bar the median.");
    if counts().any(|count| count >= LEAST_FOR_A_BOX) {
        key.push_str(" Box: quartiles. Whiskers: furthest value within 1.5 interquartile ranges; a cross lies beyond.");
    }
    if counts().any(|count| (1..LEAST_FOR_A_BOX).contains(&count)) {
        key.push_str(&format!(" Fewer than 5 {dot}s have no box."));
    }
    if has_arrow {
        key.push_str(" An arrow with a number is a value beyond the axis.");
    }
    key
}

fn sample_count(parameter: &Parameter) -> usize {
    parameter.samples.iter().filter_map(drawn).count()
}

fn has_box(parameter: &Parameter) -> bool {
    parameter.statistics.is_some() && sample_count(parameter) >= LEAST_FOR_A_BOX
}

/// One side of a row beyond the axis.
struct Beyond {
    label: String,
    width: f64,
}

impl Beyond {
    /// The values of a parameter beyond the axis on one side, in a few words; none without any.
    fn new(parameter: &Parameter, font: &Font, axis: &Axis, side: Side) -> Option<Self> {
        let values: Vec<f64> = parameter
            .samples
            .iter()
            .filter_map(drawn)
            .filter(|&value| axis.side(value) == side)
            .collect();
        let low = values.iter().copied().reduce(f64::min)?;
        let high = values.iter().copied().reduce(f64::max)?;
        let label = match values.len() {
            1 => axis.label(low),
            count => format!("{count}: {} to {}", axis.label(low), axis.label(high)),
        };
        let width = font.width(&label, SMALL);
        Some(Self { label, width })
    }
}

/// Room for an arrow and the gap to its number.
const ARROW_ROOM: f64 = 12.0;

/// The room that one margin needs.
fn room(side: &[Option<Beyond>]) -> f64 {
    side.iter().flatten().map(|beyond| beyond.width + 2.0 * ARROW_ROOM).fold(0.0, f64::max)
}

/// Draws a panel; returns whether values lie beyond its axis.
fn panel(page: &mut Page, styles: &[Style], row: &Row, outer: Rect) -> bool {
    let boxes: Vec<[f64; 2]> = row
        .cells
        .iter()
        .filter(|(_, parameter)| has_box(parameter))
        .filter_map(|(_, parameter)| parameter.statistics.as_ref())
        .flat_map(|statistics| [statistics.whiskers, [statistics.q1, statistics.q3]])
        .collect();
    let Some(span) = span(&row.values(), &boxes) else { return false };
    // Numbers at the margin take room from the axis, whose ticks may then leave out another power of ten.
    let beyond = |axis: &Axis, side: Side| -> Vec<Option<Beyond>> {
        row.cells
            .iter()
            .map(|(_, parameter)| Beyond::new(parameter, page.font, axis, side))
            .collect()
    };
    let width = outer.right - outer.left;
    let wide = level_axis(page.font, span, width);
    let [room_below, room_above] =
        [Side::Below, Side::Above].map(|side| room(&beyond(&wide, side)));
    let axis = level_axis(page.font, span, width - room_below - room_above);
    let (below, above) = (beyond(&axis, Side::Below), beyond(&axis, Side::Above));
    let inner =
        [outer.left + room(&below).max(room_below), outer.right - room(&above).max(room_above)];
    let plot = Rect { left: inner[0], right: inner[1], ..outer };
    let caption = outer.top - 0.5 * CAPTION_HEIGHT - 1.0;
    page.drawing.text(
        &axis.caption(row.name, row.unit),
        [outer.left, caption],
        Pinned::Left,
        BODY,
        INK,
    );
    let count_at = outer.right + 0.5 * COUNT_WIDTH - 6.0;
    page.drawing.text("n", [count_at, caption], Pinned::Center, SMALL, GREY);
    level_ticks(page, plot, &axis);
    for (index, (member, parameter)) in row.cells.iter().enumerate() {
        let y = middle_of(outer.top, *member);
        cell(page, parameter, &styles[*member], plot, &axis, y);
        margin(page, below[index].as_ref(), [outer.left, y], -1.0);
        margin(page, above[index].as_ref(), [outer.right, y], 1.0);
        page.drawing.text(&count(parameter), [count_at, y], Pinned::Center, SMALL, GREY);
    }
    below.iter().chain(&above).any(Option::is_some)
}

/// `6`, or `5 of 6` where some are not drawn.
fn count(parameter: &Parameter) -> String {
    let (drawn, all) = (sample_count(parameter), parameter.samples.len());
    if drawn == all { format!("{all}") } else { format!("{drawn} of {all}") }
}

fn margin(page: &mut Page, beyond: Option<&Beyond>, [x, y]: [f64; 2], direction: f64) {
    let Some(beyond) = beyond else { return };
    arrow(&mut page.drawing, [x, y], [direction, 0.0], INK);
    let pinned = if direction < 0.0 { Pinned::Left } else { Pinned::Right };
    page.drawing.text(&beyond.label, [x - direction * ARROW_ROOM, y], pinned, SMALL, INK);
}

fn cell(page: &mut Page, parameter: &Parameter, style: &Style, plot: Rect, axis: &Axis, y: f64) {
    if sample_count(parameter) == 0 {
        let words = match held_values(parameter, &parameter.unit) {
            Some(values) => format!("held at {values}"),
            None => "no value".to_owned(),
        };
        let words = page.font.shorten(&words, SMALL, plot.right - plot.left - 12.0);
        return page.drawing.text(&words, [plot.left + 6.0, y], Pinned::Left, SMALL, GREY);
    }
    let x = |value: f64| plot.left + axis.share(value) * (plot.right - plot.left);
    // The median lies over the dots of a box and under the few without one, of which it could hide one.
    if has_box(parameter) {
        draw_box(&mut page.drawing, parameter, style, &x, y);
        dots(&mut page.drawing, parameter, style, (axis, &x), y);
        median(&mut page.drawing, parameter, (axis, &x), y);
    } else {
        median(&mut page.drawing, parameter, (axis, &x), y);
        dots(&mut page.drawing, parameter, style, (axis, &x), y);
    }
}

fn median(
    drawing: &mut Drawing,
    parameter: &Parameter,
    (axis, x): (&Axis, &impl Fn(f64) -> f64),
    y: f64,
) {
    let Some(statistics) = &parameter.statistics else { return };
    if axis.side(statistics.median) == Side::Within {
        let at = x(statistics.median);
        drawing.line(&[[at, y - HALF_BOX], [at, y + HALF_BOX]], INK, 2.0);
    }
}

fn draw_box(
    drawing: &mut Drawing,
    parameter: &Parameter,
    style: &Style,
    x: &impl Fn(f64) -> f64,
    y: f64,
) {
    /// How much of its colour a box is filled with: dots of that colour must stand out.
    const TINT: f64 = 0.16;
    const CAP: f64 = 4.0;
    let Some(statistics) = &parameter.statistics else { return };
    let [q1, q3] = [x(statistics.q1), x(statistics.q3)];
    let [low, high] = statistics.whiskers.map(x);
    // A quartile between two samples may lie beyond the furthest one that a whisker reaches.
    for (quartile, end) in [(q1, low.min(q1)), (q3, high.max(q3))] {
        drawing.line(&[[quartile, y], [end, y]], GREY, 1.2);
        drawing.line(&[[end, y - CAP], [end, y + CAP]], GREY, 1.2);
    }
    let frame = Rect { left: q1, top: y - HALF_BOX, right: q3, bottom: y + HALF_BOX };
    let [a, b, c, d] = frame.corners();
    drawing.area(&[a, b, c, d], style.color.faded(TINT));
    drawing.line(&[a, b, c, d, a], style.color, 1.2);
}

fn dots(
    drawing: &mut Drawing,
    parameter: &Parameter,
    style: &Style,
    (axis, x): (&Axis, &impl Fn(f64) -> f64),
    y: f64,
) {
    /// More dots than this hide each other: they shrink and let light through.
    const CROWD: usize = 60;
    /// Half the height over which dots are strewn, so that near ones show apart.
    const STREWN: f64 = 5.0;
    /// The golden ratio's fractional part: its multiples never bunch.
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let is_crowd = parameter.samples.len() > CROWD;
    let (radius, opacity) = if is_crowd { (1.6, 0.4) } else { (2.4, 0.8) };
    let has_box = has_box(parameter);
    let mut turn = 0.0;
    for sample in &parameter.samples {
        turn = (turn + GOLDEN) % 1.0;
        let Some(value) = drawn(sample).filter(|&value| axis.side(value) == Side::Within) else {
            continue;
        };
        let at = [x(value), y + STREWN * (2.0 * turn - 1.0)];
        if has_box && sample.is_outlier {
            cross(drawing, at, 3.5, style.color);
        } else {
            drawing.disc(at, radius, style.color.faded(opacity));
        }
    }
}
