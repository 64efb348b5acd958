//! Sums of products of short vectors: what the passes over points are made of.
//!
//! Lengths are known when compiled, so that each becomes a few instructions on whole vectors. FUSED says that the processor
//! multiplies and adds in one instruction; without one, `mul_add` is a slow call. No closures here nor in the passes: they are
//! compiled for the least of processors, and not always inlined.

/// A row of a block of poses: six numbers, and two places more.
pub(super) type Wide = [f64; 8];

/// a b + sum
#[inline(always)]
pub(super) fn fused<const FUSED: bool>(a: f64, b: f64, sum: f64) -> f64 {
    if FUSED { a.mul_add(b, sum) } else { a * b + sum }
}

/// sum += scale values
#[inline(always)]
pub(super) fn add_scaled<const N: usize, const FUSED: bool>(
    sum: &mut [f64; N],
    scale: f64,
    values: &[f64; N],
) {
    for lane in 0..N {
        sum[lane] = fused::<FUSED>(scale, values[lane], sum[lane]);
    }
}

/// scale values
#[inline(always)]
pub(super) fn scaled<const N: usize>(scale: f64, values: &[f64; N]) -> [f64; N] {
    let mut product = *values;
    for value in &mut product {
        *value *= scale;
    }
    product
}

/// a . b
#[inline(always)]
pub(super) fn dot<const N: usize, const FUSED: bool>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = 0.0;
    for lane in 0..N {
        sum = fused::<FUSED>(a[lane], b[lane], sum);
    }
    sum
}

/// block += left right^T, for as many rows as the block has.
#[inline(always)]
pub(super) fn add_outers<const N: usize, const ROWS: usize, const FUSED: bool>(
    block: &mut [[f64; N]],
    left: [&[f64; ROWS]; 2],
    right: [&[f64; N]; 2],
) {
    let [a, b] = [*right[0], *right[1]];
    for (row, sums) in block.iter_mut().enumerate().take(ROWS) {
        let mut sum = *sums;
        add_scaled::<N, FUSED>(&mut sum, left[0][row], &a);
        add_scaled::<N, FUSED>(&mut sum, left[1][row], &b);
        *sums = sum;
    }
}

/// block -= left right^T, for as many rows as the block has.
#[inline(always)]
pub(super) fn take_outers<const N: usize, const ROWS: usize, const FUSED: bool>(
    block: &mut [[f64; N]],
    left: &[[f64; ROWS]; 3],
    right: &[[f64; N]; 3],
) {
    let [a, b, c] = *right;
    for (row, sums) in block.iter_mut().enumerate().take(ROWS) {
        let mut sum = *sums;
        add_scaled::<N, FUSED>(&mut sum, -left[0][row], &a);
        add_scaled::<N, FUSED>(&mut sum, -left[1][row], &b);
        add_scaled::<N, FUSED>(&mut sum, -left[2][row], &c);
        *sums = sum;
    }
}
