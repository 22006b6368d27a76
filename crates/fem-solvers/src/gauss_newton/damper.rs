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
        let diagonal = model.diagonal();
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
