//! What one standard deviation of a parameter does in the image, so that unlike parameters compare.

use super::Parameter;
use crate::camera::{CameraModel, Grid, Intrinsics, Job, Model};
use crate::stats::Sorted;

/// Fills in the std in px of every parameter that has statistics; gives the share of the image that it is over.
pub(super) fn fill_std_px(
    model: &Model,
    [width, height]: [u64; 2],
    parameters: &mut [Parameter],
) -> Option<f64> {
    let grid = Grid::new(width, height);
    let Effects { seen_count, squares } = mean_camera(model, parameters)?.visit(EffectsOver(grid));
    for (parameter, squares) in parameters.iter_mut().zip(squares) {
        let Some(statistics) = &mut parameter.statistics else { continue };
        let px_per_unit = (squares / seen_count as f64).sqrt();
        statistics.std_px = Some(px_per_unit * statistics.std).filter(|px| px.is_finite());
    }
    Some(seen_count as f64 / grid.cell_count() as f64)
}

/// Each parameter at the mean that its statistics are about; without statistics, held or lone, at the mean of what there is.
fn mean_camera(model: &Model, parameters: &[Parameter]) -> Option<Intrinsics> {
    let mean = |parameter: &Parameter| match &parameter.statistics {
        Some(statistics) => Some(statistics.mean),
        None => {
            Some(Sorted::new(parameter.samples.iter().filter_map(|s| s.value).collect())?.mean())
        }
    };
    let params: Vec<f64> = parameters.iter().map(mean).collect::<Option<_>>()?;
    // What else is wrong with a camera was said when it was read: a mean can only overflow.
    model.with_params(&params).ok()
}

/// How strongly each parameter moves the pixels of a grid.
struct Effects {
    /// Cells that have a ray.
    seen_count: usize,
    /// Sum over them of |d pixel / d parameter|^2, for each parameter.
    squares: Vec<f64>,
}

struct EffectsOver(Grid);

impl Job for EffectsOver {
    type Output = Effects;

    fn run<M: CameraModel<N>, const N: usize>(self, params: &[f64; N]) -> Effects {
        let mut seen_count = 0;
        let mut squares = vec![0.0; N];
        let rays = self.0.pixels().filter_map(|pixel| M::unproject(params, &pixel));
        for seen in rays.filter_map(|ray| M::linearize(params, &ray)) {
            seen_count += 1;
            for (sum, column) in squares.iter_mut().zip(seen.wrt_params.column_iter()) {
                *sum += column.norm_squared();
            }
        }
        Effects { seen_count, squares }
    }
}
