//! A table of text cells, written for a terminal or in Markdown.

use std::fmt::Write;

use anstyle::Style;

/// Between columns.
const GAP: &str = "  ";

/// A table: the first columns are text and flush left, the others numbers and flush right.
#[derive(Debug, Clone, Default)]
pub(super) struct Table {
    pub text_columns: usize,
    /// What stands above the header, each over some columns from the left on; Markdown puts it into the header.
    pub above: Vec<Span>,
    pub header: Vec<String>,
    pub rows: Vec<Vec<Cell>>,
}

/// A title over a run of columns.
#[derive(Debug, Clone)]
pub(super) struct Span {
    pub columns: usize,
    pub title: String,
}

/// A cell and how strongly it speaks.
#[derive(Debug, Clone, Default)]
pub(super) struct Cell {
    pub text: String,
    pub tone: Tone,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Tone {
    #[default]
    Plain,
    /// Not a result: held, unknown.
    Faint,
    /// To be looked at.
    Loud,
}

impl Tone {
    pub(super) fn style(self) -> Style {
        match self {
            Self::Plain => Style::new(),
            Self::Faint => Style::new().dimmed(),
            Self::Loud => Style::new().fg_color(Some(anstyle::AnsiColor::Yellow.into())),
        }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), tone: Tone::Plain }
    }
}

impl Cell {
    pub(super) fn faint(text: impl Into<String>) -> Self {
        Self { text: text.into(), tone: Tone::Faint }
    }

    pub(super) fn loud(text: impl Into<String>) -> Self {
        Self { text: text.into(), tone: Tone::Loud }
    }
}

impl Table {
    /// Without the columns that hold nothing in any row.
    pub(super) fn without_empty_columns(self) -> Self {
        let is_empty = |column: usize| self.rows.iter().all(|row| row[column].text.is_empty());
        let keep = (0..self.header.len()).map(|column| !is_empty(column)).collect();
        self.only(keep)
    }

    /// Without the columns of these headers.
    pub(super) fn without_columns(self, headers: &[&str]) -> Self {
        let keep = self.header.iter().map(|header| !headers.contains(&header.as_str())).collect();
        self.only(keep)
    }

    fn only(mut self, keep: Vec<bool>) -> Self {
        self.text_columns = keep.iter().take(self.text_columns).filter(|keep| **keep).count();
        let mut columns = keep.iter();
        self.header.retain(|_| columns.next().is_some_and(|keep| *keep));
        for row in &mut self.rows {
            let mut columns = keep.iter();
            row.retain(|_| columns.next().is_some_and(|keep| *keep));
        }
        self
    }

    /// Aligned columns, two blanks between them.
    pub(super) fn text(&self) -> String {
        let widths = self.widths();
        let mut out = String::new();
        let bold = Style::new().bold();
        let mut columns = widths.iter();
        let mut titles = String::new();
        for Span { columns: count, title } in &self.above {
            let width: usize = columns.by_ref().take(*count).map(|width| width + GAP.len()).sum();
            titles.push_str(&format!("{GAP}{title:<fill$}", fill = width - GAP.len()));
        }
        if !self.above.is_empty() {
            out.push_str(&format!("{bold}{}{bold:#}\n", titles.trim_end()));
        }
        let header: Vec<Cell> = self.header.iter().map(|text| text.as_str().into()).collect();
        self.text_row(&mut out, &widths, &header, |_| bold);
        for row in &self.rows {
            self.text_row(&mut out, &widths, row, |cell| cell.tone.style());
        }
        out
    }

    /// How wide the text form is, in characters.
    pub(super) fn width(&self) -> usize {
        self.widths().iter().map(|width| width + GAP.len()).sum()
    }

    fn widths(&self) -> Vec<usize> {
        let width = |column: usize| {
            let cells = self.rows.iter().map(|row| row[column].text.as_str());
            cells.chain([self.header[column].as_str()]).map(|text| text.chars().count()).max()
        };
        let mut widths: Vec<usize> =
            (0..self.header.len()).map(|column| width(column).unwrap_or(0)).collect();
        let mut start = 0;
        for span in &self.above {
            let end = start + span.columns;
            let room = widths[start..end].iter().map(|width| width + GAP.len()).sum::<usize>();
            widths[start] += (span.title.chars().count() + GAP.len()).saturating_sub(room);
            start = end;
        }
        widths
    }

    fn text_row(
        &self,
        out: &mut String,
        widths: &[usize],
        row: &[Cell],
        style: impl Fn(&Cell) -> Style,
    ) {
        let mut line = String::new();
        for (column, (cell, width)) in row.iter().zip(widths).enumerate() {
            let pad = " ".repeat(width - cell.text.chars().count());
            let (style, text) = (style(cell), &cell.text);
            let text =
                if text.is_empty() { String::new() } else { format!("{style}{text}{style:#}") };
            let cell = if column < self.text_columns { text + &pad } else { pad + &text };
            line.push_str(GAP);
            line.push_str(&cell);
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }

    /// A Markdown table.
    pub(super) fn markdown(&self) -> String {
        let mut out = String::new();
        let mut line = |cells: &mut dyn Iterator<Item = String>| {
            let cells: Vec<String> = cells.collect();
            let _ = writeln!(out, "| {} |", cells.join(" | "));
        };
        let above = self
            .above
            .iter()
            .flat_map(|Span { columns, title }| std::iter::repeat_n(title.as_str(), *columns));
        let above = above.chain(std::iter::repeat(""));
        line(
            &mut self
                .header
                .iter()
                .zip(above)
                .map(|(text, above)| escaped(format!("{above} {text}").trim())),
        );
        let rule = |column| if column < self.text_columns { "---" } else { "---:" };
        line(&mut (0..self.header.len()).map(|column| rule(column).to_owned()));
        for row in &self.rows {
            line(&mut row.iter().map(|cell| escaped(&cell.text)));
        }
        out
    }
}

/// Text that Markdown shows as it is.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        if matches!(c, '\\' | '|' | '*' | '_' | '`' | '<' | '>' | '[' | ']' | '#') {
            out.push('\\');
        }
        out.push(if c.is_control() { ' ' } else { c });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let header = ["parameter", "mean", "note"].map(str::to_owned).to_vec();
        let rows = vec![
            vec!["fx".into(), "425.3".into(), "".into()],
            vec!["k1".into(), Cell::faint("-0.356"), "".into()],
        ];
        Table { text_columns: 1, above: vec![], header, rows }
    }

    #[test]
    fn numbers_align_right_and_words_left() {
        let plain = anstream::adapter::strip_str(&table().text()).to_string();
        assert_eq!(plain, "  parameter    mean  note\n  fx          425.3\n  k1         -0.356\n");
    }

    #[test]
    fn what_stands_above_spans_its_columns_and_widens_them() {
        let mut table = table().without_empty_columns();
        let title = |title: &str| Span { columns: 1, title: title.to_owned() };
        table.above = vec![title(""), title("a long title")];
        let plain = anstream::adapter::strip_str(&table.text()).to_string();
        let want = "             a long title\n  parameter          mean\n  fx                425.3\n  k1               -0.356\n";
        assert_eq!(plain, want);
        assert!(table.markdown().starts_with("| parameter | a long title mean |\n"));
    }

    #[test]
    fn markdown_escapes_what_it_would_eat() {
        let mut table = table().without_empty_columns();
        table.rows[0][0] = "a|b_*c".into();
        let want =
            "| parameter | mean |\n| --- | ---: |\n| a\\|b\\_\\*c | 425.3 |\n| k1 | -0.356 |\n";
        assert_eq!(table.markdown(), want);
    }
}
