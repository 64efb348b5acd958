//! What runs say together.

use super::*;

fn cell(cell: usize, px: f64) -> CellMean {
    let mean = Mean { count: 40, px: [px, 0.0], std_error_px: [0.1; 2], p: 0.5 };
    CellMean { cell, middle: [10.0, 20.0], mean }
}

fn run(cells: [usize; 2], means: &[CellMean]) -> ResidualsInRun {
    let ring = RingMean { radius_px: 20.0, mean: cell(0, 0.1).mean };
    let means = Means { cell_px: [50.0; 2], cells: means.to_vec(), rings: vec![ring] };
    ResidualsInRun {
        camera_id: 1,
        observations: 100,
        sigma_px: 0.5,
        statistic: 1.0,
        degrees: [10.0, 100.0],
        p: 0.5,
        effect_px: 0.1,
        cells,
        tails: None,
        means,
    }
}

#[test]
fn runs_with_the_most_common_cells_make_the_map() {
    let runs = [
        run([12, 9], &[cell(0, 0.4), cell(1, 0.2)]),
        run([6, 5], &[cell(0, 9.0)]),
        run([12, 9], &[cell(0, 0.2)]),
    ];
    let all: Vec<&ResidualsInRun> = runs.iter().collect();
    let map = map(&all, 0.0).unwrap();
    assert_eq!((map.n, map.columns, map.rows), (2, 12, 9));
    assert_eq!(map.cells.iter().map(|cell| cell.mean.count).collect::<Vec<_>>(), [80, 40]);
    assert!((map.cells[0].mean.px[0] - 0.3).abs() < 1e-15);
    assert_eq!((map.rings.len(), map.rings[0].mean.count), (1, 80));
    // Of equally common ones the coarser.
    assert_eq!(super::map(&all[..2], 0.0).unwrap().columns, 6);
}

#[test]
fn points_are_judged_by_most_runs_or_not_at_all() {
    let tails = |sigma_ratio| Tails {
        points: 9,
        robust_sigma_px: 0.5,
        sigma_ratio,
        beyond_share: 0.0,
        p: 0.1,
    };
    let mut runs = [run([6, 5], &[]), run([6, 5], &[]), run([6, 5], &[])];
    runs[0].tails = Some(tails(1.0));
    let found = |runs: &[ResidualsInRun]| tails_of(&runs.iter().collect::<Vec<_>>());
    assert_eq!(found(&runs), None);
    runs[1].tails = Some(tails(2.0));
    let of_two = found(&runs).unwrap();
    assert!(
        (of_two.sigma_ratio - 1.5).abs() < 1e-15 && (of_two.p - 0.2).abs() < 1e-15,
        "{of_two:?}"
    );
}
