//! One level: its matrix, its smoother, and the way to the next.

use super::aggregation::{Aggregates, aggregate};
use super::entry::Entry;
use super::galerkin::Galerkin;
use super::hierarchy::MultigridParams;
use super::matrix::LevelMatrix;
use super::precision::LevelScalar;
use super::prolongator::Prolongator;
use super::rows::Rows;
use super::smoother::Smoother;
use super::spectrum::largest_eigenvalue;
use super::tentative::Tentative;
use crate::block_matrix::BlockSymmetric;
use crate::preconditioner::PreconditionerError;

/// Damping of the step that smooths the prolongator, in shares of the largest eigenvalue.
const DAMPING: f64 = 4.0 / 3.0;
#[derive(Clone, Debug)]
pub(super) struct Level<T, const D: usize, const K: usize> {
    pub matrix: LevelMatrix<T, D>,
    smoother: Smoother,
    pub aggregates: Aggregates,
    pub prolongator: Prolongator<T, D, K>,
    galerkin: Galerkin,
    pub coarse: BlockSymmetric<K>,
}

impl<T: LevelScalar, const D: usize, const K: usize> Level<T, D, K> {
    pub fn new(
        matrix: &BlockSymmetric<D>,
        params: &MultigridParams,
    ) -> Result<Self, PreconditionerError> {
        let rows = Rows::new(matrix.pattern());
        let aggregates = aggregate(&rows, matrix, params.strength);
        let prolongator = Prolongator::new(&rows, &aggregates);
        let galerkin = Galerkin::new(&rows, &prolongator)?;
        let coarse = BlockSymmetric::zeros(galerkin.coarse.clone());
        Ok(Self {
            matrix: LevelMatrix::new(rows),
            smoother: Smoother {
                degree: params.smoothing_degree,
                largest: 1.0,
            },
            aggregates,
            prolongator,
            galerkin,
            coarse,
        })
    }

    /// New values; the near kernel of the coarse matrix.
    pub fn update(
        &mut self,
        level: usize,
        scale: f64,
        matrix: &BlockSymmetric<D>,
        kernel: &[[[f64; K]; D]],
    ) -> Result<Vec<[[f64; K]; K]>, PreconditionerError> {
        self.matrix.update(matrix, scale)?;
        let largest = largest_eigenvalue(&self.matrix)
            .ok_or(PreconditionerError::NegativeCurvature { level })?;
        self.smoother.largest = largest;
        let rows = &self.matrix.rows;
        let tentative = Tentative::new(&self.aggregates, kernel);
        let omega = DAMPING / largest;
        self.prolongator
            .smooth(rows, matrix, &self.aggregates, &tentative, omega);
        self.galerkin.multiply(
            rows,
            matrix,
            &self.prolongator,
            &tentative,
            &mut self.coarse,
        );
        Ok(tentative.coarse)
    }

    /// One V-cycle for `A x = b`: `b` is overwritten, `x` starts from zero.
    pub fn cycle<V: Entry<T>>(
        &self,
        b: &mut [[V; D]],
        correct: impl FnOnce(&mut [[V; K]], &mut [[V; K]]),
    ) -> Vec<[V; D]> {
        let zero = [V::default(); D];
        let n = b.len();
        let (mut x, mut z, mut spare) = (vec![zero; n], vec![zero; n], vec![zero; n]);
        self.smoother
            .smooth(&self.matrix, b, &mut x, &mut z, &mut spare);
        self.matrix.subtract_product(&z, b);
        let m = self.prolongator.coarse_rows();
        let mut coarse = vec![[V::default(); K]; m];
        let mut correction = coarse.clone();
        self.prolongator.restrict(b, &mut coarse);
        correct(&mut coarse, &mut correction);
        self.prolongator.prolong(&correction, &mut z);
        self.matrix.subtract_product(&z, b);
        for (x, z) in x.iter_mut().zip(&z) {
            for c in 0..D {
                x[c] += z[c];
            }
        }
        self.smoother
            .smooth(&self.matrix, b, &mut x, &mut z, &mut spare);
        x
    }
}
