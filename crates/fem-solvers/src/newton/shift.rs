//! How much of its own diagonal an indefinite Hessian gets (Levenberg 1944).

/// The share, remembered from step to step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shift {
    share: f64,
}

impl Shift {
    /// Shares tried in one step; the last is 1e6 and more, nearly a gradient step.
    pub const ATTEMPTS: usize = 10;
    const FIRST: f64 = 1e-2;
    const NEGLIGIBLE: f64 = 1e-4;

    /// The share to try next; 0 for the matrix as it is.
    pub fn share(self) -> f64 {
        self.share
    }

    /// The matrix was not positive definite with it.
    pub fn refused(&mut self) {
        self.share = (10.0 * self.share).max(Self::FIRST);
    }

    /// A step with it was taken, of which the line search left the part `t`.
    pub fn stepped(&mut self, t: f64) {
        if t == 1.0 {
            self.share *= 0.2;
        } else if t < 0.3 {
            self.share *= 4.0;
        }
        if self.share < Self::NEGLIGIBLE {
            self.share = 0.0;
        }
    }
}
