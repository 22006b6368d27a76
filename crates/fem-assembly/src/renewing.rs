//! Newton's method while stencils change.

use crate::assembly::Assembly;
use crate::error::AssemblyError;
use crate::quasistatic::Quasistatic;
use fem_materials::HessianProjection;
use fem_solvers::{
    BlockPattern, BlockSymmetric, Merit, NearKernel, Newton, NewtonError, NewtonFailure,
    NewtonInfo, NewtonIteration, NewtonParams, NonlinearProblem,
};
use std::cell::Cell;
use std::sync::Arc;

/// The share of a Newton step below which stencils are looked for again instead of shortening it.
const SHORT: f64 = 0.3;
/// How much of the way that the stencils cover is gone.
const SAFE: f64 = 0.95;
/// Rounds at one converged state: two sets of stencils that call for each other must end.
const MOST_ROUNDS: usize = 8;

/// An equilibrium whose stencils hold everything that has an energy there.
#[derive(Clone, Debug, PartialEq)]
pub struct RenewedSolution<const D: usize> {
    /// All positions, meters.
    pub positions: Vec<[f64; D]>,
    /// The last part of the solve, from its last renewal on.
    pub info: Option<NewtonInfo>,
    /// Newton steps of all parts.
    pub iterations: usize,
    /// Numeric factorizations of all parts.
    pub factorizations: usize,
    /// Conjugate gradient iterations of all parts.
    pub linear_iterations: usize,
    /// How often stencils changed.
    pub renewals: usize,
    /// How often the solver had to be made again for a new pattern.
    pub analyses: usize,
}

/// Why there is no equilibrium.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum RenewingError<const D: usize> {
    /// Lists or stencils that make no sense.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// Newton's method failed.
    #[error("{source}")]
    Newton {
        /// Why.
        source: NewtonError,
        /// Where the best step led, meters.
        last: Vec<[f64; D]>,
    },
    /// Each equilibrium calls for other stencils than it was found with.
    #[error(
        "the stencils were still changing after {rounds} equilibria: a wider margin of what is near, or a softer contact, lets them settle; flesh that starts deep inside other flesh gets there by a walk from where they do not touch (`solve_walking`)"
    )]
    Unsettled {
        /// Equilibria found.
        rounds: usize,
        /// The last of them; some energy is missing there.
        last: Box<RenewedSolution<D>>,
    },
}

/// A problem that does not leave what its stencils cover.
struct Covered<'a, const D: usize> {
    problem: Quasistatic<'a, D>,
    start: &'a [f64],
    due: Cell<bool>,
}

/// Solves for equilibrium as [`Newton::solve`] does and renews the stencils of the assembly
/// ([`Assembly::renew`]) at the start, whenever a step would leave what they cover, and at the end,
/// until none is missing. `newton` is [renewed](Newton::renew) when the pattern changes.
///
/// `start` holds the prescribed nodes' places and a first guess for the free ones, meters. Without
/// terms that change their stencils this is `newton.solve` of a [`Quasistatic`] problem.
///
/// # Errors
/// As [`Quasistatic::new`], [`Assembly::renew`] and [`Newton::solve`], with the last state;
/// [`RenewingError::Unsettled`] where the stencils do not come to rest.
pub fn solve_renewing<const D: usize>(
    assembly: &mut Assembly<D>,
    newton: &mut Newton<'_, D>,
    start: Vec<[f64; D]>,
    controls: &[f64],
    params: &NewtonParams,
) -> Result<RenewedSolution<D>, RenewingError<D>> {
    let mut done = RenewedSolution {
        positions: start,
        info: None,
        iterations: 0,
        factorizations: 0,
        linear_iterations: 0,
        renewals: 0,
        analyses: 0,
    };
    let mut params = *params;
    let (most, mut rounds) = (params.max_iterations, 0);
    renew(assembly, newton, controls, &mut done)?;
    loop {
        params.max_iterations = most.saturating_sub(done.iterations);
        let converged = part(assembly, newton, controls, &mut params, &mut done)?;
        let changed = renew(assembly, newton, controls, &mut done)?;
        rounds += usize::from(converged);
        if converged && !changed {
            return Ok(done);
        }
        if rounds >= MOST_ROUNDS {
            let last = Box::new(done);
            return Err(RenewingError::Unsettled { rounds, last });
        }
    }
}

