//! Sparse factors against nalgebra's of the whole.

use super::*;
use nalgebra::{DMatrix, DVector};

/// A positive definite matrix of so many tiles, ill-conditioned enough to show faults; zero where two tiles are no neighbours.
fn example(graph: &Graph) -> DMatrix<f64> {
    let size = TILE * graph.nodes();
    let factor = DMatrix::from_fn(size, size, |row, column| {
        let entry = ((row * 7 + column * 13) as f64 * 0.37).sin();
        if row / TILE == column / TILE { entry } else { 0.0 }
    });
    let mut matrix = &factor * factor.transpose() + DMatrix::identity(size, size) * 1e-3;
    for one in 0..graph.nodes() {
        for other in graph.neighbours(one) {
            // Twice the same columns, so that the whole stays positive.
            let mut shared = DMatrix::zeros(size, 3);
            for tile in [one, other] {
                for at in 0..TILE {
                    let phase = (at * (1 + tile) + one + other) as f64;
                    (0..3).for_each(|c| {
                        shared[(TILE * tile + at, c)] = (phase * 0.7 + c as f64).sin()
                    });
                }
            }
            matrix += &shared * shared.transpose();
        }
    }
    matrix
}

fn filled(matrix: &DMatrix<f64>, graph: Graph) -> Tiles {
    let mut tiles = Tiles::new(Pattern::of(graph));
    for column in 0..matrix.ncols() {
        for row in column..matrix.nrows() {
            tiles.add_rows(row, column, std::iter::once([matrix[(row, column)]].as_slice()));
        }
    }
    tiles
}

fn path(tiles: usize) -> Graph {
    let mut graph = Graph::new(tiles);
    (1..tiles).for_each(|tile| graph.join(tile - 1, tile));
    graph
}

/// Eliminating the first fills the triangle of the others; the last is joined with all.
fn star_with_border() -> Graph {
    let mut graph = Graph::new(6);
    [2, 3, 4].iter().for_each(|&leaf| graph.join(0, leaf));
    (0..5).for_each(|tile| graph.join(tile, 5));
    graph
}

fn full(tiles: usize) -> Graph {
    let mut graph = Graph::new(tiles);
    (0..tiles).for_each(|one| (0..one).for_each(|other| graph.join(one, other)));
    graph
}

#[test]
fn systems_of_every_pattern_are_solved_with_the_same_bits_by_any_number_of_threads() {
    for graph in [full(1), full(3), path(4), star_with_border()] {
        let matrix = example(&graph);
        let wanted = DVector::from_fn(matrix.nrows(), |row, _| 1.0 + row as f64);
        let solved = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut tiles = filled(&matrix, graph.clone());
                assert_eq!(tiles.factor(0..graph.nodes(), None), Some(0));
                let mut found: Vec<f64> = (&matrix * &wanted).iter().copied().collect();
                tiles.solve(&mut found);
                found
            })
        };
        let found = solved(1);
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&found), bits(&solved(3)));
        let error = (DVector::from_vec(found) - &wanted).norm() / wanted.norm();
        assert!(error < 1e-9, "{}: {error:.1e}", graph.nodes());
    }
}

#[test]
fn only_tiles_that_fill_are_there() {
    let pattern = Pattern::of(star_with_border());
    let below: Vec<&[usize]> = pattern.rows.iter().map(|rows| &rows[1..]).collect();
    let wanted: [&[usize]; 6] = [&[2, 3, 4, 5], &[5], &[3, 4, 5], &[4, 5], &[5], &[]];
    assert_eq!(below, wanted);
    assert_eq!(pattern.bytes(), 17 * 48 * 48 * 8 + 21 * 4);
}

#[test]
fn what_is_left_is_the_schur_complement() {
    let matrix = example(&star_with_border());
    let mut tiles = filled(&matrix, star_with_border());
    assert_eq!(tiles.factor(0..4, Some(1e-14)), Some(0));
    let (first, size) = (4 * TILE, 6 * TILE);
    let corner = matrix.view_range(..first, ..first).into_owned().try_inverse().unwrap();
    let side = matrix.view_range(first.., ..first);
    let schur = matrix.view_range(first.., first..) - side * corner * side.transpose();
    for row in first..size {
        for column in first..=row {
            let (wanted, found) = (schur[(row - first, column - first)], tiles.entry(row, column));
            assert!((found - wanted).abs() < 1e-9 * schur.amax(), "{row} {column}");
        }
    }
}

#[test]
fn directions_that_are_not_determined_are_counted_and_left_where_they_are() {
    // Three rows of the last tile repeat others; the rest of it is apart.
    let whole = example(&full(2));
    let map = |index: usize| if index < 60 { index } else { index - 30 };
    let matrix = DMatrix::from_fn(2 * TILE, 2 * TILE, |row, column| {
        let entry = whole[(map(row), map(column))];
        if row.max(column) < 63 { entry } else { f64::from(row == column) }
    });
    let mut tiles = filled(&matrix, full(2));
    assert_eq!(tiles.factor(0..2, Some(1e-12)), Some(3));
    let right = &matrix * DVector::from_element(2 * TILE, 1.0);
    let mut found: Vec<f64> = right.iter().copied().collect();
    tiles.solve(&mut found);
    assert!(found[60..63].iter().all(|value| value.abs() < 1e-300));
    let error = (&matrix * DVector::from_vec(found) - &right).norm() / right.norm();
    assert!(error < 1e-9, "{error:.1e}");
}
