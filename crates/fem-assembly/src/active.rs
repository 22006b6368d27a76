//! Which stencils have a part in one pass over an energy.

use crate::configuration::Positions;
use crate::plan::Summand;
use fem_solvers::parallel::map;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// Of each term the stencils that may have an energy at one place ([`Term::active`](crate::Term::active)).
pub(crate) struct Active(Vec<Option<Vec<usize>>>);

/// What was active last, and where: energy, forces and matrix of one place follow each other.
pub(crate) struct Remembered<const D: usize>(Mutex<Option<Last<D>>>);

/// Positions, and what is active there.
type Last<const D: usize> = (Vec<[f64; D]>, Arc<Active>);

impl<const D: usize> Remembered<D> {
    pub fn nothing() -> Self {
        Self(Mutex::new(None))
    }

    pub fn forget(&mut self) {
        *self = Self::nothing();
    }

    pub fn at(&self, summands: &[Summand<D>], at: Positions<D>) -> Arc<Active> {
        let last = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((place, active)) = &*last()
            && place.as_slice() == at.as_slice()
        {
            return active.clone();
        }
        // The lock is not held while terms look: a thread that waits for others may come here again.
        let of = |s: &Summand<D>| match s.stencils.batch {
            1 => s.term.active(at),
            // Those are evaluated side by side, whole batches.
            _ => None,
        };
        let found = Active(summands.iter().map(of).collect());
        let some = found.0.iter().any(Option::is_some);
        let active = Arc::new(found);
        // Nothing to remember, and no list to copy, where every stencil is active anywhere.
        *last() = some.then(|| (at.as_slice().to_vec(), active.clone()));
        active
    }
}

impl Active {
    /// The active stencils of a run of those of a term, in runs.
    pub fn runs(&self, term: usize, run: Range<usize>) -> impl Iterator<Item = Range<usize>> + '_ {
        let (all, some) = match &self.0[term] {
            None => (Some(run), &[][..]),
            Some(active) => {
                let place = |stencil| active.partition_point(|&s| s < stencil);
                (None, &active[place(run.start)..place(run.end)])
            }
        };
        let consecutive = some.chunk_by(|a, b| a + 1 == *b);
        all.into_iter()
            .chain(consecutive.map(|own| own[0]..own[own.len() - 1] + 1))
    }
}

/// Stencils that a thread looks at in one go.
const GLANCE: usize = 1024;

/// Those of so many stencils of which `felt` is true, ascending.
pub(crate) fn felt(count: usize, felt: impl Fn(usize) -> bool + Sync) -> Vec<usize> {
    let glances: Vec<usize> = (0..count).step_by(GLANCE).collect();
    let found: Vec<Vec<usize>> = map(glances, |start| {
        let own = start..(start + GLANCE).min(count);
        own.filter(|&stencil| felt(stencil)).collect()
    });
    found.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_hold_what_is_active_and_nothing_else() {
        let active = Active(vec![None, Some(vec![0, 1, 4, 7, 8, 9]), Some(Vec::new())]);
        let of = |term, run: Range<usize>| {
            let runs = active.runs(term, run).map(|run| (run.start, run.end));
            runs.collect::<Vec<_>>()
        };
        assert_eq!(of(0, 3..9), [(3, 9)]);
        assert_eq!(of(1, 0..10), [(0, 2), (4, 5), (7, 10)]);
        assert_eq!(of(1, 1..9), [(1, 2), (4, 5), (7, 9)]);
        assert_eq!(of(1, 2..4), []);
        assert_eq!(of(2, 0..10), []);
    }

    #[test]
    fn a_glance_misses_no_stencil_at_its_ends() {
        for count in [0, 1, GLANCE - 1, GLANCE, 2 * GLANCE + 1] {
            let all: Vec<usize> = (0..count).collect();
            assert_eq!(felt(count, |_| true), all);
            let thirds: Vec<usize> = (0..count).step_by(3).collect();
            assert_eq!(felt(count, |stencil| stencil % 3 == 0), thirds);
        }
    }
}
