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
        self.forgets = self.changes();
        for summand in &mut self.summands {
            summand.term.forget();
        }
    }

    /// Asks every term for the stencils that `at` and its neighborhood need; true when some changed.
    ///
    /// Only what depends on changed stencils is planned anew. The pattern is another `Arc` when, and
    /// only when, a pair of nodes is coupled that had no place in it (it then keeps the places that it
    /// had), or after [`Assembly::forget`] one has a place that is not: then a solver that has analyzed
    /// the old one must be made again, as
    /// [`solve_renewing`](crate::solve_renewing) does.
    ///
    /// # Errors
    /// As [`AssemblyBuilder::term`](crate::AssemblyBuilder::term) and
    /// [`AssemblyBuilder::build`](crate::AssemblyBuilder::build) of the new stencils; the assembly is
    /// then no longer usable.
    pub fn renew(&mut self, at: Configuration<D>) -> Result<bool, AssemblyError> {
        self.check_configuration(at)?;
        self.renewed(|term| term.renew(at))
    }

    /// The same where an equilibrium was found ([`Term::renew_at_equilibrium`]).
    pub(crate) fn renew_at_equilibrium(
        &mut self,
        at: Configuration<D>,
    ) -> Result<bool, AssemblyError> {
        self.renewed(|term| term.renew_at_equilibrium(at))
    }

    /// The same for a step by `displacement` that is about to be taken ([`Term::renew_along`]).
    ///
    /// # Errors
    /// As [`Assembly::renew`]; before anything is changed, where there is not one displacement for each node.
    pub fn renew_along(
        &mut self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> Result<bool, AssemblyError> {
        self.check_displacement(at, displacement)?;
        self.renewed(|term| term.renew_along(at, displacement))
    }

    /// [`Assembly::renew`] and [`Assembly::renew_along`], planned once.
    pub(crate) fn renew_for_step(
        &mut self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> Result<bool, AssemblyError> {
        self.check_displacement(at, displacement)?;
        self.renewed(|term| term.renew_for_step(at, displacement))
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
        let anew = std::mem::take(&mut self.forgets);
        let any = changed.contains(&true);
        if !any && !anew {
            return Ok(false);
        }
        self.active.forget();
        if u32::try_from(stencils).is_err() {
            return Err(AssemblyError::TooManyStencils { count: stencils });
        }
        Ok(self.plan_again(&changed, anew)? || any)
    }

    /// What changes is planned where it is evaluated; the others' places move with the pattern.
    fn plan_again(&mut self, changed: &[bool], anew: bool) -> Result<bool, AssemblyError> {
        let before = self.pattern.clone();
        self.find_pattern(changed, anew)?;
        let same = Arc::ptr_eq(&before, &self.pattern);
        // A pattern that grew has a place for all that the old one had.
        let places = (!same && !anew).then(|| plan::moved(&before, &self.pattern));
        for chunk in &mut self.chunks {
            let first = [&before, &self.pattern].map(|p| p.row_start()[chunk.rows.start]);
            let works = chunk.works.iter_mut().zip(&self.summands).zip(changed);
            for ((work, summand), &changed) in works {
                match (work, &places) {
                    (None, _) => {}
                    (Some(_), _) if !changed && same => {}
                    (Some(work), Some(places)) if !changed => work.moved(places, first),
                    (work, _) => *work = summand.planned(&chunk.rows, &self.dofs, &self.pattern),
                }
            }
        }
        if changed.contains(&true) {
            self.free = plan::free(&mut self.summands, &self.dofs);
            self.free_pieces = plan::pieces(&self.summands, &self.free, true);
            self.prescribed_pieces = plan::pieces(&self.summands, &self.free, false);
        }
        Ok(!same)
    }

    /// Puts another pattern in place where the present one lacks something, or `anew` where it has
    /// too much. Between two of these it only grows: what touched once is likely to touch again, and
    /// an analysis costs more than the zeros.
    fn find_pattern(&mut self, changed: &[bool], anew: bool) -> Result<(), AssemblyError> {
        if !anew {
            let others = self.summands.iter().zip(changed).filter(|(_, c)| **c);
            let others = others.map(|(s, _)| &s.stencils);
            if let Some(grown) = plan::extended(&self.pattern, &self.dofs, others)? {
                self.pattern = Arc::new(grown);
            }
            return Ok(());
        }
        let pattern = plan::pattern(&self.dofs, &self.summands)?;
        if pattern != *self.pattern {
            self.pattern = Arc::new(pattern);
        }
        Ok(())
    }
}
