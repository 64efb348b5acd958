//! Focal length against distortion: where the two compensate, the points lie on a slope.

use crate::stability::{Compensation, Correlations, Parameter, Population};

use super::axis::{Axis, Side};
use super::color::{GREY, INK};
use super::columns::{Columns, PanelWidth};
use super::drawing::{Drawing, Pinned, Point, Rect};
use super::font::{Font, clean};
use super::frame::{left_room, level_axis, level_ticks, upright_axis, upright_ticks};
use super::labels::labels;
use super::legend::{Sample, legend};
use super::marker::{Style, arrow};
use super::notes::notes;
use super::number::{fixed, significant, unbroken};
use super::page::{BODY, Page, SMALL};
use super::range::span;
use super::subject::{Row, Subject, drawn};

/// Width of a plot: alone on its line, or one of two.
const PLOT_WIDTHS: [f64; 2] = [460.0, 280.0];
const LEAST_PLOT_HEIGHT: f64 = 190.0;
const CAPTION_HEIGHT: f64 = 24.0;
const TICKS_HEIGHT: f64 = 22.0;
const AXIS_NAME_HEIGHT: f64 = 20.0;
const PANEL_GAP: f64 = 16.0;
/// The table of correlations beside a plot: its width, and the height of one line.
const TABLE_WIDTH: f64 = 134.0;
const TABLE_ROW: f64 = 18.0;
/// More values than this beyond the axes are counted, not listed.
const MOST_LISTED: usize = 12;

/// One panel: two parameters in the groups that have both.
struct Panel<'a> {
    focal: &'a Row<'a>,
    distortion: &'a Row<'a>,
    /// Index among the members, and what goes with it.
    cells: Vec<Cell<'a>>,
    x: Axis,
    y: Axis,
}

struct Cell<'a> {
    member: usize,
    compensation: &'a Compensation,
    /// Run, focal length and distortion of every run that has both.
    pairs: Vec<(&'a str, Point)>,
    /// Where the adjustments expect the runs; none where they do not say.
    expected: Option<Expected>,
}

/// Two parameters by the mean covariance of the adjustments, about their mean.
struct Expected {
    mean: Point,
    std: Point,
    correlation: f64,
}

/// The figure; none without a pair of parameters that vary.
pub fn draw(subject: &Subject, font: &Font) -> Option<Drawing> {
    let rows = subject.rows();
    let height =
        LEAST_PLOT_HEIGHT.max(subject.members.iter().map(|_| TABLE_ROW).sum::<f64>() + TABLE_ROW);
    let panels = panels(subject, &rows, font, height);
    if panels.is_empty() {
        return None;
    }
    let room = panels.iter().map(|panel| left_room(&panel.y, font)).fold(0.0, f64::max);
    let width = PanelWidth { left: room, plot: PLOT_WIDTHS, right: TABLE_WIDTH };
    let columns = Columns::new(panels.len(), 0.0, &width);
    let width = columns.page_width;
    let mut page =
        Page::new(font, width, &subject.words(), "Distortion against focal length, a point a run");
    let styles: Vec<Style> = subject.members.iter().map(|member| member.style).collect();
    legend(&mut page, &labels(subject, font), &styles, Sample::Marker);
    let mut beyond = Vec::new();
    for line in panels.chunks(columns.lefts.len()) {
        let top = page.y + CAPTION_HEIGHT;
        for (panel, left) in line.iter().zip(&columns.lefts) {
            let plot =
                Rect { left: *left, top, right: left + columns.plot_width, bottom: top + height };
            panel.draw(&mut page, subject, plot);
            panel.list_beyond(subject, &mut beyond);
        }
        page.y = top + height + TICKS_HEIGHT + AXIS_NAME_HEIGHT + PANEL_GAP;
    }
    let mut below = vec!["r: Pearson's correlation over all n runs that have both.".to_owned()];
    if panels.iter().flat_map(|panel| &panel.cells).any(|cell| cell.expected.is_some()) {
        below.push("Ellipse: where the adjustments expect 95 % of the runs.".to_owned());
    }
    below.extend(listed(&beyond));
    below.extend(notes(subject, &rows));
    Some(page.finish(&below))
}

/// A run beyond the axes of some panels, with its values there.
struct Beyond {
    run: String,
    values: Vec<String>,
}

fn listed(beyond: &[Beyond]) -> Option<String> {
    let (listed, more) = beyond.split_at(beyond.len().min(MOST_LISTED));
    let more =
        if more.is_empty() { String::new() } else { format!("; and {} more runs", more.len()) };
    let words: Vec<String> = listed
        .iter()
        .map(|Beyond { run, values }| format!("{run} ({})", values.join(", ")))
        .collect();
    (!beyond.is_empty())
        .then(|| format!("An arrow points to a run beyond the axes: {}{more}.", words.join("; ")))
}

