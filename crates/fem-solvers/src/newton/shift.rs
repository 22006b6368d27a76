//! How much an indefinite Hessian is changed: the share of its own diagonal that is added (Levenberg
//! 1944), or of the way to its projected form.

/// The share, remembered from step to step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shift {
    share: f64,
    /// What the share was before the exact matrix was tried again.
    before: f64,
    /// How much of the negative curvature of parts that act on one side alone is left out.
    one_sided: f64,
    /// Steps for which that does not fall: what was just refused is not tried again at once.
    held: u8,
}

/// How shares follow success and failure.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShareRule {
    first: f64,
    growth: f64,
    decay: f64,
    most: f64,
}

impl ShareRule {
    /// Of the diagonal: the tenth share is 1e6 and more, nearly a gradient step.
    pub const DIAGONAL: Self = Self {
        first: 1e-2,
        growth: 10.0,
        decay: 0.2,
        most: f64::INFINITY,
    };
    /// Of the projection, where 1 is the whole of it.
    pub const PROJECTION: Self = Self {
        first: 0.1,
        growth: 3.0,
        decay: 0.4,
        most: 1.0,
    };
}

impl Shift {
    /// Shares tried in one step.
    pub const ATTEMPTS: usize = 10;
    const NEGLIGIBLE: f64 = 1e-4;
    /// A gradient that fell to this share after a full step: the end is near, where only the exact
    /// matrix converges fast.
    const CLOSE: f64 = 0.25;

    /// What to begin with far from a solution: no negative curvature of one-sided parts.
    pub const FAR: Self = Self {
        share: 0.0,
        before: 0.0,
        one_sided: 1.0,
        held: 0,
    };
    const HELD: u8 = 2;
    /// What the share of one-sided parts falls to after a full step, and grows by after a refusal.
    const ONE_SIDED_DECAY: f64 = 0.3;
    const ONE_SIDED_GROWTH: f64 = 10.0;
    /// Less than this is none, and the first after none.
    const ONE_SIDED_LEAST: f64 = 0.05;
    /// The exact matrix after a step that left so little of the gradient.
    const AT_ONCE: f64 = 0.05;

    /// How much of the negative curvature of one-sided parts is left out, 0 to 1.
    pub fn one_sided(self) -> f64 {
        self.one_sided
    }

    /// The matrix was not positive definite with what is left of one-sided parts; `false` when nothing
    /// negative of them was left.
    pub fn refused_one_sided(&mut self) -> bool {
        // Where the projection was needed a step ago, leaving these parts out was not enough.
        let all = self.one_sided >= 1.0 || self.before > 0.0;
        let more = Self::ONE_SIDED_GROWTH * self.one_sided;
        self.one_sided = more.clamp(2.0 * Self::ONE_SIDED_LEAST, 1.0);
        self.held = Self::HELD;
        !all
    }

    /// The share to try next; 0 for the matrix as it is.
    pub fn share(self) -> f64 {
        self.share
    }

    /// The matrix was not positive definite with it; `false` when there is no more to try.
    pub fn refused(&mut self, rule: ShareRule) -> bool {
        if self.share >= rule.most {
            return false;
        }
        let next = (rule.growth * self.share).max(std::mem::take(&mut self.before));
        self.share = next.max(rule.first).min(rule.most);
        true
    }

    /// A step with it was taken, of which the line search left the part `t` and which left the share
    /// `gradient` of the gradient.
    pub fn stepped(&mut self, rule: ShareRule, t: f64, gradient: f64) {
        self.before = 0.0;
        if self.held > 0 {
            self.held -= 1;
        } else if t >= 1.0 {
            self.one_sided *= Self::ONE_SIDED_DECAY;
        } else if t < 0.3 && self.one_sided > 0.0 {
            self.one_sided = (Self::ONE_SIDED_GROWTH * self.one_sided).min(1.0);
        }
        if self.one_sided < Self::ONE_SIDED_LEAST || (self.held == 0 && gradient <= Self::AT_ONCE) {
            self.one_sided = 0.0;
        }
        if t == 1.0 && gradient <= Self::CLOSE {
            self.before = rule.decay * std::mem::take(&mut self.share);
        } else if t >= 1.0 {
            self.share *= rule.decay;
        } else if t < 0.3 {
            self.share = (4.0 * self.share).min(rule.most);
        }
        if self.share < Self::NEGLIGIBLE {
            self.share = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ShareRule, Shift};

    /// 0.1, then three times as much to the whole; 0.4 of it after a full step, four times after a
    /// short one, nothing once it is next to nothing or the end is near.
    #[test]
    fn shares_follow_refusals_and_steps() {
        let rule = ShareRule::PROJECTION;
        let near = |shift: Shift, share: f64| (shift.share() - share).abs() < 1e-15;
        let mut shift = Shift::default();
        for share in [0.1, 0.3, 0.9, 1.0] {
            assert!(shift.refused(rule) && near(shift, share), "{shift:?}");
        }
        assert!(!shift.refused(rule));
        shift.stepped(rule, 1.0, 0.9);
        assert!(near(shift, 0.4), "{shift:?}");
        shift.stepped(rule, 0.5, 0.9);
        assert!(near(shift, 0.4), "{shift:?}");
        shift.stepped(rule, 0.1, 0.9);
        assert!(near(shift, 1.0), "{shift:?}");
        // The exact matrix is tried; where that is refused, what there was before.
        shift.stepped(rule, 1.0, 0.1);
        assert!(near(shift, 0.0), "{shift:?}");
        assert!(shift.refused(rule) && near(shift, 0.4), "{shift:?}");
        for _ in 0..10 {
            shift.stepped(rule, 1.0, 0.9);
        }
        assert_eq!(shift.share(), 0.0);
    }
}
