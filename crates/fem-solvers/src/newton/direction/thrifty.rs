//! Conjugate gradients that go from an incomplete factor to a hierarchy when they have lost enough by it.

use super::multigrid::{BYTES_PER_ITERATION, FLOPS_PER_BYTE, RENEWAL, digits, is_cheaper_than};
use super::{Descent, DescentDirection, DescentOutcome, NewtonSystem, PcgDirection, rigid};
use crate::block_matrix::BlockSymmetric;
use crate::cholesky::SymbolicCholesky;
use crate::newton::NewtonFailure;
use crate::preconditioner::{BlockIc0, PreconditionerError};

/// Bytes that an iteration with an incomplete factor moves, over those of the matrix: the matrix once, and
/// its incomplete factor, in `f32`, twice.
const BYTES_WITH_IC0: f64 = 2.0;
/// Iterations with an incomplete factor that move as many bytes as one on a hierarchy.
const WORTH: f64 = BYTES_PER_ITERATION / BYTES_WITH_IC0;
/// Iterations on a hierarchy for each decimal digit of the residual: 5 to 10 were measured (docs/solvers.md).
const PER_DIGIT: f64 = 8.0;
/// What a first hierarchy costs beside its values, in iterations on it: aggregates and patterns.
const FIRST_HIERARCHY: f64 = 25.0;

/// With an incomplete factor, until the steps have moved so many bytes more than steps of multigrid would
/// have that a first hierarchy would have been paid for; from then on by multigrid, where there is one for the
/// near kernel, until it meets a matrix that is indefinite or of which `f32` makes no hierarchy. Then the
/// count begins again: the way back from a wild start is no place for hierarchies.
pub(super) struct Thrifty<const D: usize> {
    incomplete: PcgDirection<BlockIc0<D>>,
    /// Iterations that move as many bytes as a factorization takes flops over four.
    of_a_factor: f64,
    /// Multigrid for the near kernel, where there is one that is cheaper than a factor.
    multigrid: Option<Box<dyn DescentDirection<D>>>,
    on_multigrid: bool,
    /// Iterations that may still be lost to multigrid.
    spare: f64,
}

impl<const D: usize> Thrifty<D> {
    /// For matrices of this pattern, whose near kernel has so many vectors.
    pub fn new(
        matrix: &BlockSymmetric<D>,
        symbolic: &SymbolicCholesky<D>,
        motions: impl FnOnce() -> usize,
    ) -> Self {
        let bytes = BYTES_WITH_IC0 * (8 * D * D * matrix.pattern().stored()) as f64;
        Self {
            incomplete: PcgDirection::new(BlockIc0::default(), 0),
            of_a_factor: (symbolic.flops() / (FLOPS_PER_BYTE * bytes)).ceil(),
            multigrid: match is_cheaper_than(symbolic, 1.0) {
                true => rigid::multigrid(motions()),
                false => None,
            },
            on_multigrid: false,
            spare: WORTH * FIRST_HIERARCHY,
        }
    }

    fn with_incomplete_factor(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        // The iterations of a hierarchy that serves already, and those beside new values.
        let least = WORTH * PER_DIGIT * digits(system.forcing());
        let most = least + WORTH * RENEWAL;
        let budget = match &self.multigrid {
            Some(_) => self.of_a_factor.min(most + self.spare),
            None => self.of_a_factor,
        };
        self.incomplete.set_budget(budget as usize);
        let found = self.incomplete.direction(system, dx)?;
        if found.outcome == DescentOutcome::Found {
            let taken = found.linear_iterations as f64;
            let won = (least - taken).max(0.0) - (taken - most).max(0.0);
            self.spare = (self.spare + won).min(WORTH * FIRST_HIERARCHY);
        }
        Ok(found)
    }
}

impl<const D: usize> DescentDirection<D> for Thrifty<D> {
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let mut done = Descent::iterated(DescentOutcome::TooSlow, 0);
        if !self.on_multigrid {
            done = self.with_incomplete_factor(system, dx)?;
            if done.outcome != DescentOutcome::TooSlow {
                return Ok(done);
            }
            self.on_multigrid = true;
        }
        let Some(multigrid) = &mut self.multigrid else {
            return Ok(done);
        };
        dx.fill(0.0);
        match multigrid.direction(system, dx) {
            Ok(found) => {
                if found.outcome == DescentOutcome::Indefinite {
                    self.on_multigrid = false;
                    self.spare = WORTH * FIRST_HIERARCHY;
                }
                Ok(found.after(done))
            }
            // A near kernel that is none, or a coarse matrix that cannot be factored.
            Err(NewtonFailure::Preconditioner(
                PreconditionerError::NearKernel(_) | PreconditionerError::Coarse(_),
            )) => {
                self.multigrid = None;
                self.on_multigrid = false;
                Ok(self.with_incomplete_factor(system, dx)?.after(done))
            }
            Err(error) => Err(error),
        }
    }
}
