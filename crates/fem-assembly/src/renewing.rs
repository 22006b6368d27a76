//! Newton's method while stencils change.

use crate::assembly::Assembly;
use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::quasistatic::Quasistatic;
use fem_materials::HessianProjection;
use fem_solvers::{
    BlockPattern, BlockSymmetric, Merit, NearKernel, Newton, NewtonError, NewtonInfo,
    NewtonIteration, NewtonParams, NonlinearProblem,
};
use std::cell::{Cell, RefCell};
use std::sync::Arc;

/// How much of the way that the stencils cover is gone.
const SAFE: f64 = 0.95;
/// A step of which what is covered is so many times longer is one of the last.
const NEAR_THE_END: f64 = 10.0;
/// Looks before the last steps of a solve's first part.
const EARLY_LOOKS: usize = 2;
/// Looks at which stencils without a reason leave; from then on they stay, so that energies fall.
const MOST_LOOKS: usize = 20;
/// Rounds at one converged state: two sets of stencils that call for each other must end.
const MOST_ROUNDS: usize = 20;

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
        source: Box<NewtonError>,
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

/// A problem whose stencils are looked for along every step that they do not cover.
struct Renewing<'a, const D: usize> {
    assembly: RefCell<&'a mut Assembly<D>>,
    positions: Vec<[f64; D]>,
    controls: &'a [f64],
    renewals: Cell<usize>,
    analyses: Cell<usize>,
    looks: Cell<usize>,
    /// Was the last step one of the last?
    ends: Cell<bool>,
    /// Looks before the last steps that are left.
    early: Cell<usize>,
    failed: RefCell<Option<AssemblyError>>,
}