fn panels<'a>(
    subject: &'a Subject,
    rows: &'a [Row<'a>],
    font: &Font,
    height: f64,
) -> Vec<Panel<'a>> {
    let mut names: Vec<(&str, &str)> = Vec::new();
    for entry in subject.members.iter().flat_map(|member| &member.population.compensation) {
        let name = (entry.focal.as_str(), entry.distortion.as_str());
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let row_of = |name: &str| rows.iter().find(|row| row.name == name);
    names
        .into_iter()
        .filter_map(|(focal, distortion)| {
            Panel::new(subject, row_of(focal)?, row_of(distortion)?, font, height)
        })
        .collect()
}

impl<'a> Panel<'a> {
    fn new(
        subject: &'a Subject,
        focal: &'a Row,
        distortion: &'a Row,
        font: &Font,
        height: f64,
    ) -> Option<Self> {
        let of = |row: &Row<'a>, member: usize| {
            row.cells.iter().find(|(at, _)| *at == member).map(|(_, p)| *p)
        };
        let cells: Vec<Cell> = subject
            .members
            .iter()
            .enumerate()
            .filter_map(|(member, known)| {
                let is_this = |entry: &&Compensation| {
                    entry.focal == focal.name && entry.distortion == distortion.name
                };
                let compensation = known.population.compensation.iter().find(is_this)?;
                let pairs = pairs(of(focal, member)?, of(distortion, member)?);
                let both = [of(focal, member)?, of(distortion, member)?];
                let expected = expected(known.population, both);
                (!pairs.is_empty()).then_some(Cell { member, compensation, pairs, expected })
            })
            .collect();
        let values = |axis: usize| {
            cells.iter().flat_map(|cell| &cell.pairs).map(|(_, at)| at[axis]).collect::<Vec<f64>>()
        };
        let x = level_axis(font, span(&values(0), &[])?, PLOT_WIDTHS[1]);
        let y = upright_axis(span(&values(1), &[])?, height);
        Some(Self { focal, distortion, cells, x, y })
    }

    fn draw(&self, page: &mut Page, subject: &Subject, plot: Rect) {
        let Rect { left, top, right, bottom } = plot;
        let caption = self.y.caption(self.distortion.name, self.distortion.unit);
        page.drawing.text(
            &caption,
            [left, top - 0.5 * CAPTION_HEIGHT - 1.0],
            Pinned::Left,
            BODY,
            INK,
        );
        level_ticks(page, plot, &self.x);
        upright_ticks(page, plot, &self.y);
        let name_at = bottom + TICKS_HEIGHT + 0.5 * AXIS_NAME_HEIGHT;
        let name = self.x.caption(self.focal.name, self.focal.unit);
        page.drawing.text(&name, [0.5 * (left + right), name_at], Pinned::Center, BODY, INK);
        for cell in &self.cells {
            let style = subject.members[cell.member].style;
            if let Some(expected) = &cell.expected {
                self.ellipse(page, plot, expected, &style);
            }
            for &(_, at) in &cell.pairs {
                self.point(page, plot, at, &style, cell.pairs.len());
            }
        }
        self.table(page, subject, plot);
    }

    /// Where 95 % of normal runs lie; as far as it is within the axes.
    fn ellipse(&self, page: &mut Page, plot: Rect, expected: &Expected, style: &Style) {
        const STEPS: u32 = 120;
        /// Root of the 95 % quantile of chi-square with 2 degrees, -2 ln 0.05.
        const RADIUS: f64 = 2.447_746_830_680_816;
        let Expected { mean, std, correlation } = expected;
        let rest = (1.0 - correlation * correlation).max(0.0).sqrt();
        let at = |step: u32| {
            let turn = std::f64::consts::TAU * f64::from(step) / f64::from(STEPS);
            let [along, across] = [turn.cos(), correlation * turn.cos() + rest * turn.sin()];
            let focal = mean[0] + RADIUS * std[0] * along;
            let distortion = mean[1] + RADIUS * std[1] * across;
            let (x, y) = (self.x.share(focal), self.y.share(distortion));
            let is_within = direction(self.x.side(focal), self.y.side(distortion)).is_none();
            is_within.then(|| {
                let x = plot.left + x * (plot.right - plot.left);
                [x, plot.bottom - y * (plot.bottom - plot.top)]
            })
        };
        let points: Vec<Option<Point>> = (0..=STEPS).map(at).collect();
        for part in points.split(Option::is_none).filter(|part| part.len() > 1) {
            let part: Vec<Point> = part.iter().flatten().copied().collect();
            page.drawing.line(&part, style.color.faded(0.7), 0.9);
        }
    }

    fn point(
        &self,
        page: &mut Page,
        plot: Rect,
        [focal, distortion]: Point,
        style: &Style,
        count: usize,
    ) {
        /// More points than this hide each other.
        const CROWD: usize = 100;
        /// How far from the border an arrow ends. The padding of the axes keeps other points further in.
        const INSET: f64 = 4.0;
        let (x, y) = (self.x.share(focal), self.y.share(distortion));
        let at = [
            (plot.left + x * (plot.right - plot.left)).clamp(plot.left + INSET, plot.right - INSET),
            (plot.bottom - y * (plot.bottom - plot.top))
                .clamp(plot.top + INSET, plot.bottom - INSET),
        ];
        match direction(self.x.side(focal), self.y.side(distortion)) {
            Some(direction) => arrow(&mut page.drawing, at, direction, style.color),
            None if count > CROWD => {
                style.marker.draw(&mut page.drawing, at, 1.6, style.color.faded(0.6))
            }
            None => style.marker.draw(&mut page.drawing, at, 3.5, style.color),
        }
    }

    /// Correlation and count of each group, under its mark.
    fn table(&self, page: &mut Page, subject: &Subject, plot: Rect) {
        let [mark, correlation, count] = [20.0, 72.0, 110.0].map(|x| plot.right + x);
        let mut y = plot.top + 0.5 * TABLE_ROW;
        page.drawing.text("r", [correlation, y], Pinned::Right, SMALL, GREY);
        page.drawing.text("n", [count, y], Pinned::Right, SMALL, GREY);
        for cell in &self.cells {
            y += TABLE_ROW;
            let style = subject.members[cell.member].style;
            style.marker.draw(&mut page.drawing, [mark, y], 3.5, style.color);
            let r = cell.compensation.correlation.map_or("none".to_owned(), |r| fixed(r, 2));
            page.drawing.text(&r, [correlation, y], Pinned::Right, SMALL, INK);
            page.drawing.text(
                &cell.compensation.n.to_string(),
                [count, y],
                Pinned::Right,
                SMALL,
                INK,
            );
        }
    }

    /// Adds the runs that lie beyond the axes, with their values on both.
    fn list_beyond(&self, subject: &Subject, list: &mut Vec<Beyond>) {
        let is_beyond = |at: Point| direction(self.x.side(at[0]), self.y.side(at[1])).is_some();
        for cell in &self.cells {
            for (run, at) in cell.pairs.iter().filter(|(_, at)| is_beyond(*at)) {
                let run = format!("{} of {}", clean(run), subject.members[cell.member].group);
                let known = list.iter().position(|beyond| beyond.run == run).unwrap_or_else(|| {
                    list.push(Beyond { run, values: Vec::new() });
                    list.len() - 1
                });
                for (row, value) in [self.focal, self.distortion].iter().zip(at) {
                    let words = unbroken(&format!("{} {}", row.name, significant(*value, 6)));
                    if !list[known].values.contains(&words) {
                        list[known].values.push(words);
                    }
                }
            }
        }
    }
}

