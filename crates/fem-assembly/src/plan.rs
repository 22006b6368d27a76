//! Who sums which rows, and which stencils that takes.
//!
//! The rows are cut into chunks of consecutive ones; a chunk's owner evaluates every stencil that
//! touches its rows, those on a border are evaluated by both neighbors. Each row is thus summed by
//! one owner, in the order (term, stencil), and has the same bits however many chunks there are.

use crate::dofs::{Dofs, PRESCRIBED};
use crate::error::AssemblyError;
use crate::evaluations::StencilCost;
use crate::sink::{NONE, TRANSPOSED, pair};
use crate::term::{NOBODY, Stencils, Term};
use fem_solvers::BlockPattern;
use fem_solvers::parallel;
use std::ops::Range;

/// Rows below which a chunk is not worth its border.
const SMALLEST_CHUNK: usize = 512;
/// Chunks per thread, so that an uneven load evens out.
const CHUNKS_PER_THREAD: usize = 2;
/// Stencils in a piece of the energy.
const PIECE: usize = 4096;

/// A term and what the sum needs to know of it.
pub(crate) struct Summand<const D: usize> {
    pub term: Box<dyn Term<D>>,
    pub stencils: Stencils,
    /// Place of its first stencil in lists over the stencils of all terms.
    pub first_energy: usize,
    /// What an evaluation of a stencil counts as.
    pub cost: StencilCost,
    /// How many stencils a free node feels.
    pub felt: u64,
    /// Of each control, how many stencils are idle without it: felt by a free node, and by none.
    pub idle: Vec<[u64; 2]>,
}

impl<const D: usize> Summand<D> {
    /// Its stencils that touch `rows`; `None` where they change.
    pub fn planned(
        &self,
        rows: &Range<usize>,
        dofs: &Dofs<D>,
        pattern: &BlockPattern,
    ) -> Option<Work> {
        (!self.term.changes()).then(|| work(&self.stencils, rows, dofs, pattern))
    }

    /// How many stencils that a free node feels are evaluated.
    pub fn felt(&self, controls: &[f64]) -> u64 {
        self.felt - self.idle(controls, 0)
    }

    /// How many that none feels.
    pub fn prescribed(&self, controls: &[f64]) -> u64 {
        self.stencils.count() as u64 - self.felt - self.idle(controls, 1)
    }

    /// How many are evaluated where every node has a row.
    pub fn all(&self, controls: &[f64]) -> u64 {
        self.felt(controls) + self.prescribed(controls)
    }

    fn idle(&self, controls: &[f64], whose: usize) -> u64 {
        let idle = self.idle.iter().zip(controls);
        let relaxed = idle.filter(|(_, control)| **control == 0.0);
        relaxed.map(|(counts, _)| counts[whose]).sum()
    }

    /// Counts what a free node feels, stencil by stencil.
    fn count(&mut self, free: &[bool]) {
        self.felt = free.iter().filter(|&&felt| felt).count() as u64;
        self.idle.clear();
        for (stencil, &felt) in free.iter().enumerate() {
            if let Some(control) = self.term.idle_without(stencil) {
                let known = self.idle.len().max(control + 1);
                self.idle.resize(known, [0; 2]);
                self.idle[control][usize::from(!felt)] += 1;
            }
        }
    }
}

/// Consecutive matrix rows and the stencils that touch them, one entry for each term.
pub(crate) struct Chunk {
    pub rows: Range<usize>,
    /// Of a term that changes its stencils none: what is active of it is planned in each pass, which is less
    /// than all of it after each look.
    pub works: Vec<Option<Work>>,
}

/// The stencils of one term that touch one chunk, and where their sums go.
pub(crate) struct Work {
    pub runs: Vec<Run>,
    /// Row in the chunk of each (stencil, vertex).
    pub rows: Vec<u32>,
    /// Place in the chunk's matrix values of each (stencil, pair of vertices).
    pub places: Vec<u32>,
    /// Does this chunk count the energy of the stencil?
    pub owned: Vec<bool>,
}

