//! Robust losses of a group of residuals.

/// `ρ(s)` of the squared norm `s = ‖r_g‖²` of a group; the cost is `½ Σ ρ(s)`.
///
/// `scale` is the norm, in the unit of the residuals, from which a group counts as an outlier.
/// Formulas as in Triggs et al. (2000), with `ρ(s) → s` for small `s`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Loss {
    /// `ρ = s`: ordinary least squares.
    Square,
    /// `ρ = s` up to `δ²`, `2 δ √s − δ²` beyond: outliers pull with constant force.
    Huber {
        /// `δ`.
        scale: f64,
    },
    /// `ρ = δ² ln(1 + s/δ²)`.
    Cauchy {
        /// `δ`.
        scale: f64,
    },
    /// `ρ = s / (1 + s/δ²)`: outliers hardly pull at all.
    GemanMcClure {
        /// `δ`.
        scale: f64,
    },
}

impl Loss {
    /// `ρ(s)`.
    pub fn value(self, s: f64) -> f64 {
        match self {
            Loss::Square => s,
            Loss::Huber { scale } if s <= scale * scale => s,
            Loss::Huber { scale } => scale * (2.0 * s.sqrt() - scale),
            Loss::Cauchy { scale } => scale * scale * (s / (scale * scale)).ln_1p(),
            Loss::GemanMcClure { scale } => s / (1.0 + s / (scale * scale)),
        }
    }

    /// `ρ'(s)`: the weight of a group in iteratively reweighted least squares.
    pub fn weight(self, s: f64) -> f64 {
        match self {
            Loss::Square => 1.0,
            Loss::Huber { scale } if s <= scale * scale => 1.0,
            Loss::Huber { scale } => scale / s.sqrt(),
            Loss::Cauchy { scale } => 1.0 / (1.0 + s / (scale * scale)),
            Loss::GemanMcClure { scale } => (1.0 + s / (scale * scale)).powi(-2),
        }
    }

    pub(super) fn scale(self) -> Option<f64> {
        match self {
            Loss::Square => None,
            Loss::Huber { scale } | Loss::Cauchy { scale } | Loss::GemanMcClure { scale } => {
                Some(scale)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Loss;

    #[test]
    fn losses_are_their_closed_forms_and_weights_their_slopes() {
        let scale = 3.0;
        // Of residuals 1 and 6.
        for (loss, near, far) in [
            (Loss::Square, 1.0, 36.0),
            (Loss::Huber { scale }, 1.0, 2.0 * 3.0 * 6.0 - 9.0),
            (
                Loss::Cauchy { scale },
                9.0 * (10.0_f64 / 9.0).ln(),
                9.0 * 5.0_f64.ln(),
            ),
            (Loss::GemanMcClure { scale }, 0.9, 36.0 / 5.0),
        ] {
            for (s, value) in [(1.0, near), (36.0, far)] {
                assert!((loss.value(s) - value).abs() < 1e-14, "{loss:?} {s}");
                let h = 1e-5 * s;
                let slope = (loss.value(s + h) - loss.value(s - h)) / (2.0 * h);
                assert!((loss.weight(s) - slope).abs() < 1e-9, "{loss:?} {s}");
            }
        }
    }
}
