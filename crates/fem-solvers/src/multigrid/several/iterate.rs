//! The iterations of a few right-hand sides side by side, each with its own numbers.

use crate::parallel::{each, map};
use crate::pcg::PcgError;
use std::array::from_fn;

/// What is solved with; vectors hold the numbers of `B` right-hand sides side by side.
pub trait System<const B: usize> {
    /// `Y = A X`.
    fn product(&self, x: &[[f64; B]], y: &mut [[f64; B]]);
    /// `Z ≈ A⁻¹ R`.
    fn cycle(&self, r: &[[f64; B]], z: &mut [[f64; B]]);
}

/// Iterations whose gains together stand for the error of the iterate before them.
const DELAY: usize = 4;
/// Entries of one task; the cut of the sums does not depend on the number of threads.
const CHUNK: usize = 2048;

/// One right-hand side among those side by side.
#[derive(Clone, Copy, Default)]
struct Column {
    works: bool,
    iterations: usize,
    rz: f64,
    /// ‖x‖² in the norm of the matrix so far.
    energy: f64,
    /// What the last iterations added to it.
    gains: [f64; DELAY],
    /// Iterations since the last start.
    since: usize,
}

impl Column {
    /// Is the iterate of [`DELAY`] iterations ago within the tolerance?
    fn is_done(&self, tolerance: f64) -> bool {
        let gained: f64 = self.gains.iter().sum();
        self.since >= DELAY && gained <= tolerance * tolerance * self.energy
    }
}

/// Conjugate gradients from zero.
pub struct Iterate<const B: usize> {
    pub x: Vec<[f64; B]>,
    r: Vec<[f64; B]>,
    z: Vec<[f64; B]>,
    p: Vec<[f64; B]>,
    ap: Vec<[f64; B]>,
    columns: [Column; B],
}

impl<const B: usize> Iterate<B> {
    pub fn new(b: Vec<[f64; B]>) -> Self {
        let zero = || vec![[0.0; B]; b.len()];
        let (x, z, p, ap) = (zero(), zero(), zero(), zero());
        let column = |k: usize| Column {
            works: b.iter().any(|b| b[k] != 0.0),
            ..Column::default()
        };
        Self {
            columns: from_fn(column),
            x,
            r: b,
            z,
            p,
            ap,
        }
    }

    pub fn iterations(&self) -> usize {
        self.columns.iter().map(|column| column.iterations).sum()
    }

    /// The most iterations of a column.
    pub fn longest(&self) -> usize {
        let all = self.columns.iter().map(|column| column.iterations);
        all.max().unwrap_or(0)
    }

    /// Until every column's error is estimated to be within the tolerance; `false` when the iterations
    /// were not enough.
    pub fn run(
        &mut self,
        system: &impl System<B>,
        tolerance: f64,
        most: usize,
    ) -> Result<bool, PcgError> {
        while self.columns.iter().any(|column| column.works) {
            let late = |c: &Column| c.works && c.iterations >= most;
            if self.columns.iter().any(late) {
                return Ok(false);
            }
            self.turn(system)?;
            self.advance(system, tolerance)?;
        }
        Ok(true)
    }

    /// `Z = M⁻¹ R`, `P ← Z + β P`.
    fn turn(&mut self, system: &impl System<B>) -> Result<(), PcgError> {
        system.cycle(&self.r, &mut self.z);
        let rz = dot(&self.r, &self.z);
        let mut beta = [0.0; B];
        for (k, column) in self.columns.iter_mut().enumerate() {
            if !column.works {
                continue;
            }
            let iteration = column.iterations;
            if !rz[k].is_finite() {
                return Err(not_finite(
                    "the preconditioned residual",
                    iteration,
                    &self.z,
                    k,
                ));
            }
            if rz[k] <= 0.0 && self.r.iter().all(|r| r[k] == 0.0) {
                column.works = false;
            } else if rz[k] <= 0.0 {
                return Err(PcgError::Preconditioner { iteration });
            }
            beta[k] = if column.since == 0 {
                0.0
            } else {
                rz[k] / column.rz
            };
            column.rz = rz[k];
        }
        let works = self.columns.map(|column| column.works);
        let tasks = self.p.chunks_mut(CHUNK).zip(self.z.chunks(CHUNK));
        each(tasks, |(p, z)| {
            for (p, z) in p.iter_mut().zip(z) {
                *p = from_fn(|k| if works[k] { z[k] + beta[k] * p[k] } else { 0.0 });
            }
        });
        Ok(())
    }