/// The runs that have both parameters, paired by their place in the group.
fn pairs<'a>(focal: &'a Parameter, distortion: &'a Parameter) -> Vec<(&'a str, Point)> {
    let both = focal.samples.iter().zip(&distortion.samples);
    both.filter_map(|(x, y)| Some((x.run.as_str(), [drawn(x)?, drawn(y)?]))).collect()
}

/// What the adjustments of a population say of two of its parameters.
fn expected(population: &Population, both: [&Parameter; 2]) -> Option<Expected> {
    let Correlations { parameters, matrix } = population.predicted_correlations.as_ref()?;
    let place = |one: &Parameter| parameters.iter().position(|name| *name == one.name);
    let correlation = matrix[place(both[0])?][place(both[1])?]?;
    let mean = |one: &Parameter| Some(one.statistics.as_ref()?.mean);
    let [x, y] = both;
    let std = [x.predicted_std?, y.predicted_std?];
    Some(Expected { mean: [mean(x)?, mean(y)?], std, correlation })
}

/// The way to a point beyond the axes; none within.
fn direction(x: Side, y: Side) -> Option<Point> {
    const DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let signs = [x, y].map(|side| match side {
        Side::Below => -1.0,
        Side::Within => 0.0,
        Side::Above => 1.0,
    });
    match (x, y) {
        (Side::Within, Side::Within) => None,
        (Side::Within, _) | (_, Side::Within) => Some([signs[0], -signs[1]]),
        _ => Some([DIAGONAL * signs[0], -DIAGONAL * signs[1]]),
    }
}
