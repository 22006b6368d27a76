//! How exactly the direction of a step is solved for.

/// Eisenstat & Walker (1996), choice 2 with its safeguard: `η = 0.9 (‖g‖/‖g₋₁‖)²`.
#[derive(Default)]
pub(super) struct Forcing {
    previous: Option<(f64, f64)>,
}

impl Forcing {
    pub const FIRST: f64 = 0.1;
    const LARGEST: f64 = 0.3;
    const SMALLEST: f64 = 1e-12;

    /// `remaining` is the reduction that still separates the gradient from its target.
    pub fn next(&mut self, gradient: f64, remaining: f64) -> f64 {
        let eta = match self.previous {
            None => Self::FIRST,
            Some((before, eta)) => {
                let quadratic = 0.9 * (gradient / before).powi(2);
                let safeguard = 0.9 * eta * eta;
                if safeguard > 0.1 {
                    quadratic.max(safeguard)
                } else {
                    quadratic
                }
            }
        };
        // No more accuracy than the last step needs.
        let eta = eta
            .min(Self::LARGEST)
            .max(0.1 * remaining.min(1.0))
            .max(Self::SMALLEST);
        self.previous = Some((gradient, eta));
        eta
    }
}
