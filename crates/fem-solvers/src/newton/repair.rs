//! The direction of one step: the policy's own, repaired where the tangent is indefinite.

use super::direction::{Descent, DescentDirection, DescentOutcome, NewtonSystem, policy};
use super::factorizer::Factorizer;
use super::padded;
use super::shift::{ShareRule, Shift};
use super::tangent::{Products, Tangent};
use super::{
    HessianProjection, LinearSolver, NewtonFailure, NewtonParams, NonlinearProblem,
    ProjectionPolicy,
};
use crate::block_matrix::BlockSymmetric;
use crate::cholesky::CholeskyError;
use crate::vector::{dot, first_non_finite};
use std::sync::Arc;

/// The last repair adds this share of the largest diagonal entry, then ten times as much, …
const FIRST_LAST_SHIFT: f64 = 1e-9;
/// … this often.
const LAST_SHIFTS: usize = 14;

/// What is kept between steps and between solves.
pub(super) struct Workspace<'d, const D: usize> {
    pub factorizer: Factorizer<D>,
    /// The Hessian assembled last; `None` for problems that give only products.
    pub matrix: Option<BlockSymmetric<D>>,
    /// Share of the diagonal to start the next step with, under
    /// [`ProjectionPolicy::ExactThenShifted`], or of the way to the projected matrix under
    /// [`ProjectionPolicy::ExactThenBlended`]; forgotten between solves.
    pub shift: Shift,
    /// What a projection changes in the matrix, made where it is needed.
    change: Option<BlockSymmetric<D>>,
    /// Is the matrix the exact Hessian of the next step already?
    pub current: bool,
    directions: Directions<'d, D>,
}

/// Where directions come from.
enum Directions<'d, const D: usize> {
    /// Brought by the user.
    Custom(Box<dyn DescentDirection<D> + 'd>),
    /// Made for the linear solver of the settings, and made anew when that changes.
    Setting(Option<(LinearSolver, Box<dyn DescentDirection<D>>)>),
}

impl<const D: usize> Directions<'_, D> {
    fn get(&mut self, solver: LinearSolver) -> &mut dyn DescentDirection<D> {
        match self {
            Self::Custom(custom) => custom.as_mut(),
            Self::Setting(made) => {
                made.take_if(|(of, _)| *of != solver);
                let (_, policy) = made.get_or_insert_with(|| (solver, policy(solver)));
                policy.as_mut()
            }
        }
    }
}

/// A descent direction and what it took.
pub(super) struct Direction {
    pub dx: Vec<f64>,
    pub projection: HessianProjection,
    pub linear_iterations: usize,
    pub factorizations: usize,
    pub shift: f64,
    /// How much of the negative curvature of one-sided parts is left out, 0 to 1.
    pub one_sided: f64,
}

impl Direction {
    /// Is the tangent the exact Hessian?
    pub fn is_exact(&self) -> bool {
        self.projection == HessianProjection::None && self.shift == 0.0 && self.one_sided == 0.0
    }

    /// How much of the projection the tangent has.
    fn share(&self) -> f64 {
        match self.projection {
            HessianProjection::None => 1.0,
            _ if self.shift == 0.0 => 1.0,
            _ => self.shift,
        }
    }

    fn count(&mut self, work: &Descent) {
        self.linear_iterations += work.linear_iterations;
        self.factorizations += work.factorizations;
    }
}

/// The step whose direction is wanted.
struct At<'a, P: ?Sized> {
    problem: &'a P,
    x: &'a [f64],
    g: &'a [f64],
    forcing: f64,
    solver: LinearSolver,
}

impl<'d, const D: usize> Workspace<'d, D> {
    pub fn new(problem: &(impl NonlinearProblem<D> + ?Sized)) -> Self {
        Self {
            factorizer: Factorizer::new(problem.coordinates()),
            matrix: problem.pattern().map(BlockSymmetric::zeros),
            shift: Shift::default(),
            change: None,
            current: false,
            directions: Directions::Setting(None),
        }
    }

    pub fn bring(&mut self, direction: impl DescentDirection<D> + 'd) {
        self.directions = Directions::Custom(Box::new(direction));
    }

