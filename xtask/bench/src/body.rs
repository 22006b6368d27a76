//! Bodies in equilibrium: what is solved, how, and what it cost.

use crate::curve::Point;
use crate::failure::Failure;
use crate::timing::{Timed, fastest};
use fem_assembly::{Assembly, Quasistatic};
use fem_solvers::{
    LinearSolver, MultigridDirection, MultigridParams, Newton, NewtonInfo, NewtonParams,
    PreconditionerChoice, StopReason,
};

/// A body, where its solve begins, and what its energy is given.
pub struct Body {
    /// All terms of its energy.
    pub assembly: Assembly<3>,
    /// Where the nodes start; prescribed ones are where they shall be, m.
    pub start: Vec<[f64; 3]>,
    /// Activations, pressures.
    pub controls: Vec<f64>,
}

/// Where its linear systems are solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Linear {
    /// By one of Newton's own solvers.
    By(LinearSolver),
    /// By conjugate gradients on a multigrid hierarchy.
    Multigrid,
}

/// Iterations of conjugate gradients before a factorization takes over.
const MOST_ITERATIONS: usize = 2_000;

/// Every way to solve a linear system that pays for more than a few unknowns, by name.
pub const LINEAR: [(&str, Linear); 6] = [
    ("direct f64", Linear::By(LinearSolver::Direct)),
    (
        "direct f32, refined",
        Linear::By(LinearSolver::DirectSingle),
    ),
    (
        "conjugate gradients, IC(0)",
        pcg(PreconditionerChoice::BlockIc0),
    ),
    (
        "conjugate gradients, Jacobi",
        pcg(PreconditionerChoice::BlockJacobi),
    ),
    ("multigrid f32 in f64", Linear::Multigrid),
    ("by itself (auto)", Linear::By(LinearSolver::Auto)),
];

const fn pcg(preconditioner: PreconditionerChoice) -> Linear {
    Linear::By(LinearSolver::Pcg {
        preconditioner,
        max_iterations: MOST_ITERATIONS,
    })
}

/// An equilibrium.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// Positions of all nodes, m.
    pub positions: Vec<[f64; 3]>,
    /// What Newton's method says.
    pub info: NewtonInfo,
}

/// Newton's method down to this share of the forces.
pub fn to(tolerance: f64) -> NewtonParams {
    NewtonParams {
        relative_gradient_tolerance: tolerance,
        max_iterations: 200,
        ..NewtonParams::default()
    }
}

impl Body {
    /// Solves once, and trusts no `Ok`: the forces that are left are summed again.
    ///
    /// # Errors
    /// If it does not converge, or promises more than it holds.
    pub fn solve(&self, linear: Linear, params: &NewtonParams) -> Result<Equilibrium, Failure> {
        let found = self.solve_alone(linear, params)?;
        self.check(&found, params)?;
        Ok(found)
    }

    fn check(&self, found: &Equilibrium, params: &NewtonParams) -> Result<(), Failure> {
        let (x, controls) = (found.positions.clone(), self.controls.clone());
        kept(&self.assembly, x, controls, params, found.info.stop)
    }

    /// What is timed or counted: solves once; analysis and hierarchy of the linear solver included.
    ///
    /// # Errors
    /// If it does not converge.
    pub fn solve_alone(
        &self,
        linear: Linear,
        params: &NewtonParams,
    ) -> Result<Equilibrium, Failure> {
        let problem = Quasistatic::new(&self.assembly, self.start.clone(), self.controls.clone())?;
        let mut x = problem.unknowns();
        let info = match linear {
            Linear::By(linear_solver) => {
                let params = NewtonParams {
                    linear_solver,
                    ..*params
                };
                Newton::new(&problem).solve(&problem, &mut x, &params)?
            }
            Linear::Multigrid => {
                let direction = MultigridDirection::<3, 6>::new(MultigridParams::default());
                Newton::with_direction(&problem, direction).solve(&problem, &mut x, params)?
            }
        };
        Ok(Equilibrium {
            positions: problem.positions(&x)?,
            info,
        })
    }

    /// The same, several times; what the last one found is checked.
    ///
    /// # Errors
    /// As [`Body::solve`].
    pub fn timed(
        &self,
        repetitions: usize,
        linear: Linear,
        params: &NewtonParams,
    ) -> Result<Timed<Equilibrium>, Failure> {
        let timed = fastest(repetitions, || self.solve_alone(linear, params))?;
        self.check(&timed.value, params)?;
        Ok(timed)
    }

    /// A point of a curve.
    pub fn point(
        &self,
        setting: impl Into<String>,
        solved: &Timed<Equilibrium>,
        error: f64,
    ) -> Point {
        let info = &solved.value.info;
        Point {
            setting: setting.into(),
            error,
            seconds: solved.seconds,
            unknowns: self.assembly.dofs().unknowns(),
            steps: info.iterations,
            factorizations: info.factorizations,
            iterations: info.linear_iterations,
            memory: solved.memory,
        }
    }
}

/// Sums the forces that are left node by node, and holds them to what the solver's stop promises.
///
/// # Errors
/// Where more is left, or lists do not fit.
pub fn kept(
    assembly: &Assembly<3>,
    positions: Vec<[f64; 3]>,
    controls: Vec<f64>,
    params: &NewtonParams,
    stop: StopReason,
) -> Result<(), Failure> {
    let forces = assembly.forces_everywhere(assembly.configuration(&positions, &controls)?);
    let problem = Quasistatic::new(assembly, positions, controls)?;
    let x = problem.unknowns();
    let found = stress::kept(&problem, &x, &forces, params, stop);
    let found = found.map_err(|e| Failure::Failed(e.message.into()))?;
    match found.left <= found.allowed {
        true => Ok(()),
        false => Err(Failure::Failed(
            format!(
                "a solve that ends with {stop:?} promises {:e} N, and leaves {:e} N",
                found.allowed, found.left
            )
            .into(),
        )),
    }
}

/// Solves as `auto` does.
pub const AUTO: Linear = Linear::By(LinearSolver::Auto);
/// Solves by a factor in `f64`.
pub const DIRECT: Linear = Linear::By(LinearSolver::Direct);

/// The largest distance between nodes of the same number, m; NaN where one is, and for lists of
/// different lengths.
pub fn apart(x: &[[f64; 3]], y: &[[f64; 3]]) -> f64 {
    if x.len() != y.len() {
        return f64::NAN;
    }
    let distance = |(a, b): (&[f64; 3], &[f64; 3])| workbench::numbers::distance(a, b);
    x.iter()
        .zip(y)
        .map(distance)
        .fold(0.0, workbench::numbers::worse)
}