fn renew<const D: usize>(
    assembly: &mut Assembly<D>,
    newton: &mut Newton<'_, D>,
    controls: &[f64],
    done: &mut RenewedSolution<D>,
) -> Result<bool, RenewingError<D>> {
    // A borrow of the configuration must not hold the assembly.
    let positions = std::mem::take(&mut done.positions);
    let at = assembly.configuration(&positions, controls)?;
    let changed = assembly.renew(at)?;
    done.positions = positions;
    done.renewals += usize::from(changed);
    let analyzed = newton.matrix().map(BlockSymmetric::pattern);
    if !analyzed.is_some_and(|own| Arc::ptr_eq(own, assembly.pattern())) {
        let problem = Quasistatic::new(assembly, done.positions.clone(), controls.to_vec())?;
        newton.renew(&problem);
        done.analyses += 1;
    }
    Ok(changed)
}

/// Solves until convergence (true) or until stencils must be looked for (false).
fn part<const D: usize>(
    assembly: &Assembly<D>,
    newton: &mut Newton<'_, D>,
    controls: &[f64],
    params: &mut NewtonParams,
    done: &mut RenewedSolution<D>,
) -> Result<bool, RenewingError<D>> {
    let problem = Quasistatic::new(assembly, done.positions.clone(), controls.to_vec())?;
    let start = problem.unknowns();
    let mut x = start.clone();
    let covered = Covered {
        problem,
        start: &start,
        due: Cell::new(false),
    };
    let mut first = None;
    let solved = newton.solve_observed(&covered, &mut x, params, &mut |step: &NewtonIteration| {
        first.get_or_insert(step.gradient_norm);
    });
    done.positions = covered.problem.positions(&x);
    // What the first part measured its gradient against holds for all.
    if params.reference.is_none() && assembly.force_scales().is_none() {
        params.reference = first;
    }
    match solved {
        Ok(info) => {
            done.iterations += info.iterations;
            done.factorizations += info.factorizations;
            done.linear_iterations += info.linear_iterations;
            done.info = Some(info);
            Ok(true)
        }
        Err(mut error) => {
            done.iterations += error.iteration;
            done.factorizations += error.factorizations;
            done.linear_iterations += error.linear_iterations;
            let refused = matches!(error.reason, NewtonFailure::LineSearchFailed { .. });
            if refused && covered.due.get() {
                return Ok(false);
            }
            error.iteration = done.iterations;
            error.factorizations = done.factorizations;
            error.linear_iterations = done.linear_iterations;
            Err(RenewingError::Newton {
                source: error,
                last: std::mem::take(&mut done.positions),
            })
        }
    }
}

impl<const D: usize> NonlinearProblem<D> for Covered<'_, D> {
    fn blocks(&self) -> usize {
        self.problem.blocks()
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        self.problem.pattern()
    }
    /// No step is acceptable once stencils must be looked for: that ends the solve.
    fn energy(&self, x: &[f64]) -> f64 {
        if self.due.get() {
            f64::INFINITY
        } else {
            self.problem.energy(x)
        }
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        self.problem.gradient(x, g);
    }
    fn energy_and_gradient(&self, x: &[f64], g: &mut [f64]) -> f64 {
        let energy = self.problem.energy_and_gradient(x, g);
        if self.due.get() {
            f64::INFINITY
        } else {
            energy
        }
    }
    fn hessian(&self, x: &[f64], projection: HessianProjection, out: &mut BlockSymmetric<D>) {
        self.problem.hessian(x, projection, out);
    }
    fn merit(&self) -> Merit {
        self.problem.merit()
    }
    fn gradient_scales(&self, x: &[f64]) -> Option<Vec<f64>> {
        self.problem.gradient_scales(x)
    }
    fn gradient_rounding(&self, x: &[f64]) -> Option<Vec<f64>> {
        self.problem.gradient_rounding(x)
    }
    fn near_kernel(&self, x: &[f64]) -> NearKernel {
        self.problem.near_kernel(x)
    }
    fn coordinates(&self) -> Option<Vec<[f64; D]>> {
        self.problem.coordinates()
    }
    fn largest_step(&self, x: &[f64], dx: &[f64]) -> f64 {
        let own = self.problem.largest_step(x, dx);
        let covered = SAFE * self.problem.covered_step(x, dx);
        // The first step from fresh stencils is as long as it can be.
        if covered < SHORT && x != self.start {
            self.due.set(true);
        }
        own.min(covered)
    }
}