/// Consecutive batches.
pub(crate) struct Run {
    pub stencils: Range<usize>,
    /// Place of its first stencil in the lists of [`Work`].
    pub start: usize,
}

/// Stencils of one term.
pub(crate) struct Piece {
    pub term: usize,
    pub stencils: Range<usize>,
}

impl Stencils {
    pub(crate) fn nodes_of(&self, stencil: usize) -> &[usize] {
        let all = &self.nodes[stencil * self.vertices..(stencil + 1) * self.vertices];
        let count = all.iter().position(|&n| n == NOBODY);
        &all[..count.unwrap_or(all.len())]
    }

    /// Every node exists, and none twice in a stencil.
    pub(crate) fn check(&self, term: usize, count: usize) -> Result<(), AssemblyError> {
        for stencil in 0..self.count() {
            let nodes = self.nodes_of(stencil);
            let padded = &self.nodes[stencil * self.vertices..][nodes.len()..self.vertices];
            let mut nobody = padded.iter().filter(|&&n| n != NOBODY || nodes.is_empty());
            let unknown = nodes.iter().find(|&&n| n >= count);
            if let Some(&node) = unknown.or(nobody.next()) {
                return Err(AssemblyError::NoSuchNode { node, count });
            }
            for (a, &node) in nodes.iter().enumerate() {
                if nodes[..a].contains(&node) {
                    return Err(AssemblyError::RepeatedNode {
                        term,
                        stencil,
                        node,
                    });
                }
            }
        }
        Ok(())
    }

    /// Its first free row, [`PRESCRIBED`] where it has none.
    fn first_row<const D: usize>(&self, stencil: usize, dofs: &Dofs<D>) -> u32 {
        let rows = self.nodes_of(stencil).iter().map(|&n| dofs.rank()[n]);
        rows.min().unwrap_or(PRESCRIBED)
    }

    /// Runs of those batches of `some`, whole ones, that hold a chosen stencil.
    fn runs(&self, some: Range<usize>, chosen: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        for start in some.clone().step_by(self.batch) {
            let end = (start + self.batch).min(some.end);
            if !(start..end).any(&chosen) {
                continue;
            }
            match runs.last_mut() {
                Some(run) if run.end == start => run.end = end,
                _ => runs.push(start..end),
            }
        }
        runs
    }
}

/// Is each stencil of each term felt by a free node? Counts those that are.
pub(crate) fn free<const D: usize>(summands: &mut [Summand<D>], dofs: &Dofs<D>) -> Vec<bool> {
    let mut free = Vec::new();
    for summand in summands {
        let (stencils, before) = (&summand.stencils, free.len());
        free.extend((0..stencils.count()).map(|k| stencils.first_row(k, dofs) != PRESCRIBED));
        summand.count(&free[before..]);
    }
    free
}

/// The batches that hold a stencil with `free` as wanted, in pieces of about equal size.
pub(crate) fn pieces<const D: usize>(
    summands: &[Summand<D>],
    free: &[bool],
    wanted: bool,
) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (term, summand) in summands.iter().enumerate() {
        let stencils = &summand.stencils;
        let free = &free[summand.first_energy..];
        let step = stencils.batch * PIECE.div_ceil(stencils.batch);
        for run in stencils.runs(0..stencils.count(), |k| free[k] == wanted) {
            for start in run.clone().step_by(step) {
                let stencils = start..(start + step).min(run.end);
                pieces.push(Piece { term, stencils });
            }
        }
    }
    pieces
}

/// Finds places of a pattern, those that were asked for a moment ago without a search: neighboring stencils
/// couple the same nodes.
struct Finder<'a> {
    pattern: &'a BlockPattern,
    /// (row, column, place) of the last search that fell here.
    known: Vec<(u32, u32, Option<usize>)>,
}

impl<'a> Finder<'a> {
    /// For about so many questions.
    fn new(pattern: &'a BlockPattern, questions: usize) -> Self {
        let room = questions.clamp(1 << 6, 1 << 12).next_power_of_two();
        let known = vec![(PRESCRIBED, PRESCRIBED, None); room];
        Self { pattern, known }
    }

