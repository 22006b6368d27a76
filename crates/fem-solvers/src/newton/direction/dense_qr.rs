//! [`LinearSolver::QrLeastSquares`](crate::LinearSolver): dense QR (document 000, section 5.1).

use super::{Descent, DescentDirection, DescentOutcome, NewtonSystem};
use crate::dense_qr::PivotedQr;
use crate::newton::{LinearSolver, NewtonFailure};

/// The least-squares solution, for matrices that may be singular.
pub(super) struct DenseQr;

impl<const D: usize> DescentDirection<D> for DenseQr {
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let n = dx.len();
        if n > LinearSolver::LARGEST_QR {
            return Err(NewtonFailure::TooLargeForQr {
                found: n,
                limit: LinearSolver::LARGEST_QR,
            });
        }
        let matrix = system.tangent.assembled()?.to_dense();
        let solution = PivotedQr::new(matrix, n, n).least_squares(&system.right_hand_side());
        dx.copy_from_slice(&solution);
        Ok(Descent::factored(DescentOutcome::Found))
    }
}
