//! What one standard deviation of a parameter does in the image, so that unlike parameters compare.

use super::Parameter;
use crate::camera::{Grid, Intrinsics, Model};
use crate::stats::Sorted;

/// Fills in the std in px of every parameter that has statistics; gives the share of the image that it is over.
pub(super) fn fill_std_px(
    model: &Model,
    [width, height]: [u64; 2],
    parameters: &mut [Parameter],
) -> Option<f64> {
    let grid = Grid::new(width, height);
    let Effects { seen_count, squares } = Effects::over(&grid, &mean_camera(model, parameters)?);
    for (parameter, squares) in parameters.iter_mut().zip(squares) {
        let Some(statistics) = &mut parameter.statistics else { continue };
        let px_per_unit = (squares / seen_count as f64).sqrt();
        statistics.std_px = Some(px_per_unit * statistics.std).filter(|px| px.is_finite());
    }
    Some(seen_count as f64 / grid.cell_count() as f64)
}

/// Whether the lens of the mean camera folds inside the image; none where there is no mean camera, or no such image.
pub(super) fn folds(model: &Model, size: [u64; 2], parameters: &[Parameter]) -> Option<bool> {
    /// Every pixel of its border is looked at: a file may say what no sensor has.
    const MOST_PX: u64 = 1 << 17;
    let side = |side: u64| u32::try_from(side).ok().filter(|_| side <= MOST_PX);
    Some(mean_camera(model, parameters)?.folds_inside(side(size[0])?, side(size[1])?))
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

impl Effects {
    fn over(grid: &Grid, camera: &Intrinsics) -> Self {
        let mut seen_count = 0;
        let mut squares = vec![0.0; camera.params().len()];
        let rays = grid.pixels().filter_map(|pixel| camera.unproject(&pixel).ok());
        for seen in rays.filter_map(|ray| camera.linearize(&ray)) {
            seen_count += 1;
            for (sum, column) in squares.iter_mut().zip(seen.wrt_params.column_iter()) {
                *sum += column.norm_squared();
            }
        }
        Self { seen_count, squares }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::run;
    use super::super::{Analysis, FindingId, Options, Population, analyze};
    use crate::camera::{Grid, MODELS, Param, ParamClass};

    /// Images of 1280 x 960, one camera a run.
    fn analysis(model: &str, params: &[&[f64]]) -> Analysis {
        let runs = (1..).zip(params);
        let runs =
            runs.map(|(number, params)| run("g", &format!("run{number}"), &[(1, model, params)]));
        analyze(runs.collect(), vec![], Options::default()).unwrap()
    }

    fn of(model: &str, params: &[&[f64]]) -> Population {
        analysis(model, params).populations.remove(0)
    }

    /// The std of a parameter, and the same in px.
    fn std(population: &Population, name: &str) -> (f64, Option<f64>) {
        let found = population.parameters.iter().find(|parameter| parameter.name == name);
        let statistics = found.unwrap().statistics.as_ref().unwrap();
        (statistics.std, statistics.std_px)
    }

    fn assert_near(got: Option<f64>, want: f64) {
        let is_near = got.is_some_and(|got| (got - want).abs() <= 1e-12 * want);
        assert!(is_near, "{got:?}, expected {want}");
    }

    /// The RMS distance from `centre` of the centres of so many equal parts of 0 to `side`.
    fn rms_distance(centre: f64, side: f64, parts: f64) -> f64 {
        ((side / 2.0 - centre).powi(2) + side * side / 12.0 * (1.0 - 1.0 / (parts * parts))).sqrt()
    }

    #[test]
    fn a_principal_point_moves_every_pixel_by_its_own_std() {
        let mut count = 0;
        for model in MODELS {
            let camera = |shift: f64| -> Vec<f64> {
                let value = |param: &Param| match param.class {
                    ParamClass::Focal => 900.0 + shift,
                    ParamClass::PrincipalPoint => 500.0 + 3.0 * shift,
                    ParamClass::Extra | ParamClass::Metadata => 0.1 + 0.001 * shift,
                };
                model.params.iter().map(value).collect()
            };
            let population = of(model.name, &[camera(0.0).as_slice(), &camera(0.5), &camera(2.0)]);
            for param in model.params.iter().filter(|p| p.class == ParamClass::PrincipalPoint) {
                let (std, std_px) = std(&population, param.name);
                assert_near(std_px, std);
                count += 1;
            }
        }
        assert_eq!(count, 2 * 22, "all models but EQUIRECTANGULAR and BAL_STRICT have cx and cy");
    }

    #[test]
    fn a_focal_length_of_a_pinhole_moves_pixels_by_their_tangents() {
        let params: [&[f64]; 3] = [
            &[1000.0, 900.0, 600.0, 500.0],
            &[1010.0, 903.0, 610.0, 490.0],
            &[1002.0, 921.0, 605.0, 498.0],
        ];
        let population = of("PINHOLE", &params);
        assert_eq!(population.ray_share, Some(1.0));
        let (fx, fx_px) = std(&population, "fx");
        assert_near(fx_px, fx * rms_distance(605.0, 1280.0, 60.0) / 1004.0);
        let (fy, fy_px) = std(&population, "fy");
        assert_near(fy_px, fy * rms_distance(496.0, 960.0, 45.0) / 908.0);
    }

    #[test]
    fn the_mean_camera_is_the_mean_of_what_was_estimated() {
        // cx was held at 100 in the first two runs, cy in all
        let params: [&[f64]; 4] = [
            &[1000.0, 900.0, 100.0, 500.0],
            &[1010.0, 903.0, 100.0, 500.0],
            &[1002.0, 921.0, 700.0, 500.0],
            &[1004.0, 920.0, 710.0, 500.0],
        ];
        let population = of("PINHOLE", &params);
        let (fx, fx_px) = std(&population, "fx");
        assert_near(fx_px, fx * rms_distance(705.0, 1280.0, 60.0) / 1004.0);
        let (fy, fy_px) = std(&population, "fy");
        assert_near(fy_px, fy * rms_distance(500.0, 960.0, 45.0) / 911.0);
    }

    proptest! {
        #[test]
        fn twice_the_deviations_are_twice_the_std_in_px(
            f in 500.0..3000.0, k in -0.1..0.3, df in 0.1..50.0, dk in 1e-4..0.05,
        ) {
            let camera = |times: f64| [f + times * df, 640.0, 480.0, k + times * dk];
            let by = |times: f64| of("SIMPLE_RADIAL", &[&camera(-times), &camera(0.0), &camera(times)]);
            let (once, twice) = (by(1.0), by(2.0));
            for name in ["f", "k"] {
                let [once, twice] = [&once, &twice].map(|one| std(one, name).1.unwrap());
                prop_assert!((twice / once - 2.0).abs() < 1e-9, "{name}: {once} {twice}");
            }
        }
    }

    #[test]
    fn cells_beyond_the_fold_are_left_out_and_that_is_said() {
        let analysis = analysis(
            "SIMPLE_RADIAL",
            &[&[1011.0, 640.0, 480.0, -0.26], &[1013.0, 640.0, 480.0, -0.27]],
        );
        // r (1 + k r^2) is largest at r = 1 / sqrt(-3 k), where it is 2/3 r.
        let (f, k): (f64, f64) = (1012.0, -0.265);
        let fold = f * 2.0 / 3.0 / (-3.0 * k).sqrt();
        let grid = Grid::new(1280, 960);
        let is_inside =
            |pixel: &nalgebra::Vector2<f64>| (pixel.x - 640.0).hypot(pixel.y - 480.0) < fold;
        let inside = grid.pixels().filter(is_inside).count();
        assert!(inside < grid.cell_count(), "the lens does not fold inside the image");
        let share = inside as f64 / grid.cell_count() as f64;
        assert_near(analysis.populations[0].ray_share, share);
        let said = analysis.findings.iter().find(|finding| finding.id == FindingId::Fold).unwrap();
        let percent = format!("{:.2} % of it has no ray", 100.0 * (1.0 - share));
        assert!(said.text.contains(&percent), "{}", said.text);
    }

    #[test]
    fn a_mean_that_sees_nothing_has_no_std_in_px() {
        for (f, share) in [(1.0, Some(0.0)), (1.7e308, None)] {
            let population = of("SIMPLE_PINHOLE", &[&[-f, 600.0, 480.0], &[f, 610.0, 480.0]]);
            assert_eq!(population.ray_share, share);
            assert_eq!(std(&population, "cx").1, None);
        }
    }

    #[test]
    fn what_was_held_or_describes_the_image_has_no_std_in_px() {
        let held: [&[f64]; 2] = [&[1000.0, 640.0, 480.0], &[1001.0, 640.0, 480.0]];
        let described: [&[f64]; 2] = [&[1280.0, 960.0], &[1281.0, 960.0]];
        let without = |model, params: &[&[f64]]| {
            let parameters = of(model, params).parameters;
            parameters.iter().filter(|parameter| parameter.statistics.is_none()).count()
        };
        assert_eq!(without("SIMPLE_PINHOLE", &held), 2);
        assert_eq!(without("EQUIRECTANGULAR", &described), 2);
    }
}