    /// What directions remember of earlier systems goes.
    pub fn forget(&mut self) {
        match &mut self.directions {
            Directions::Custom(custom) => custom.forget(),
            Directions::Setting(made) => *made = None,
        }
    }

    /// The same while a solve goes on, if the pattern of the problem is another by now.
    pub fn follow(&mut self, problem: &(impl NonlinearProblem<D> + ?Sized)) {
        let (Some(own), Some(other)) = (&self.matrix, problem.pattern()) else {
            return;
        };
        if !(Arc::ptr_eq(own.pattern(), &other) || **own.pattern() == *other) {
            let shift = self.shift;
            self.renew(problem);
            self.shift = shift;
        }
    }

    /// Another pattern: what was remembered of the old one goes, a direction brought stays.
    pub fn renew(&mut self, problem: &(impl NonlinearProblem<D> + ?Sized)) {
        let directions = std::mem::replace(&mut self.directions, Directions::Setting(None));
        *self = Self::new(problem);
        if matches!(directions, Directions::Custom(_)) {
            self.directions = directions;
        }
    }

    /// A direction `dx` with `K dx ≈ −g` and `gᵀdx < 0`, `‖K dx + g‖ ≤ forcing ‖g‖`.
    pub fn direction<P: NonlinearProblem<D> + ?Sized>(
        &mut self,
        problem: &P,
        x: &[f64],
        g: &[f64],
        forcing: f64,
        params: &NewtonParams,
    ) -> Result<Direction, NewtonFailure> {
        let at = At {
            problem,
            x,
            g,
            forcing,
            solver: params.linear_solver,
        };
        let mut result = Direction {
            dx: vec![0.0; g.len()],
            projection: HessianProjection::None,
            linear_iterations: 0,
            factorizations: 0,
            shift: 0.0,
            one_sided: 0.0,
        };
        let found = match params.projection {
            ProjectionPolicy::ExactFirst => self.staged(&at, EXACT_THEN_CLAMP, &mut result)?,
            ProjectionPolicy::ExactThenAbsolute => {
                self.staged(&at, EXACT_THEN_ABSOLUTE, &mut result)?
            }
            ProjectionPolicy::AlwaysProjected => self.staged(&at, CLAMP, &mut result)?,
            ProjectionPolicy::ExactThenShifted => self.shifted(&at, &mut result)?,
            ProjectionPolicy::ExactThenBlended => self.blended(&at, &mut result)?,
        };
        if !found {
            self.last_shifts(&at, &mut result)?;
        }
        Ok(result)
    }