    fn find(&mut self, high: u32, low: u32) -> Option<usize> {
        let mixed = (high.wrapping_mul(0x9E37_79B1) >> 7) ^ low;
        let place = mixed as usize % self.known.len();
        let known = &mut self.known[place];
        if (known.0, known.1) != (high, low) {
            *known = (high, low, self.pattern.find(high as usize, low as usize));
        }
        known.2
    }
}

/// The pairs of rows that stencils couple, higher first.
fn coupled<'a, const D: usize>(
    stencils: &'a Stencils,
    dofs: &'a Dofs<D>,
) -> impl Iterator<Item = (usize, usize)> + 'a {
    let rank = dofs.rank();
    let of = |k: usize| {
        let nodes = stencils.nodes_of(k);
        (1..nodes.len()).flat_map(move |a| nodes[..a].iter().map(move |&n| (nodes[a], n)))
    };
    (0..stencils.count())
        .flat_map(of)
        .filter_map(move |(m, n)| {
            let (high, low) = (rank[m].max(rank[n]), rank[m].min(rank[n]));
            (high != PRESCRIBED).then_some((high as usize, low as usize))
        })
}

/// The places of the Hessian: whatever shares a stencil; prescribed axes are absent.
pub(crate) fn pattern<const D: usize>(
    dofs: &Dofs<D>,
    summands: &[Summand<D>],
) -> Result<BlockPattern, AssemblyError> {
    let pairs = summands.iter().flat_map(|s| coupled(&s.stencils, dofs));
    let axes = dofs.prescribed_axes().iter();
    let pattern = BlockPattern::from_adjacency(dofs.free_nodes(), pairs)?;
    Ok(pattern.with_absent(axes.map(|&(row, axis)| (row as usize, axis)))?)
}

/// The pattern with the places that other stencils need as well; `None` where it has them all.
pub(crate) fn extended<'a, const D: usize>(
    pattern: &BlockPattern,
    dofs: &'a Dofs<D>,
    stencils: impl Iterator<Item = &'a Stencils>,
) -> Result<Option<BlockPattern>, AssemblyError> {
    let mut finder = Finder::new(pattern, usize::MAX);
    let mut missing: Vec<(usize, usize)> = stencils
        .flat_map(|s| coupled(s, dofs))
        .filter(|&(high, low)| finder.find(high as u32, low as u32).is_none())
        .collect();
    if missing.is_empty() {
        return Ok(None);
    }
    missing.sort_unstable();
    missing.dedup();
    Ok(Some(pattern.extended(missing)?))
}

/// For each stored block of `old` its index in `new`, which has all of them.
pub(crate) fn moved(old: &BlockPattern, new: &BlockPattern) -> Vec<usize> {
    let mut places = Vec::with_capacity(old.stored());
    for row in 0..old.blocks() {
        let mut at = new.row_start()[row];
        for column in old.row(row) {
            while new.columns()[at] != *column {
                at += 1;
            }
            places.push(at);
        }
    }
    places
}

impl Work {
    /// Takes the places in another pattern, where all of them are; `first` are the first values of the
    /// chunk in both.
    pub fn moved(&mut self, places: &[usize], first: [usize; 2]) {
        for place in self.places.iter_mut().filter(|place| **place != NONE) {
            let mark = *place & TRANSPOSED;
            let old = (*place & !TRANSPOSED) as usize + first[0];
            *place = (places[old] - first[1]) as u32 | mark;
        }
    }
}

/// Cuts the rows into runs of about equal work.
pub(crate) fn cut<const D: usize>(dofs: &Dofs<D>, summands: &[Summand<D>]) -> Vec<Range<usize>> {
    let rows = dofs.free_nodes();
    let wanted = CHUNKS_PER_THREAD * parallel::threads();
    let count = (rows / SMALLEST_CHUNK).clamp(1, wanted.max(1));
    let mut work = vec![0_usize; rows];
    for stencils in summands.iter().map(|s| &s.stencils) {
        for k in 0..stencils.count() {
            let row = stencils.first_row(k, dofs);
            if row != PRESCRIBED {
                work[row as usize] += stencils.vertices;
            }
        }
    }
    let share = work.iter().sum::<usize>().div_ceil(count).max(1);
    let (mut begin, mut total) = (0, 0);
    let mut ranges = Vec::with_capacity(count);
    for (row, weight) in work.iter().enumerate() {
        total += weight;
        if total >= share * (ranges.len() + 1) && row + 1 < rows && ranges.len() + 1 < count {
            ranges.push(begin..row + 1);
            begin = row + 1;
        }
    }
    ranges.push(begin..rows);
    ranges
}

