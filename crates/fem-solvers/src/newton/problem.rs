//! What Newton's method asks of a problem.

use crate::block_matrix::{BlockPattern, BlockSymmetric};
use crate::multigrid::NearKernel;
use crate::operator::LinearOperator;
use fem_kinematics::HessianProjection;
use std::sync::Arc;

/// What a step must lower to be accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Merit {
    /// The energy, of which the gradient is the exact derivative.
    Energy,
    /// The norm of the residual, for fields that are the gradient of no energy.
    ResidualNorm,
}

/// A smooth function of `D · blocks` unknowns to be minimized, or a residual to be brought to zero.
///
/// `x`, `g` and `dx` are node-major: entry `D·i + a` belongs to block `i`. Energies are in J,
/// gradients in N, unknowns in m when the problem is mechanical; the solver assumes no unit.
pub trait NonlinearProblem<const D: usize> {
    /// Number of D×D block rows; the dimension is `D · blocks`.
    fn blocks(&self) -> usize;

    /// Where the Hessian's blocks are, the same for every `x` until [`prepare`](Self::prepare) says
    /// otherwise; `None` for a problem that gives only [products](Self::hessian_vector) with its Hessian.
    /// Entries of `x` whose scalars are [absent](BlockPattern::with_absent) stay as they are.
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        None
    }

    /// `E(x)`; `+∞` outside the domain.
    fn energy(&self, x: &[f64]) -> f64;

    /// `g = ∂E/∂x`, 0 where a scalar is absent; `g` is overwritten.
    fn gradient(&self, x: &[f64], g: &mut [f64]);

    /// `∂²E/∂x²` on [`pattern`](Self::pattern); every stored block of `out` is overwritten. What is
    /// written where scalars are absent does not matter: whoever asks
    /// [pads](BlockSymmetric::fill_padding). Asked of every problem that has a pattern; left out, it is
    /// NaN, which ends a solve.
    fn hessian(&self, _x: &[f64], _projection: HessianProjection, out: &mut BlockSymmetric<D>) {
        out.values_mut().fill([[f64::NAN; D]; D]);
    }

    /// `y = ∂²E/∂x² v` at `x`; `y` is overwritten. Asked of problems without a pattern; left out, the
    /// product of the assembled [`hessian`](Self::hessian), or NaN, which ends a solve.
    fn hessian_vector(&self, x: &[f64], projection: HessianProjection, v: &[f64], y: &mut [f64]) {
        match self.pattern() {
            Some(pattern) => {
                let mut matrix = BlockSymmetric::zeros(pattern);
                self.hessian(x, projection, &mut matrix);
                matrix.fill_padding();
                matrix.apply(v, y);
            }
            None => y.fill(f64::NAN),
        }
    }

    /// Has the energy parts that act on one side of a surface alone, so that their curvature holds for
    /// a part of a step only?
    fn is_one_sided(&self) -> bool {
        false
    }

    /// [`hessian`](Self::hessian) without `share` (0 to 1) of the negative curvature of parts that act on
    /// one side alone, the others projected as asked. Asked of problems that
    /// [are one-sided](Self::is_one_sided) while they are far from a solution.
    fn one_sided_hessian(
        &self,
        x: &[f64],
        projection: HessianProjection,
        _share: f64,
        out: &mut BlockSymmetric<D>,
    ) {
        self.hessian(x, projection, out);
    }

    /// Told before the search along a step from `x` by `dx`. True when the problem has changed: parts
    /// have come in, or left, or the [pattern](Self::pattern) is another.
    fn prepare(&self, _x: &[f64], _dx: &[f64]) -> bool {
        false
    }

    /// One point per block for a geometric ordering, in any unit and of any configuration.
    fn coordinates(&self) -> Option<Vec<[f64; D]>> {
        None
    }

    /// For each unknown the size of the forces that its gradient entry at `x` is the difference of:
    /// `D · blocks` numbers, not negative. One size for all would leave a soft part of a stiff whole
    /// unbalanced, and one from the start would mean nothing when that is far away and could not be met
    /// at the solution. Asked after steps that may be the last.
    fn gradient_scales(&self, _x: &[f64]) -> Option<Vec<f64>> {
        None
    }

    /// What [`gradient_scales`](Self::gradient_scales) exceed nowhere, where that is known without an
    /// evaluation: as long as a gradient is too large even for these, the others are not asked for.
    fn largest_gradient_scales(&self) -> Option<Vec<f64>> {
        None
    }

    /// For each unknown how large its gradient entry at `x` may be from rounding alone, in the unit of
    /// the gradient, where the problem's sums lose more than the rounding of `x` itself explains: a few
    /// `ε` times the sum of absolute terms. A tolerance below rounding ends with
    /// [`StopReason::Rounding`](super::StopReason::Rounding).
    fn gradient_rounding(&self, _x: &[f64]) -> Option<Vec<f64>> {
        None
    }

    /// Vectors that the Hessian at `x` takes to nearly zero where nothing holds, for
    /// [`MultigridDirection`](super::MultigridDirection) and
    /// [`LinearSolver::Auto`](super::LinearSolver::Auto): the translations and rotations of what `x`
    /// places. Left out, a constant for each of the `D` components.
    fn near_kernel(&self, _x: &[f64]) -> NearKernel {
        NearKernel::constants::<D>(self.blocks())
    }

    /// What nothing determines at `x`, where a solve ended, in words that say what to do about it. Asked once,
    /// after a solve that failed, for [`NewtonError::undetermined`](super::NewtonError::undetermined): no
    /// good solve pays for it. `x` may be the start that was refused.
    fn undetermined(&self, _x: &[f64]) -> Option<String> {
        None
    }

    /// What a step must lower.
    fn merit(&self) -> Merit {
        Merit::Energy
    }

    /// Energy and gradient together, where that is cheaper.
    fn energy_and_gradient(&self, x: &[f64], g: &mut [f64]) -> f64 {
        self.gradient(x, g);
        self.energy(x)
    }

    /// The largest `t` for which `x + t dx` is safely inside the domain, 1 or more for a whole step; 0
    /// or NaN refuses the direction.
    fn largest_step(&self, _x: &[f64], _dx: &[f64]) -> f64 {
        1.0
    }
}