    /// One tangent after the other, each less exact and more definite; `false` if none will do.
    fn staged<P: NonlinearProblem<D> + ?Sized>(
        &mut self,
        at: &At<'_, P>,
        stages: &[HessianProjection],
        result: &mut Direction,
    ) -> Result<bool, NewtonFailure> {
        for &projection in stages {
            result.projection = projection;
            self.assemble(at, projection)?;
            if self.attempt(at, 0.0, result)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Adds as little of the diagonal as makes the tangent positive definite; `false` if nothing does.
    fn shifted<P: NonlinearProblem<D> + ?Sized>(
        &mut self,
        at: &At<'_, P>,
        result: &mut Direction,
    ) -> Result<bool, NewtonFailure> {
        self.assemble(at, HessianProjection::None)?;
        let weights = self.matrix.as_ref().map(BlockSymmetric::mean_diagonals);
        let scale = self.scale(at, HessianProjection::None);
        let mut added = 0.0;
        for _ in 0..Shift::ATTEMPTS {
            let share = self.shift.share();
            if let (Some(matrix), Some(weights)) = (&mut self.matrix, &weights) {
                matrix.add_to_diagonals(weights, share - added);
            }
            (added, result.shift) = (share, share);
            if self.attempt(at, share * scale, result)? {
                return Ok(true);
            }
            if !self.shift.refused(ShareRule::DIAGONAL) {
                break;
            }
        }
        // Shares of a diagonal that has zeros do not help; what follows starts from the plain matrix.
        self.assemble(at, HessianProjection::None)?;
        result.shift = 0.0;
        Ok(false)
    }

    /// As little of the negative curvature of one-sided parts is left out as makes the tangent positive
    /// definite; then it goes as little of the way to the projected one as that takes; `false` if not
    /// even that is.
    fn blended<P: NonlinearProblem<D> + ?Sized>(
        &mut self,
        at: &At<'_, P>,
        result: &mut Direction,
    ) -> Result<bool, NewtonFailure> {
        let has_sides = self.matrix.is_some() && at.problem.is_one_sided();
        let known = self.shift.share() > 0.0;
        loop {
            result.one_sided = match (has_sides, known) {
                (false, _) => 0.0,
                (true, false) => self.shift.one_sided(),
                (true, true) => 1.0,
            };
            self.assemble_one_sided(at, result.one_sided)?;
            if known {
                break;
            }
            if self.attempt(at, 0.0, result)? {
                return Ok(true);
            }
            if !(has_sides && self.shift.refused_one_sided()) {
                break;
            }
        }
        if !known {
            self.shift.refused(ShareRule::PROJECTION);
        }
        result.projection = HessianProjection::Absolute;
        if let Some(matrix) = &self.matrix {
            let change = self.change.get_or_insert_with(|| matrix.clone());
            match has_sides {
                true => {
                    padded::one_sided_hessian(at.problem, at.x, result.projection, 1.0, change);
                }
                false => padded::hessian(at.problem, at.x, result.projection, change),
            }
            change.add_scaled(-1.0, matrix);
        }
        let mut added = 0.0;
        for _ in 0..Shift::ATTEMPTS {
            let share = self.shift.share();
            if let (Some(matrix), Some(change)) = (&mut self.matrix, &self.change) {
                matrix.add_scaled(share - added, change);
            }
            (added, result.shift) = (share, share);
            if self.attempt(at, 0.0, result)? {
                return Ok(true);
            }
            if !self.shift.refused(ShareRule::PROJECTION) {
                break;
            }
        }
        result.shift = 0.0;
        Ok(false)
    }

    /// A projected tangent can still be singular: adds to its diagonal until it is not.
    fn last_shifts<P: NonlinearProblem<D> + ?Sized>(
        &mut self,
        at: &At<'_, P>,
        result: &mut Direction,
    ) -> Result<(), NewtonFailure> {
        let scale = self.scale(at, result.projection);
        let mut shift = FIRST_LAST_SHIFT * if scale > 0.0 { scale } else { 1.0 };
        let (mut added, mut block_row) = (0.0, None);
        for _ in 0..LAST_SHIFTS {
            let found = match &mut self.matrix {
                Some(matrix) => {
                    matrix.shift_diagonal(shift - added);
                    self.factored(at, result, &mut block_row)?
                }
                None => self.attempt(at, shift, result)?,
            };
            if found {
                return Ok(());
            }
            added = shift;
            shift *= 10.0;
        }
        Err(NewtonFailure::Indefinite {
            shift: added,
            block_row,
        })
    }

    /// The size of the diagonal, or what stands for it where there is no matrix.
    fn scale<P: NonlinearProblem<D> + ?Sized>(
        &self,
        at: &At<'_, P>,
        projection: HessianProjection,
    ) -> f64 {
        match &self.matrix {
            Some(matrix) => {
                let diagonal = matrix.diagonal();
                diagonal.iter().fold(0.0_f64, |m, v| m.max(v.abs()))
            }
            None => at.products(projection, 1.0, 0.0).curvature_along(at.g),
        }
    }

    fn assemble<P: NonlinearProblem<D> + ?Sized>(
        &mut self,
        at: &At<'_, P>,
        projection: HessianProjection,
    ) -> Result<(), NewtonFailure> {
        let Some(matrix) = &mut self.matrix else {
            return Ok(());
        };
        let current = std::mem::take(&mut self.current);
        if !(current && projection == HessianProjection::None) {
            padded::hessian(at.problem, at.x, projection, matrix);
        }
        self.check_finite()
    }

    /// The exact tangent without this share of the negative curvature of one-sided parts.
    fn assemble_one_sided<P: NonlinearProblem<D> + ?Sized>(
        &mut self,
        at: &At<'_, P>,
        share: f64,
    ) -> Result<(), NewtonFailure> {
        if share == 0.0 {
            return self.assemble(at, HessianProjection::None);
        }
        if let Some(matrix) = &mut self.matrix {
            self.current = false;
            let exact = HessianProjection::None;
            padded::one_sided_hessian(at.problem, at.x, exact, share, matrix);
        }
        self.check_finite()
    }

    fn check_finite(&self) -> Result<(), NewtonFailure> {
        let Some(matrix) = &self.matrix else {
            return Ok(());
        };
        let finite = |b: &[[f64; D]; D]| b.iter().flatten().all(|v| v.is_finite());
        match matrix.values().iter().position(|b| !finite(b)) {
            None => Ok(()),
            Some(index) => Err(NewtonFailure::NonFinite {
                what: "the Hessian (stored block)",
                index,
            }),
        }
    }

    /// One linear solve with the tangent as it stands; `false` when it is not positive definite.
    /// `added` is on the diagonal of the matrix already, and is added to products.
    fn attempt<P: NonlinearProblem<D> + ?Sized>(
        &mut self,
        at: &At<'_, P>,
        added: f64,
        result: &mut Direction,
    ) -> Result<bool, NewtonFailure> {
        let products = at.products(result.projection, result.share(), added);
        let tangent = match &self.matrix {
            Some(matrix) => Tangent::from_matrix(matrix),
            None => Tangent::from_products(&products),
        };
        let near_kernel = || at.problem.near_kernel(at.x);
        let mut system = NewtonSystem {
            tangent,
            at: at.x,
            gradient: at.g,
            forcing: at.forcing,
            near_kernel: &near_kernel,
            factorizer: &mut self.factorizer,
        };
        result.dx.fill(0.0);
        let direction = self.directions.get(at.solver);
        let mut found = direction.direction(&mut system, &mut result.dx)?;
        if found.outcome == DescentOutcome::TooSlow && tangent.matrix().is_some() {
            found = system.solve_directly(&mut result.dx)?.after(found);
        }
        result.count(&found);
        Ok(found.outcome != DescentOutcome::Indefinite && descends(&result.dx, at.g))
    }

    /// A factorization of the matrix as it stands, whatever the policy.
    fn factored<P: ?Sized>(
        &mut self,
        at: &At<'_, P>,
        result: &mut Direction,
        refused: &mut Option<usize>,
    ) -> Result<bool, NewtonFailure> {
        let Some(matrix) = &self.matrix else {
            return Err(NewtonFailure::NeedsMatrix);
        };
        result.factorizations += 1;
        match self.factorizer.factor(matrix) {
            Ok(factor) => {
                result.dx = at.g.iter().map(|g| -g).collect();
                factor.solve_in_place(&mut result.dx);
                Ok(descends(&result.dx, at.g))
            }
            Err(CholeskyError::NotPositiveDefinite { block_row, .. }) => {
                *refused = Some(block_row);
                Ok(false)
            }
            Err(error) => Err(error.into()),
        }
    }
}

const EXACT_THEN_CLAMP: &[HessianProjection] = &[HessianProjection::None, HessianProjection::Clamp];
const EXACT_THEN_ABSOLUTE: &[HessianProjection] =
    &[HessianProjection::None, HessianProjection::Absolute];
const CLAMP: &[HessianProjection] = &[HessianProjection::Clamp];

impl<'a, P: ?Sized> At<'a, P> {
    fn products<const D: usize>(
        &self,
        projection: HessianProjection,
        share: f64,
        added: f64,
    ) -> Products<'a, P, D> {
        Products {
            problem: self.problem,
            x: self.x,
            projection,
            share,
            added,
        }
    }
}

/// Finite and downhill: `gᵀdx < 0`.
fn descends(dx: &[f64], g: &[f64]) -> bool {
    first_non_finite(dx).is_none() && dot(dx, g) < 0.0
}
