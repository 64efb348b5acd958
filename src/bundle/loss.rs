//! Robust losses: what a residual costs, and how that reweighs it.
//!
//! rho(s) of s = |r|^2, as Ceres has them; Triggs et al., Bundle Adjustment - A Modern Synthesis, 1999, section 4.3.

/// What a residual of s = |r|^2 costs: 1/2 rho(s). The scale is in px.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Loss {
    /// s
    #[default]
    Squared,
    /// s to the scale's square, beyond it linear in |r|.
    Huber(f64),
    /// 2 c^2 (sqrt(1 + s / c^2) - 1)
    SoftL1(f64),
    /// c^2 log(1 + s / c^2)
    Cauchy(f64),
}

/// rho and its first two derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rho {
    pub value: f64,
    pub slope: f64,
    pub curvature: f64,
}

impl Loss {
    /// Whether a residual can be so large that its cost curves down.
    pub(super) fn bends_down(self) -> bool {
        matches!(self, Self::Cauchy(_))
    }

    /// rho at s.
    #[inline]
    pub(super) fn at(self, s: f64) -> Rho {
        match self {
            Self::Huber(scale) if s > scale * scale => {
                let slope = scale / s.sqrt();
                Rho {
                    value: 2.0 * scale * s.sqrt() - scale * scale,
                    slope,
                    curvature: -0.5 * slope / s,
                }
            }
            Self::Squared | Self::Huber(_) => Rho { value: s, slope: 1.0, curvature: 0.0 },
            Self::SoftL1(scale) => {
                let square = scale * scale;
                let root = (1.0 + s / square).sqrt();
                Rho {
                    // 2 c^2 (root - 1), without the cancellation.
                    value: 2.0 * s / (root + 1.0),
                    slope: 1.0 / root,
                    curvature: -0.5 / (square * root * root * root),
                }
            }
            Self::Cauchy(scale) => {
                let square = scale * scale;
                let slope = 1.0 / (1.0 + s / square);
                Rho {
                    value: square * (s / square).ln_1p(),
                    slope,
                    curvature: -slope * slope / square,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_loss() {
        let mut checked = 0;
        for loss in [Loss::Squared, Loss::Huber(1.5), Loss::SoftL1(0.7), Loss::Cauchy(2.0)] {
            for s in [0.01, 0.4, 1.0, 2.3, 17.0, 900.0] {
                let (step, rho) = (1e-4 * s, loss.at(s));
                let slope = (loss.at(s + step).value - loss.at(s - step).value) / (2.0 * step);
                let curvature = (loss.at(s + step).slope - loss.at(s - step).slope) / (2.0 * step);
                assert!((rho.slope - slope).abs() < 1e-7, "{loss:?} at {s}");
                assert!(
                    (rho.curvature - curvature).abs() < 1e-7 * (1.0 + 1.0 / s),
                    "{loss:?} at {s}"
                );
                checked += 1;
            }
        }
        assert_eq!(checked, 24);
    }

    #[test]
    fn small_residuals_cost_their_square_and_large_ones_less() {
        for loss in [Loss::Huber(1.0), Loss::SoftL1(1.0), Loss::Cauchy(1.0)] {
            assert!((loss.at(1e-6).value - 1e-6).abs() < 1e-11, "{loss:?}");
            assert!(loss.at(100.0).value < 21.0, "{loss:?}");
        }
    }
}
