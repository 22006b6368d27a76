//! Hessians of problems, padded: what a problem leaves where scalars are absent is nobody's concern.
//! A matrix that its problem has padded is not padded twice: it knows.

use super::problem::NonlinearProblem;
use crate::block_matrix::BlockSymmetric;
use fem_kinematics::HessianProjection;

/// [`NonlinearProblem::hessian`] as solvers may use it.
pub(crate) fn hessian<const D: usize>(
    problem: &(impl NonlinearProblem<D> + ?Sized),
    x: &[f64],
    projection: HessianProjection,
    out: &mut BlockSymmetric<D>,
) {
    problem.hessian(x, projection, out);
    out.fill_padding();
}

/// [`NonlinearProblem::one_sided_hessian`] as solvers may use it.
pub(crate) fn one_sided_hessian<const D: usize>(
    problem: &(impl NonlinearProblem<D> + ?Sized),
    x: &[f64],
    projection: HessianProjection,
    share: f64,
    out: &mut BlockSymmetric<D>,
) {
    problem.one_sided_hessian(x, projection, share, out);
    out.fill_padding();
}
