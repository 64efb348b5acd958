//! How panels stand on a page: one alone, or two to a line.

use super::page::MARGIN;

/// What a panel needs across the page.
pub struct PanelWidth {
    /// Left of the plot.
    pub left: f64,
    /// The plot alone on its line, or beside another.
    pub plot: [f64; 2],
    /// Right of the plot, to the next panel or the margin.
    pub right: f64,
}

/// Where the plots stand.
pub struct Columns {
    /// The left border of each column's plot.
    pub lefts: Vec<f64>,
    pub plot_width: f64,
    pub page_width: f64,
}

impl Columns {
    /// Columns for this many panels, right of `labels`, which stand once a line.
    pub fn new(panel_count: usize, labels: f64, panel: &PanelWidth) -> Self {
        let plot_width = if panel_count == 1 { panel.plot[0] } else { panel.plot[1] };
        let width = panel.left + plot_width + panel.right;
        let mut at = MARGIN + labels;
        let mut lefts = Vec::new();
        for _ in 0..panel_count.min(2) {
            lefts.push(at + panel.left);
            at += width;
        }
        Self { lefts, plot_width, page_width: at + MARGIN }
    }
}
