//! Stencils that change: what is near touches, and what is near is not the same for ever.

use crate::assembly::Assembly;
use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::plan;
use crate::term::Term;
use std::sync::Arc;

impl<const D: usize> Assembly<D> {
    /// May [`Assembly::renew`] ever change anything?
    pub fn changes(&self) -> bool {
        self.summands.iter().any(|summand| summand.term.changes())
    }

    /// Lets the next [`Assembly::renew`] depend on no configuration seen before.
    pub fn forget(&mut self) {
        for summand in &mut self.summands {
            summand.term.forget();
        }
    }

    /// Asks every term for the stencils that `at` and its neighborhood need; true when some changed.
    ///
    /// Only what depends on changed stencils is planned anew. The pattern is another `Arc` when, and
    /// only when, a pair of nodes is coupled that had no place in it: then a solver that has analyzed
    /// the old one must be made again, as
    /// [`solve_renewing`](crate::solve_renewing) does.
    ///
    /// # Errors
    /// As [`AssemblyBuilder::term`](crate::AssemblyBuilder::term) and
    /// [`AssemblyBuilder::build`](crate::AssemblyBuilder::build) of the new stencils; the assembly is
    /// then no longer usable.
    pub fn renew(&mut self, at: Configuration<D>) -> Result<bool, AssemblyError> {
        self.renewed(|term| term.renew(at))
    }

    /// The same for a step by `displacement` that is about to be taken ([`Term::renew_along`]).
    ///
    /// # Errors
    /// As [`Assembly::renew`].
    pub fn renew_along(
        &mut self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> Result<bool, AssemblyError> {
        self.renewed(|term| term.renew_along(at, displacement))
    }

    fn renewed(
        &mut self,
        mut look: impl FnMut(&mut dyn Term<D>) -> bool,
    ) -> Result<bool, AssemblyError> {
        if self.changes() {
            self.counter.searched();
        }
        let mut changed = vec![false; self.summands.len()];
        let mut stencils = 0;
        for (index, summand) in self.summands.iter_mut().enumerate() {
            changed[index] = look(summand.term.as_mut());
            if changed[index] {
                summand.stencils = summand.term.stencils();
                summand.stencils.check(index, self.rest.len())?;
            }
            summand.first_energy = stencils;
            stencils += summand.stencils.count();
        }
        if !changed.contains(&true) {
            return Ok(false);
        }
        if u32::try_from(stencils).is_err() {
            return Err(AssemblyError::TooManyStencils { count: stencils });
        }
        self.plan_again(&changed)?;
        Ok(true)
    }

    fn plan_again(&mut self, changed: &[bool]) -> Result<(), AssemblyError> {
        let terms = || self.summands.iter().zip(changed);
        let fits = terms().all(|(s, &c)| !c || plan::fits(&s.stencils, &self.dofs, &self.pattern));
        if !fits {
            self.pattern = Arc::new(plan::pattern(&self.dofs, &self.summands)?);
        }
        for chunk in &mut self.chunks {
            let works = chunk.works.iter_mut().zip(&self.summands).zip(changed);
            for ((work, summand), &changed) in works {
                if changed || !fits {
                    let stencils = &summand.stencils;
                    *work = plan::work(stencils, &chunk.rows, &self.dofs, &self.pattern);
                }
            }
        }
        self.free = plan::free(&mut self.summands, &self.dofs);
        self.free_pieces = plan::pieces(&self.summands, &self.free, true);
        self.prescribed_pieces = plan::pieces(&self.summands, &self.free, false);
        Ok(())
    }
}
