//! What an iterative solver needs to know of a matrix and of a preconditioner.

/// What the maker of an operator vouches for. Solvers insist on it instead of guessing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Structure {
    /// Nothing is known.
    General,
    /// `A = Aᵀ`, of any signature.
    Symmetric,
    /// `A = Aᵀ` and `xᵀAx ≥ 0`; a null space is allowed.
    SymmetricPositiveSemidefinite,
    /// `A = Aᵀ` and `xᵀAx > 0` for every `x ≠ 0`.
    SymmetricPositiveDefinite,
}

/// A square linear map `y = A x` on slices; the matrix itself need not exist.
pub trait LinearOperator {
    /// Number of rows, which is the number of columns.
    fn dim(&self) -> usize;
    /// What the operator claims to be.
    fn structure(&self) -> Structure;
    /// `y = A x`. Both slices have length [`dim`](Self::dim); `y` is overwritten.
    fn apply(&self, x: &[f64], y: &mut [f64]);
}

/// An approximate inverse `z ≈ A⁻¹ r`, symmetric positive definite.
pub trait Preconditioner {
    /// `z = M⁻¹ r`. Both slices have the operator's length; `z` is overwritten.
    fn apply(&self, r: &[f64], z: &mut [f64]);
}

/// A preconditioner that follows the matrix of a sequence of systems and may keep from one to the
/// next what still serves: memory, a pattern's analysis, a factor that is nearly right.
pub trait MatrixPreconditioner<const D: usize>: Preconditioner {
    /// Makes it fit `matrix`; called before each solve.
    ///
    /// # Errors
    /// [`PreconditionerError`](crate::PreconditionerError) when none can be made.
    fn update(
        &mut self,
        matrix: &crate::BlockSymmetric<D>,
    ) -> Result<(), crate::PreconditionerError>;

    /// The same for an operator that is only known by its products.
    ///
    /// # Errors
    /// [`PreconditionerError::NeedsMatrix`](crate::PreconditionerError) unless overridden.
    fn update_products(
        &mut self,
        _operator: &dyn LinearOperator,
    ) -> Result<(), crate::PreconditionerError> {
        Err(crate::PreconditionerError::NeedsMatrix)
    }
}

/// An operator taken for positive definite on trust.
///
/// Conjugate gradients notice when the trust was misplaced: the first direction of negative
/// curvature ends the solve with [`PcgError::NegativeCurvature`](crate::PcgError). Newton's method
/// uses this to try a plain Hessian before a projected one.
#[derive(Clone, Copy, Debug)]
pub struct AssumedPositiveDefinite<'a, A: ?Sized>(pub &'a A);

impl<A: LinearOperator + ?Sized> LinearOperator for AssumedPositiveDefinite<'_, A> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn structure(&self) -> Structure {
        match self.0.structure() {
            Structure::General => Structure::General,
            _ => Structure::SymmetricPositiveDefinite,
        }
    }
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.0.apply(x, y);
    }
}

impl<A: LinearOperator + ?Sized> LinearOperator for &A {
    fn dim(&self) -> usize {
        (**self).dim()
    }
    fn structure(&self) -> Structure {
        (**self).structure()
    }
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        (**self).apply(x, y);
    }
}

impl<P: Preconditioner + ?Sized> Preconditioner for &P {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        (**self).apply(r, z);
    }
}
