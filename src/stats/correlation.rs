//! Correlation of two parameters.

/// Pearson's correlation; none with fewer than three pairs, or when one side does not vary.
///
/// Two pairs always correlate perfectly, which says nothing. The order of the pairs changes no bit.
pub fn pearson(pairs: &[[f64; 2]]) -> Option<f64> {
    if pairs.len() < 3 {
        return None;
    }
    let mut pairs = pairs.to_vec();
    pairs.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let n = pairs.len() as f64;
    let middle = pairs[pairs.len() / 2];
    let mean = |side: usize| {
        middle[side] + pairs.iter().map(|pair| (pair[side] - middle[side]) / n).sum::<f64>()
    };
    let means = [mean(0), mean(1)];
    let widest =
        |side: usize| pairs.iter().map(|pair| (pair[side] - means[side]).abs()).fold(0.0, f64::max);
    let units = [widest(0), widest(1)];
    let moment = |a: usize, b: usize| -> f64 {
        let in_units = |pair: &[f64; 2], side: usize| (pair[side] - means[side]) / units[side];
        pairs.iter().map(|pair| in_units(pair, a) * in_units(pair, b)).sum()
    };
    if units[0] <= 0.0 || units[1] <= 0.0 {
        return None;
    }
    Some((moment(0, 1) / (moment(0, 0) * moment(1, 1)).sqrt()).clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_of_the_thesis_correlate_as_numpy_says() {
        // numpy.corrcoef: -0.96977854...
        let rows = [
            [421.001, -0.0709],
            [411.932, -0.0615],
            [419.312, -0.0678],
            [430.513, -0.0729],
            [440.073, -0.0814],
            [428.747, -0.0756],
        ];
        let found = pearson(&rows).unwrap();
        assert!((found + 0.9698).abs() < 5e-5, "{found}");
        let mut turned = rows;
        turned.reverse();
        assert_eq!(pearson(&turned).map(f64::to_bits), Some(found.to_bits()));
    }

    #[test]
    fn a_line_correlates_fully_and_a_constant_not_at_all() {
        let line: Vec<[f64; 2]> =
            (0..5_i32).map(|i| [f64::from(i), 3.0 - 2.0 * f64::from(i)]).collect();
        assert!((pearson(&line).unwrap() + 1.0).abs() < 1e-15);
        assert_eq!(pearson(&[[1.0, 2.0], [1.0, 3.0], [1.0, 4.0]]), None);
        assert_eq!(pearson(&line[..2]), None);
    }
}
