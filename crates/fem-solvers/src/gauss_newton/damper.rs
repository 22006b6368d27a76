//! How the damping follows success and failure.

use super::Damping;
use super::linear_step::Model;

/// What is left of a damping that made a step too short to tell anything.
const EASE: f64 = 1e-3;

/// The damping parameter, updated after Nielsen (1999).
pub(super) struct Damper {
    kind: Damping,
    pub lambda: f64,
    growth: f64,
    started: bool,
    /// The damping of the last step that could not be evaluated.
    pub failed_at: Option<f64>,
}

impl Damper {
    pub fn new(kind: Damping) -> Self {
        Self {
            kind,
            lambda: 0.0,
            growth: 2.0,
            started: false,
            failed_at: None,
        }
    }

    /// Is a step of this damping short because less damped ones could not be evaluated?
    pub fn cuts_short(&self, lambda: f64) -> bool {
        self.failed_at.is_some_and(|failed| lambda > failed)
    }

    /// What is added to the diagonal of the Gauss-Newton matrix.
    pub fn vector(&mut self, model: &Model<'_>) -> Option<Vec<f64>> {
        let diagonal = &model.diagonal;
        let largest = diagonal.iter().fold(0.0_f64, |a, &b| a.max(b));
        let (initial, marquardt) = match self.kind {
            Damping::None => return None,
            Damping::Levenberg { initial } => {
                (initial * if largest > 0.0 { largest } else { 1.0 }, None)
            }
            Damping::Marquardt { initial } => (
                initial,
                Some(1e-12 * if largest > 0.0 { largest } else { 1.0 }),
            ),
        };
        if !self.started {
            self.lambda = initial;
            self.started = true;
        }
        Some(match marquardt {
            None => vec![self.lambda; model.n],
            Some(floor) => diagonal
                .iter()
                .map(|d| self.lambda * d.max(floor))
                .collect(),
        })
    }

    pub fn accept(&mut self, ratio: f64) {
        if !self.cuts_short(self.lambda) {
            self.failed_at = None;
        }
        let factor = 1.0 - (2.0 * ratio - 1.0).powi(3);
        self.lambda = (self.lambda * factor.clamp(1.0 / 3.0, 2.0)).max(1e-15);
        self.growth = 2.0;
    }

    pub fn reject(&mut self) {
        self.lambda *= self.growth;
        self.growth *= 2.0;
    }
    /// A step that was short because it was damped says nothing: the next one is damped much less.
    pub fn ease(&mut self) {
        self.lambda = (EASE * self.lambda).max(1e-15);
    }
}

#[cfg(test)]
mod tests {
    use super::{Damper, Damping, Model};

    /// Two columns, of which the second is zero.
    fn model(j: &[f64; 4]) -> Model<'_> {
        Model::new(2, &[1.0, 1.0], j, None)
    }

    #[test]
    fn a_parameter_without_any_effect_is_damped_all_the_same() {
        let j = [2.0, 0.0, 0.0, 0.0];
        let mut relative = Damper::new(Damping::Marquardt { initial: 0.5 });
        let added = relative.vector(&model(&j));
        assert_eq!(added, Some(vec![0.5 * 4.0, 0.5 * 1e-12 * 4.0]));
        let mut absolute = Damper::new(Damping::Levenberg { initial: 0.5 });
        assert_eq!(absolute.vector(&model(&j)), Some(vec![2.0; 2]));
        // Nothing has an effect: the unit is 1.
        let mut relative = Damper::new(Damping::Marquardt { initial: 0.5 });
        let added = relative.vector(&model(&[0.0; 4]));
        assert_eq!(added, Some(vec![0.5e-12; 2]));
        let mut absolute = Damper::new(Damping::Levenberg { initial: 0.5 });
        assert_eq!(absolute.vector(&model(&[0.0; 4])), Some(vec![0.5; 2]));
    }

    #[test]
    fn what_says_nothing_is_damped_a_thousandth_and_never_by_nothing() {
        let mut damper = Damper::new(Damping::Marquardt { initial: 8.0 });
        damper.vector(&model(&[1.0; 4]));
        damper.ease();
        assert!((damper.lambda - 8e-3).abs() < 1e-18);
        (0..9).for_each(|_| damper.ease());
        assert_eq!(damper.lambda, 1e-15);
    }

    /// A step damped more than one that failed may be short for that alone; one damped less is not.
    #[test]
    fn where_a_trial_failed_is_forgotten_once_less_damping_succeeds() {
        let mut damper = Damper::new(Damping::Marquardt { initial: 2.0 });
        damper.vector(&model(&[1.0; 4]));
        damper.failed_at = Some(1.0);
        damper.accept(1.0);
        assert!(damper.cuts_short(5.0) && !damper.cuts_short(0.5));
        assert!(damper.lambda < 1.0, "{}", damper.lambda);
        damper.accept(1.0);
        assert!(!damper.cuts_short(5.0));
    }
    /// λ max(1/3, min(2, 1 − (2 ρ − 1)³)) after a gain of ρ times the predicted one, and 2, 4, 8 times as much
    /// after failures in a row (Nielsen 1999).
    #[test]
    fn damping_follows_gains_and_failures_by_its_closed_form() {
        let mut damper = Damper::new(Damping::Marquardt { initial: 1.0 });
        damper.vector(&model(&[1.0; 4]));
        let mut expected = 1.0;
        for (ratio, factor) in [
            (1.0, 1.0 / 3.0),
            (0.5, 1.0),
            (0.25, 1.125),
            (0.75, 0.875),
            (0.0, 2.0),
            (-1.0, 2.0),
        ] {
            for growth in [2.0, 4.0, 8.0] {
                damper.reject();
                expected *= growth;
                assert_eq!(damper.lambda, expected);
            }
            damper.accept(ratio);
            expected *= factor;
            assert!((damper.lambda / expected - 1.0).abs() < 1e-14, "{ratio}");
            expected = damper.lambda;
        }
        damper.lambda = 2e-15;
        damper.accept(1.0);
        assert_eq!(damper.lambda, 1e-15);
    }
}
