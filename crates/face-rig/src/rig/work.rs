//! What a rig has done: the counts of a report.

use fem_assembly::Evaluations;
use std::time::Duration;

/// What a rig has done so far, tries that failed included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Work {
    /// Equilibria looked for, part-way poses included.
    pub equilibria: usize,
    /// Newton steps.
    pub newton_steps: usize,
    /// Numeric factorizations.
    pub factorizations: usize,
    /// Conjugate gradient iterations, those of derivatives included.
    pub linear_iterations: usize,
    /// Right-hand sides that derivatives solved for: columns, or observed numbers.
    pub right_hand_sides: usize,
    /// Evaluations of the energy's terms.
    pub evaluations: Evaluations,
    /// Time in equilibria.
    #[serde(skip)]
    pub equilibrium_time: Duration,
    /// Time in derivatives.
    #[serde(skip)]
    pub jacobian_time: Duration,
}

impl std::ops::Sub for Work {
    type Output = Self;
    /// What was done after `earlier`.
    fn sub(self, earlier: Self) -> Self {
        let time = Duration::saturating_sub;
        Self {
            equilibria: self.equilibria.saturating_sub(earlier.equilibria),
            newton_steps: self.newton_steps.saturating_sub(earlier.newton_steps),
            factorizations: self.factorizations.saturating_sub(earlier.factorizations),
            linear_iterations: self
                .linear_iterations
                .saturating_sub(earlier.linear_iterations),
            right_hand_sides: self
                .right_hand_sides
                .saturating_sub(earlier.right_hand_sides),
            evaluations: self.evaluations - earlier.evaluations,
            equilibrium_time: time(self.equilibrium_time, earlier.equilibrium_time),
            jacobian_time: time(self.jacobian_time, earlier.jacobian_time),
        }
    }
}

impl Work {
    pub(super) fn add(
        &mut self,
        newton_steps: usize,
        factorizations: usize,
        linear_iterations: usize,
    ) {
        self.newton_steps += newton_steps;
        self.factorizations += factorizations;
        self.linear_iterations += linear_iterations;
    }
}
