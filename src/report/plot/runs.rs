//! A parameter against the run: what drifts, jumps or breaks off.

use crate::stability::Parameter;

use super::axis::{Axis, Side};
use super::color::{GREY, INK, PAPER};
use super::columns::{Columns, PanelWidth};
use super::drawing::{Drawing, Pinned, Point, Rect};
use super::font::Font;
use super::frame::{left_room, level_ticks, run_axis, upright_axis, upright_ticks};
use super::labels::labels;
use super::legend::{Sample, legend};
use super::marker::{Style, arrow, dashed};
use super::notes::notes;
use super::number::significant;
use super::page::{BODY, Page, SMALL};
use super::range::span;
use super::subject::{Row, Subject, drawn};

/// Width of a plot: alone on its line, or one of two.
const PLOT_WIDTHS: [f64; 2] = [560.0, 360.0];
const PLOT_HEIGHT: f64 = 150.0;
const CAPTION_HEIGHT: f64 = 24.0;
const TICKS_HEIGHT: f64 = 22.0;
const AXIS_NAME_HEIGHT: f64 = 16.0;
const PANEL_GAP: f64 = 16.0;
const COLUMN_GAP: f64 = 24.0;
/// Room above or below a plot for arrows with their numbers.
const STRIP: f64 = 18.0;
/// With more runs than this lines between them are a black scribble.
const MOST_FOR_LINES: usize = 100;

/// One panel: a parameter, its axis, and where it is drawn.
struct Panel<'a> {
    row: &'a Row<'a>,
    axis: Axis,
    plot: Rect,
    has_lines: bool,
}

/// The figure; none where nothing varies.
pub fn draw(subject: &Subject, font: &Font) -> Option<Drawing> {
    let rows = subject.rows();
    let shown: Vec<(&Row, Axis)> = rows
        .iter()
        .filter_map(|row| Some((row, upright_axis(span(&row.values(), &[])?, PLOT_HEIGHT))))
        .collect();
    if shown.is_empty() {
        return None;
    }
    let room = shown.iter().map(|(_, axis)| left_room(axis, font)).fold(0.0, f64::max);
    let width = PanelWidth { left: room, plot: PLOT_WIDTHS, right: COLUMN_GAP };
    let columns = Columns::new(shown.len(), 0.0, &width);
    let width = columns.page_width;
    let mut page = Page::new(
        font,
        width,
        &subject.words(),
        "Each parameter by run, in the order of the runs of a group",
    );
    let styles: Vec<Style> = subject.members.iter().map(|member| member.style).collect();
    let run_count =
        rows.iter().flat_map(|row| &row.cells).map(|(_, p)| p.samples.len()).max().unwrap_or(1);
    let sample = if run_count > MOST_FOR_LINES { Sample::Marker } else { Sample::MarkerOnLine };
    legend(&mut page, &labels(subject, font), &styles, sample);
    let runs = run_axis(font, run_count, columns.plot_width);
    let mut unlabelled = Vec::new();
    for line in shown.chunks(columns.lefts.len()) {
        let top = page.y + CAPTION_HEIGHT;
        for ((row, axis), left) in line.iter().zip(&columns.lefts) {
            let plot = Rect {
                left: *left,
                top,
                right: left + columns.plot_width,
                bottom: top + PLOT_HEIGHT,
            };
            let panel =
                Panel { row, axis: axis.clone(), plot, has_lines: run_count <= MOST_FOR_LINES };
            unlabelled.extend(panel.draw(&mut page, subject, &runs));
        }
        page.y = top + PLOT_HEIGHT + TICKS_HEIGHT + AXIS_NAME_HEIGHT + PANEL_GAP;
    }
    let mut below = key(&shown);
    below.extend(unlabelled);
    below.extend(notes(subject, &rows));
    Some(page.finish(&below))
}

fn key(shown: &[(&Row, Axis)]) -> Vec<String> {
    let is_beyond = |(row, axis): &(&Row, Axis)| {
        row.values().iter().any(|&value| axis.side(value) != Side::Within)
    };
    let has_arrow = shown.iter().any(is_beyond);
    has_arrow
        .then(|| "An arrow with a number is a value beyond the axis.".to_owned())
        .into_iter()
        .collect()
}