/// Solves for equilibrium as [`Newton::solve`] does and renews the stencils of the assembly
/// ([`Assembly::renew`]) at the start, before each step that would leave what they cover
/// ([`Assembly::renew_along`]), and at the end, until none is missing. `newton` is made ready for
/// another pattern when there is one, and keeps its analysis as long as there is none.
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
    renew(assembly, newton, controls, &mut done, Assembly::renew)?;
    loop {
        params.max_iterations = most.saturating_sub(done.iterations);
        part(assembly, newton, controls, &mut params, &mut done)?;
        let look = Assembly::renew_at_equilibrium;
        if !renew(assembly, newton, controls, &mut done, look)? {
            return Ok(done);
        }
        rounds += 1;
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
    look: impl Fn(&mut Assembly<D>, Configuration<D>) -> Result<bool, AssemblyError>,
) -> Result<bool, RenewingError<D>> {
    // A borrow of the configuration must not hold the assembly.
    let positions = std::mem::take(&mut done.positions);
    let at = assembly.configuration(&positions, controls)?;
    let changed = look(assembly, at)?;
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

/// Solves until convergence.
fn part<const D: usize>(
    assembly: &mut Assembly<D>,
    newton: &mut Newton<'_, D>,
    controls: &[f64],
    params: &mut NewtonParams,
    done: &mut RenewedSolution<D>,
) -> Result<(), RenewingError<D>> {
    assembly.configuration(&done.positions, controls)?;
    let mut x = assembly.dofs().trusted_gather(&done.positions);
    let measured = assembly.force_scales().is_some();
    let problem = Renewing {
        assembly: RefCell::new(assembly),
        positions: done.positions.clone(),
        controls,
        renewals: Cell::new(0),
        analyses: Cell::new(0),
        looks: Cell::new(0),
        ends: Cell::new(false),
        // Two sets of stencils that call for each other are met by the rounds.
        early: Cell::new(if done.info.is_none() { EARLY_LOOKS } else { 0 }),
        failed: RefCell::new(None),
    };
    let mut first = None;
    let solved = newton.solve_observed(&problem, &mut x, params, &mut |step: &NewtonIteration| {
        first.get_or_insert(step.gradient_norm);
    });
    done.positions = problem.asked(|p| p.trusted_positions(&x));
    done.renewals += problem.renewals.get();
    done.analyses += problem.analyses.get();
    // What the first part measured its gradient against holds for all.
    if params.reference.is_none() && !measured {
        params.reference = first;
    }
    match solved {
        Ok(info) => {
            done.iterations += info.iterations;
            done.factorizations += info.factorizations;
            done.linear_iterations += info.linear_iterations;
            done.info = Some(info);
            Ok(())
        }
        Err(mut error) => {
            if let Some(failed) = problem.failed.take() {
                return Err(failed.into());
            }
            error.iteration += done.iterations;
            error.factorizations += done.factorizations;
            error.linear_iterations += done.linear_iterations;
            Err(RenewingError::Newton {
                source: Box::new(error),
                last: std::mem::take(&mut done.positions),
            })
        }
    }
}

impl<const D: usize> Renewing<'_, D> {
    /// What the problem of the present stencils says.
    fn asked<R>(&self, question: impl FnOnce(&Quasistatic<'_, D>) -> R) -> R {
        let assembly = self.assembly.borrow();
        let positions = self.positions.as_slice();
        question(&Quasistatic::trusted(&assembly, positions, self.controls))
    }

    /// Looks for stencils at the start of a step, and along it where they do not reach; true when they
    /// changed.
    fn looks(&self, x: &[f64], dx: &[f64], along: bool) -> Result<bool, AssemblyError> {
        let positions = self.asked(|p| p.trusted_positions(x));
        let mut displacement = vec![[0.0; D]; positions.len()];
        let mut assembly = self.assembly.borrow_mut();
        assembly.dofs().trusted_scatter(dx, &mut displacement);
        let before = assembly.pattern().clone();
        let at = Configuration::trusted(&positions, self.controls);
        let looks = self.looks.get();
        let settles = looks < MOST_LOOKS;
        self.looks.set(looks + usize::from(settles));
        let changed = match (settles, along) {
            (true, true) => assembly.renew_for_step(at, &displacement)?,
            (true, false) => assembly.renew(at)?,
            (false, true) => assembly.renew_along(at, &displacement)?,
            (false, false) => false,
        };
        let analyses = usize::from(!Arc::ptr_eq(&before, assembly.pattern()));
        self.analyses.set(self.analyses.get() + analyses);
        self.renewals
            .set(self.renewals.get() + usize::from(changed));
        Ok(changed)
    }
}

impl<const D: usize> NonlinearProblem<D> for Renewing<'_, D> {
    fn blocks(&self) -> usize {
        self.asked(|p| p.blocks())
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        self.asked(|p| p.pattern())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        self.asked(|p| p.energy(x))
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        self.asked(|p| p.gradient(x, g));
    }
    fn energy_and_gradient(&self, x: &[f64], g: &mut [f64]) -> f64 {
        self.asked(|p| p.energy_and_gradient(x, g))
    }
    fn hessian(&self, x: &[f64], projection: HessianProjection, out: &mut BlockSymmetric<D>) {
        self.asked(|p| p.hessian(x, projection, out));
    }
    fn is_one_sided(&self) -> bool {
        self.asked(|p| p.is_one_sided())
    }
    fn one_sided_hessian(
        &self,
        x: &[f64],
        projection: HessianProjection,
        share: f64,
        out: &mut BlockSymmetric<D>,
    ) {
        self.asked(|p| p.one_sided_hessian(x, projection, share, out));
    }
    fn prepare(&self, x: &[f64], dx: &[f64]) -> bool {
        let covered = SAFE * self.asked(|p| p.covered_step(x, dx));
        let along = !(covered >= 1.0);
        // What the end will ask for is cheaper to have before the last steps than after them.
        let ends = (NEAR_THE_END..f64::INFINITY).contains(&covered);
        let early = ends && !self.ends.get() && self.early.get() > 0;
        self.ends.set(ends);
        if !(along || early) {
            return false;
        }
        if !along {
            self.early.set(self.early.get() - 1);
        }
        self.looks(x, dx, along).unwrap_or_else(|error| {
            // No step leads on from here: `largest_step` sees to it.
            self.failed.replace(Some(error));
            false
        })
    }
    fn merit(&self) -> Merit {
        self.asked(|p| p.merit())
    }
    fn gradient_scales(&self, x: &[f64]) -> Option<Vec<f64>> {
        self.asked(|p| p.gradient_scales(x))
    }
    fn largest_gradient_scales(&self) -> Option<Vec<f64>> {
        self.asked(|p| p.largest_gradient_scales())
    }
    fn gradient_rounding(&self, x: &[f64]) -> Option<Vec<f64>> {
        self.asked(|p| p.gradient_rounding(x))
    }
    fn undetermined(&self, x: &[f64]) -> Option<String> {
        self.asked(|p| p.undetermined(x))
    }
    fn near_kernel(&self, x: &[f64]) -> NearKernel {
        self.asked(|p| p.near_kernel(x))
    }
    fn coordinates(&self) -> Option<Vec<[f64; D]>> {
        self.asked(|p| p.coordinates())
    }
    fn largest_step(&self, x: &[f64], dx: &[f64]) -> f64 {
        if self.failed.borrow().is_some() {
            return 0.0;
        }
        self.asked(|p| p.largest_step(x, dx).min(SAFE * p.covered_step(x, dx)))
    }
}
