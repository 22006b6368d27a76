//! The Hessian at one point: a linear operator, optionally assembled.

use super::{HessianProjection, NewtonFailure, NonlinearProblem};
use crate::block_matrix::BlockSymmetric;
use crate::operator::{LinearOperator, Structure};
use crate::vector::dot;

/// The Hessian, or what a [`ProjectionPolicy`](super::ProjectionPolicy) makes of it, at one point.
#[derive(Clone, Copy)]
pub struct Tangent<'a, const D: usize> {
    operator: &'a dyn LinearOperator,
    matrix: Option<&'a BlockSymmetric<D>>,
}

impl<'a, const D: usize> Tangent<'a, D> {
    /// A tangent that is a matrix.
    pub fn from_matrix(matrix: &'a BlockSymmetric<D>) -> Self {
        Self {
            operator: matrix,
            matrix: Some(matrix),
        }
    }

    /// A tangent that is only known by its products.
    pub fn from_products(operator: &'a dyn LinearOperator) -> Self {
        Self {
            operator,
            matrix: None,
        }
    }

    /// The matrix, where there is one.
    pub fn matrix(&self) -> Option<&'a BlockSymmetric<D>> {
        self.matrix
    }

    pub(super) fn assembled(&self) -> Result<&'a BlockSymmetric<D>, NewtonFailure> {
        self.matrix.ok_or(NewtonFailure::NeedsMatrix)
    }
}

impl<const D: usize> LinearOperator for Tangent<'_, D> {
    fn dim(&self) -> usize {
        self.operator.dim()
    }
    fn structure(&self) -> Structure {
        self.operator.structure()
    }
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.operator.apply(x, y);
    }
}

/// `(1 − share) K + share K⁺ + added · I` at `x` with the Hessian K and its projection K⁺, by the
/// problem's own products.
pub(super) struct Products<'a, P: ?Sized, const D: usize> {
    pub problem: &'a P,
    pub x: &'a [f64],
    pub projection: HessianProjection,
    pub share: f64,
    pub added: f64,
}

impl<P: NonlinearProblem<D> + ?Sized, const D: usize> Products<'_, P, D> {
    /// `|gᵀ K g| / gᵀ g`: it stands for the diagonal that an operator without a matrix does not show.
    pub fn curvature_along(&self, g: &[f64]) -> f64 {
        let mut product = vec![0.0; g.len()];
        self.apply(g, &mut product);
        (dot(g, &product) / dot(g, g)).abs()
    }
}

impl<P: NonlinearProblem<D> + ?Sized, const D: usize> LinearOperator for Products<'_, P, D> {
    fn dim(&self) -> usize {
        self.x.len()
    }
    fn structure(&self) -> Structure {
        Structure::Symmetric
    }
    fn apply(&self, v: &[f64], y: &mut [f64]) {
        self.problem.hessian_vector(self.x, self.projection, v, y);
        if self.share != 1.0 {
            let mut exact = vec![0.0; v.len()];
            let none = HessianProjection::None;
            self.problem.hessian_vector(self.x, none, v, &mut exact);
            for (y, exact) in y.iter_mut().zip(exact) {
                *y = self.share * *y + (1.0 - self.share) * exact;
            }
        }
        if self.added != 0.0 {
            for (y, v) in y.iter_mut().zip(v) {
                *y += self.added * v;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{HessianProjection, LinearOperator, NonlinearProblem, Products};

    /// K = diag(2, −3), and with its negative part turned around diag(2, 3).
    struct Saddle;

    impl NonlinearProblem<1> for Saddle {
        fn blocks(&self) -> usize {
            2
        }
        fn energy(&self, x: &[f64]) -> f64 {
            x[0] * x[0] - 1.5 * x[1] * x[1]
        }
        fn gradient(&self, x: &[f64], g: &mut [f64]) {
            g.copy_from_slice(&[2.0 * x[0], -3.0 * x[1]]);
        }
        fn hessian_vector(
            &self,
            _: &[f64],
            projection: HessianProjection,
            v: &[f64],
            y: &mut [f64],
        ) {
            let second: f64 = projection.eigenvalue(-3.0);
            y.copy_from_slice(&[2.0 * v[0], second * v[1]]);
        }
    }

    #[test]
    fn products_are_those_of_the_blend() {
        for (share, added) in [(0.0, 0.0), (0.25, 0.0), (1.0, 0.0), (0.5, 7.0)] {
            let products: Products<'_, Saddle, 1> = Products {
                problem: &Saddle,
                x: &[0.0; 2],
                projection: HessianProjection::Absolute,
                share,
                added,
            };
            let mut y = [0.0; 2];
            products.apply(&[1.0, 2.0], &mut y);
            let second = (1.0 - share) * -3.0 + share * 3.0 + added;
            assert_eq!(y, [2.0 + added, 2.0 * second], "{share} {added}");
            // |gᵀ K g|/gᵀ g
            let along = (2.0 + added + 4.0 * second) / 5.0;
            assert!((products.curvature_along(&[1.0, 2.0]) - along.abs()).abs() < 1e-15);
        }
    }
}