    /// `α = rᵀz / pᵀAp`, `X ← X + α P`, `R ← R − α A P`.
    fn advance(&mut self, system: &impl System<B>, tolerance: f64) -> Result<(), PcgError> {
        system.product(&self.p, &mut self.ap);
        let pap = dot(&self.p, &self.ap);
        let mut alpha = [0.0; B];
        for (k, column) in self.columns.iter_mut().enumerate() {
            if !column.works {
                continue;
            }
            let iteration = column.iterations;
            if !pap[k].is_finite() {
                return Err(not_finite("the product A p", iteration, &self.ap, k));
            }
            if pap[k] <= 0.0 {
                let direction: Vec<f64> = self.p.iter().map(|p| p[k]).collect();
                return Err(PcgError::NegativeCurvature {
                    iteration,
                    curvature: pap[k] / dot(&self.p, &self.p)[k],
                    direction,
                });
            }
            alpha[k] = column.rz / pap[k];
            let gain = alpha[k] * column.rz;
            column.energy += gain;
            column.gains[column.since % DELAY] = gain;
            column.since += 1;
            column.iterations += 1;
            column.works = !column.is_done(tolerance);
        }
        let tasks = self.x.chunks_mut(CHUNK).zip(self.r.chunks_mut(CHUNK));
        let tasks = tasks.zip(self.p.chunks(CHUNK).zip(self.ap.chunks(CHUNK)));
        each(tasks, |((x, r), (p, ap))| {
            for ((x, r), (p, ap)) in x.iter_mut().zip(r).zip(p.iter().zip(ap)) {
                for k in 0..B {
                    x[k] += alpha[k] * p[k];
                    r[k] -= alpha[k] * ap[k];
                }
            }
        });
        Ok(())
    }

    /// Takes the residual itself in place of the recurrence's: the largest error that it shows, after
    /// which columns whose residual is worse than their tolerance work on from where they stand. An
    /// energy that overflowed, and a residual that a cycle gives no positive size, measure nothing and
    /// are errors.
    pub fn look(
        &mut self,
        system: &impl System<B>,
        b: &[[f64; B]],
        tolerance: f64,
    ) -> Result<f64, PcgError> {
        system.product(&self.x, &mut self.ap);
        let tasks = self.r.chunks_mut(CHUNK).zip(b.chunks(CHUNK));
        each(tasks.zip(self.ap.chunks(CHUNK)), |((r, b), ap)| {
            for (r, (b, ap)) in r.iter_mut().zip(b.iter().zip(ap)) {
                *r = from_fn(|k| b[k] - ap[k]);
            }
        });
        system.cycle(&self.r, &mut self.z);
        let rz = dot(&self.r, &self.z);
        let mut largest = 0.0_f64;
        for (k, column) in self.columns.iter_mut().enumerate() {
            if !rz[k].is_finite() {
                return Err(not_finite(
                    "the preconditioned residual",
                    column.iterations,
                    &self.z,
                    k,
                ));
            }
            let iteration = column.iterations;
            if !column.energy.is_finite() {
                return Err(not_finite("the energy xᵀAx", iteration, &self.x, k));
            }
            let error = if rz[k] > 0.0 {
                (rz[k] / column.energy).sqrt()
            } else if self.r.iter().all(|r| r[k] == 0.0) {
                0.0
            } else {
                return Err(PcgError::Preconditioner { iteration });
            };
            if error.is_nan() || error > largest {
                largest = error;
            }
            column.works = !(error <= tolerance);
            column.since = 0;
        }
        Ok(largest)
    }
}

fn not_finite<const B: usize>(
    what: &'static str,
    iteration: usize,
    values: &[[f64; B]],
    k: usize,
) -> PcgError {
    let index = values.iter().position(|v| !v[k].is_finite()).unwrap_or(0);
    PcgError::NonFinite {
        iteration,
        what,
        index,
    }
}

/// `aᵀb` of each right-hand side.
fn dot<const B: usize>(a: &[[f64; B]], b: &[[f64; B]]) -> [f64; B] {
    let chunks: Vec<_> = a.chunks(CHUNK).zip(b.chunks(CHUNK)).collect();
    let partial: Vec<[f64; B]> = map(chunks, |(a, b)| {
        // More than one sum in turn, for one alone would wait for itself.
        let mut sums = [[0.0; B]; 4];
        let ((a4, a), (b4, b)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
        for (a, b) in a4.iter().zip(b4) {
            for l in 0..4 {
                for k in 0..B {
                    sums[l][k] += a[l][k] * b[l][k];
                }
            }
        }
        for (a, b) in a.iter().zip(b) {
            for k in 0..B {
                sums[0][k] += a[k] * b[k];
            }
        }
        from_fn(|k| (sums[0][k] + sums[2][k]) + (sums[1][k] + sums[3][k]))
    });
    partial
        .iter()
        .fold([0.0; B], |sum, part| from_fn(|k| sum[k] + part[k]))
}