/// The stencils of a term that touch `rows`, with their places.
pub(crate) fn work<const D: usize>(
    stencils: &Stencils,
    rows: &Range<usize>,
    dofs: &Dofs<D>,
    pattern: &BlockPattern,
) -> Work {
    let all = 0..stencils.count();
    work_on(stencils, std::iter::once(all), rows, dofs, Some(pattern))
}

/// The same of some runs of them, without places in the matrix where no pattern is given.
pub(crate) fn work_on<const D: usize>(
    stencils: &Stencils,
    some: impl Iterator<Item = Range<usize>>,
    rows: &Range<usize>,
    dofs: &Dofs<D>,
    pattern: Option<&BlockPattern>,
) -> Work {
    let rank = dofs.rank();
    let ours = |row: u32| row != PRESCRIBED && rows.contains(&(row as usize));
    let touches = |k: usize| stencils.nodes_of(k).iter().any(|&n| ours(rank[n]));
    let runs: Vec<Range<usize>> = some.flat_map(|all| stencils.runs(all, touches)).collect();
    let pairs = pattern.map_or(0, |_| pair(stencils.vertices, 0));
    let questions = pairs * runs.iter().map(Range::len).sum::<usize>();
    let mut matrix = pattern.map(|pattern| {
        let finder = Finder::new(pattern, questions);
        (finder, pattern.row_start()[rows.start])
    });
    let mut work = Work {
        runs: Vec::new(),
        rows: Vec::new(),
        places: Vec::new(),
        owned: Vec::new(),
    };
    for run in runs {
        work.runs.push(Run {
            stencils: run.clone(),
            start: work.owned.len(),
        });
        for k in run {
            let nodes = stencils.nodes_of(k);
            work.owned.push(ours(stencils.first_row(k, dofs)));
            for (a, &node) in nodes.iter().enumerate() {
                let row = rank[node];
                let local = row.wrapping_sub(rows.start as u32);
                work.rows.push(if ours(row) { local } else { NONE });
                let Some((finder, first_value)) = &mut matrix else {
                    continue;
                };
                debug_assert_eq!(work.places.len() % pairs, pair(a, 0));
                for &other in &nodes[..=a] {
                    let (high, low) = (row.max(rank[other]), row.min(rank[other]));
                    let place = if ours(high) {
                        finder.find(high, low)
                    } else {
                        None
                    };
                    let mark = if row < rank[other] { TRANSPOSED } else { 0 };
                    work.places
                        .push(place.map_or(NONE, |p| (p - *first_value) as u32 | mark));
                }
            }
            let known = work.owned.len();
            work.rows.resize(known * stencils.vertices, NONE);
            work.places.resize(known * pairs, NONE);
        }
    }
    // The last batch may not be full.
    let padded = work.owned.len().next_multiple_of(stencils.batch);
    work.rows.resize(padded * stencils.vertices, NONE);
    work.places.resize(padded * pairs, NONE);
    work
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every question twice, where each place of what is known serves many.
    #[test]
    fn what_is_known_is_the_place_of_what_was_asked() {
        let rows = 300;
        let coupled = (0..rows).flat_map(|i| (0..i).step_by(3).map(move |j| (i, j)));
        let pattern = BlockPattern::from_adjacency(rows, coupled).unwrap();
        let mut finder = Finder::new(&pattern, 1);
        for high in 0..rows {
            for low in (0..=high).chain((0..=high).rev()) {
                let found = finder.find(high as u32, low as u32);
                assert_eq!(found, pattern.find(high, low), "{high} {low}");
            }
        }
    }
}
