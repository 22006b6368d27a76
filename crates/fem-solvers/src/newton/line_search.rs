//! Backtracking that still works when energy differences drown in rounding.

use super::line_minimum::improve;
use super::{LineSearchParams, Merit, NonlinearProblem};
use crate::vector::{dot, first_non_finite, norm};

/// The state from which a search starts.
pub(super) struct Start<'a> {
    pub x: &'a [f64],
    pub direction: &'a [f64],
    pub gradient: &'a [f64],
    pub energy: f64,
    /// Largest absolute energy of the last steps, older ones counted for less.
    pub energy_scale: f64,
}

/// An accepted step.
pub(super) struct Accepted {
    pub t: f64,
    pub energy: f64,
    pub evaluations: usize,
    /// The merit fell by more than rounding.
    pub clear: bool,
}

/// Finds `t` so that `x + t·direction` is acceptable; `trial` and `gradient` are left there.
///
/// `None` when no share of the direction is.
pub(super) fn search<const D: usize>(
    problem: &(impl NonlinearProblem<D> + ?Sized),
    start: &Start<'_>,
    params: &LineSearchParams,
    trial: &mut [f64],
    gradient: &mut [f64],
) -> Option<Accepted> {
    let slope = dot(start.gradient, start.direction);
    let norm0 = norm(start.gradient);
    let cap = problem.largest_step(start.x, start.direction);
    // No step at all stays inside; NaN says no more.
    if !(cap > 0.0) {
        return None;
    }
    let mut t = cap.min(1.0);
    for backtracks in 0..=params.max_backtracks {
        for ((trial, x), d) in trial.iter_mut().zip(start.x).zip(start.direction) {
            *trial = x + t * d;
        }
        let at = Trial {
            t,
            longest: backtracks == 0,
            slope,
            norm0,
            x: trial,
        };
        let verdict = match problem.merit() {
            Merit::Energy => by_energy(problem, start, params, &at, gradient),
            Merit::ResidualNorm => by_norm(problem, params, &at, gradient),
        };
        match verdict {
            Verdict::Good { energy, clear } => {
                let mut accepted = Accepted {
                    t,
                    energy,
                    evaluations: backtracks + 1,
                    clear,
                };
                if clear && problem.merit() == Merit::Energy {
                    improve(problem, start, cap, trial, gradient, &mut accepted);
                }
                return Some(accepted);
            }
            Verdict::Shorten { t: next } => t = next,
        }
    }
    None
}

/// The whole step where no share of it was found good: an energy that is a small difference of large
/// sums says nothing about steps that change it by less than `rounding`, and the gradient decides
/// alone. It must halve.
pub(super) fn by_gradient<const D: usize>(
    problem: &(impl NonlinearProblem<D> + ?Sized),
    start: &Start<'_>,
    rounding: f64,
    trial: &mut [f64],
    gradient: &mut [f64],
) -> Option<Accepted> {
    let t = problem.largest_step(start.x, start.direction).min(1.0);
    for ((trial, x), d) in trial.iter_mut().zip(start.x).zip(start.direction) {
        *trial = x + t * d;
    }
    let energy = problem.energy_and_gradient(trial, gradient);
    let halves = norm(gradient) <= 0.5 * norm(start.gradient);
    (t > 0.0 && energy - start.energy <= rounding && halves).then_some(Accepted {
        t,
        energy,
        evaluations: 1,
        clear: false,
    })
}

/// A point on the search line.
struct Trial<'a> {
    t: f64,
    /// Is no longer step to be tried?
    longest: bool,
    /// `gᵀd` and `‖g‖` at the start of the line.
    slope: f64,
    norm0: f64,
    x: &'a [f64],
}

enum Verdict {
    Good { energy: f64, clear: bool },
    Shorten { t: f64 },
}

/// Armijo's test, or progress of the gradient where energies are too close to tell.
fn by_energy<const D: usize>(
    problem: &(impl NonlinearProblem<D> + ?Sized),
    start: &Start<'_>,
    params: &LineSearchParams,
    at: &Trial<'_>,
    gradient: &mut [f64],
) -> Verdict {
    let &Trial { t, slope, x, .. } = at;
    let energy = problem.energy(x);
    let change = energy - start.energy;
    let rounding = params.rounding * start.energy_scale.max(energy.abs());
    let decreases = change <= params.sufficient_decrease * t * slope;
    let clear = decreases && -change > rounding;
    // Too close to tell by energies: the slope must shrink instead (Hager & Zhang 2005). Outside the
    // domain the change is infinite, and so is its rounding.
    if energy.is_finite() && (clear || change.abs() <= rounding) {
        problem.gradient(x, gradient);
        let finite = first_non_finite(gradient).is_none();
        if finite && (clear || at.settles(gradient, start.direction, decreases)) {
            return Verdict::Good { energy, clear };
        }
    }
    // Minimizer of the parabola through both energies, kept within [t/10, t/2].
    let parabola = -0.5 * slope * t * t / (change - slope * t);
    let t = if parabola.is_finite() {
        parabola.clamp(0.1 * t, 0.5 * t)
    } else {
        0.5 * t
    };
    Verdict::Shorten { t }
}

/// The norm of the residual must fall by its share.
fn by_norm<const D: usize>(
    problem: &(impl NonlinearProblem<D> + ?Sized),
    params: &LineSearchParams,
    at: &Trial<'_>,
    gradient: &mut [f64],
) -> Verdict {
    let energy = problem.energy_and_gradient(at.x, gradient);
    let reduced = norm(gradient) <= (1.0 - params.sufficient_decrease * at.t) * at.norm0;
    if energy < f64::INFINITY && reduced && first_non_finite(gradient).is_none() {
        Verdict::Good {
            energy,
            clear: true,
        }
    } else {
        Verdict::Shorten { t: 0.5 * at.t }
    }
}

impl Trial<'_> {
    /// Whether the gradient at the trial point shows progress where energies cannot.
    fn settles(&self, gradient: &[f64], direction: &[f64], decreases: bool) -> bool {
        let slope = dot(gradient, direction);
        let norm = norm(gradient);
        // Steeper downhill at the end of the whole step: off a saddle the energy falls, however little,
        // while neither slope nor gradient gets smaller.
        (self.longest && slope <= self.slope)
            || norm < 0.9 * self.norm0
            || slope.abs() <= 0.5 * self.slope.abs()
            || (decreases && norm <= self.norm0)
    }
}