impl Panel<'_> {
    /// Draws the panel; returns a note where arrows have no room for their numbers.
    fn draw(&self, page: &mut Page, subject: &Subject, runs: &Axis) -> Option<String> {
        let Rect { left, top, right, bottom } = self.plot;
        let caption = self.axis.caption(self.row.name, self.row.unit);
        page.drawing.text(
            &caption,
            [left, top - 0.5 * CAPTION_HEIGHT - 1.0],
            Pinned::Left,
            BODY,
            INK,
        );
        let inner = Rect {
            top: top + self.strip(Side::Above),
            bottom: bottom - self.strip(Side::Below),
            ..self.plot
        };
        level_ticks(page, self.plot, runs);
        upright_ticks(page, inner, &self.axis);
        let name_at = bottom + TICKS_HEIGHT + 0.5 * AXIS_NAME_HEIGHT;
        page.drawing.text("run", [0.5 * (left + right), name_at], Pinned::Center, SMALL, GREY);
        for (member, parameter) in &self.row.cells {
            self.series(page, parameter, &subject.members[*member].style, (inner, runs));
        }
        let mut unlabelled: Vec<f64> = self.arrows(page, subject, Side::Above, runs);
        unlabelled.extend(self.arrows(page, subject, Side::Below, runs));
        let low = unlabelled.iter().copied().reduce(f64::min)?;
        let high = unlabelled.iter().copied().reduce(f64::max)?;
        let (name, count) = (self.row.name, unlabelled.len());
        let [low, high] = [low, high].map(|value| significant(value, 6));
        let unit =
            if self.row.unit.is_empty() { String::new() } else { format!(" {}", self.row.unit) };
        Some(format!("{name}: {count} more beyond the axis, {low} to {high}{unit}."))
    }

    /// The height of the strip on this side: none where no value lies there.
    fn strip(&self, side: Side) -> f64 {
        if self.row.values().iter().any(|&value| self.axis.side(value) == side) {
            STRIP
        } else {
            0.0
        }
    }

    /// The runs of one group: joined by lines where they are few, with a gap where one failed.
    fn series(
        &self,
        page: &mut Page,
        parameter: &Parameter,
        style: &Style,
        (inner, runs): (Rect, &Axis),
    ) {
        let points: Vec<Option<(Side, Point)>> = (1_u32..)
            .zip(&parameter.samples)
            .map(|(position, sample)| {
                let value = drawn(sample)?;
                let side = self.axis.side(value);
                let y = match side {
                    Side::Above => self.plot.top + 0.5 * STRIP,
                    Side::Within => {
                        inner.bottom - self.axis.share(value) * (inner.bottom - inner.top)
                    }
                    Side::Below => self.plot.bottom - 0.5 * STRIP,
                };
                Some((side, [across(inner, runs.share(f64::from(position))), y]))
            })
            .collect();
        if self.has_lines {
            for piece in points.split(Option::is_none).filter(|piece| piece.len() > 1) {
                let piece: Vec<Point> = piece.iter().flatten().map(|(_, at)| *at).collect();
                dashed(&mut page.drawing, &piece, style, 1.2);
            }
        }
        let (radius, opacity) = if self.has_lines { (3.2, 1.0) } else { (1.6, 0.6) };
        for (_, point) in points.into_iter().flatten().filter(|(side, _)| *side == Side::Within) {
            style.marker.draw(&mut page.drawing, point, radius, style.color.faded(opacity));
        }
    }

    /// Arrows to the values beyond one side, from left to right, with their numbers where there is room; returns the
    /// values that found none.
    fn arrows(&self, page: &mut Page, subject: &Subject, side: Side, runs: &Axis) -> Vec<f64> {
        let mut beyond: Vec<(u32, f64, usize)> = Vec::new();
        for (member, parameter) in &self.row.cells {
            let values = (1_u32..)
                .zip(&parameter.samples)
                .filter_map(|(at, sample)| Some((at, drawn(sample)?, *member)));
            beyond.extend(values.filter(|&(_, value, _)| self.axis.side(value) == side));
        }
        beyond.sort_by_key(|&(position, _, member)| (position, member));
        let (tip, middle, direction) = match side {
            Side::Above => (self.plot.top + 3.0, self.plot.top + 0.5 * STRIP, -1.0),
            Side::Below | Side::Within => {
                (self.plot.bottom - 3.0, self.plot.bottom - 0.5 * STRIP, 1.0)
            }
        };
        let x_of = |position: u32| across(self.plot, runs.share(f64::from(position)));
        let mut unlabelled = Vec::new();
        let mut free_from = self.plot.left;
        for (index, &(position, value, member)) in beyond.iter().enumerate() {
            let x = x_of(position);
            arrow(
                &mut page.drawing,
                [x, tip],
                [0.0, direction],
                subject.members[member].style.color,
            );
            let label = self.axis.label(value);
            let width = page.font.width(&label, SMALL);
            let next =
                beyond.get(index + 1).map_or(f64::INFINITY, |&(position, ..)| x_of(position) - 8.0);
            let [after, before] = [x + 8.0, x - 8.0 - width];
            if after >= free_from && after + width <= self.plot.right.min(next) {
                self.number(page, &label, [after, middle], width);
                free_from = after + width + 8.0;
            } else if before >= free_from {
                self.number(page, &label, [before, middle], width);
                free_from = x + 8.0;
            } else {
                unlabelled.push(value);
                free_from = free_from.max(x + 8.0);
            }
        }
        unlabelled
    }

    /// The number of an arrow, over whatever lines pass there.
    fn number(&self, page: &mut Page, label: &str, [left, middle]: Point, width: f64) {
        let ground =
            Rect { left: left - 2.0, top: middle - 7.0, right: left + width, bottom: middle + 7.0 };
        page.drawing.area(&ground.corners(), PAPER);
        page.drawing.text(label, [left, middle], Pinned::Left, SMALL, INK);
    }
}

fn across(plot: Rect, share: f64) -> f64 {
    plot.left + share * (plot.right - plot.left)
}
