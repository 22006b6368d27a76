//! [`LinearSolver::Auto`](crate::LinearSolver): the default, decided by counting operations.

use super::multigrid::{BYTES_PER_ITERATION, FLOPS_PER_BYTE, RENEWAL, digits};
use super::single::Single;
use super::{
    Descent, DescentDirection, DescentOutcome, MultigridDirection, NewtonSystem, PcgDirection,
    rigid,
};
use crate::block_matrix::BlockSymmetric;
use crate::newton::NewtonFailure;
use crate::preconditioner::{BlockIc0, Identity};

/// Flops of a factorization below which nothing else is tried.
const CHEAP_FACTOR: f64 = 4e8;
/// Products in one step of a problem that has no matrix.
const PRODUCTS: usize = 2_000;
/// Bytes that an iteration with an incomplete factor moves, over those of the matrix: the matrix once, and
/// its incomplete factor, in `f32`, twice.
const BYTES_WITH_IC0: f64 = 2.0;
/// Iterations on a hierarchy for each decimal digit of the residual: 5 on a twisted bar, 10 on a bent one.
const PER_DIGIT: f64 = 8.0;
/// What a first hierarchy costs beside its values, in iterations on it: aggregates and patterns.
const FIRST_HIERARCHY: f64 = 25.0;

/// Small systems directly. Larger ones by conjugate gradients with an incomplete factor, until their steps
/// have moved so many bytes more than steps of multigrid would have that a first hierarchy would have been
/// paid for; from then on by multigrid. Where the near kernel is no body's, or multigrid proves too slow,
/// by an `f32` factor once a step takes as long as a factorization. Without a matrix plain conjugate
/// gradients.
pub(super) struct Auto<const D: usize> {
    stage: Stage<D>,
    single: Single<D>,
}

enum Stage<const D: usize> {
    Unasked,
    Incomplete(Box<Incomplete<D>>),
    Multigrid(Box<dyn DescentDirection<D>>),
    Factor,
}

struct Incomplete<const D: usize> {
    iterative: PcgDirection<BlockIc0<D>>,
    /// Iterations that move as many bytes as a factorization takes flops over four.
    of_a_factor: f64,
    /// Multigrid for the near kernel, where there is one that is cheaper than a factor, and the iterations
    /// that may still be lost to it.
    next: Option<(Box<dyn DescentDirection<D>>, f64)>,
}

/// Iterations with an incomplete factor that move as many bytes as this many on a hierarchy.
fn worth(iterations: f64) -> f64 {
    iterations * BYTES_PER_ITERATION / BYTES_WITH_IC0
}

impl<const D: usize> Incomplete<D> {
    fn new(
        system: &mut NewtonSystem<'_, D>,
        matrix: &BlockSymmetric<D>,
    ) -> Result<Self, NewtonFailure> {
        let symbolic = system.symbolic()?;
        let bytes = BYTES_WITH_IC0 * (8 * D * D * matrix.pattern().stored()) as f64;
        let next = match MultigridDirection::<D, D>::is_cheaper_than(&symbolic, 1.0) {
            true => rigid::multigrid(system.near_kernel().count()),
            false => None,
        };
        Ok(Self {
            iterative: PcgDirection::new(BlockIc0::default(), 0),
            of_a_factor: (symbolic.flops() / (FLOPS_PER_BYTE * bytes)).ceil(),
            next: next.map(|multigrid| (multigrid, worth(FIRST_HIERARCHY))),
        })
    }

    /// `TooSlow` where another stage is to go on.
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let by_multigrid = worth(RENEWAL + PER_DIGIT * digits(system.forcing()));
        let budget = match &self.next {
            Some((_, spare)) => by_multigrid + spare,
            None => self.of_a_factor,
        };
        self.iterative.set_budget(budget as usize);
        let found = self.iterative.direction(system, dx)?;
        if let Some((_, spare)) = &mut self.next {
            *spare -= (found.linear_iterations as f64 - by_multigrid).max(0.0);
        }
        Ok(found)
    }
}

impl<const D: usize> DescentDirection<D> for Auto<D> {
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let Some(matrix) = system.tangent.matrix() else {
            return PcgDirection::new(Identity, PRODUCTS).direction(system, dx);
        };
        if system.symbolic()?.flops() < CHEAP_FACTOR {
            return system.solve_directly(dx);
        }
        if let Stage::Unasked = self.stage {
            self.stage = Stage::Incomplete(Box::new(Incomplete::new(system, matrix)?));
        }
        let mut done = Descent::iterated(DescentOutcome::TooSlow, 0);
        if let Stage::Incomplete(incomplete) = &mut self.stage {
            done = incomplete.direction(system, dx)?;
            if done.outcome != DescentOutcome::TooSlow {
                return Ok(done);
            }
            let next = incomplete.next.take();
            self.stage = next.map_or(Stage::Factor, |(multigrid, _)| Stage::Multigrid(multigrid));
        }
        if let Stage::Multigrid(multigrid) = &mut self.stage {
            done = multigrid.direction(system, dx)?.after(done);
            if done.outcome != DescentOutcome::TooSlow {
                return Ok(done);
            }
            self.stage = Stage::Factor;
        }
        Ok(self.single.direction(system, dx)?.after(done))
    }
}

impl<const D: usize> Default for Auto<D> {
    fn default() -> Self {
        Self {
            stage: Stage::Unasked,
            single: Single::default(),
        }
    }
}
