//! Which linear solver [`LinearSolver::Auto`] ends with, by what its steps took.

use crate::promise::{Newton, kept};
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, Quasistatic};
use fem_materials::NeoHookean;
use fem_solvers::{
    BlockPattern, BlockSymmetric, HessianProjection, LinearSolver, MultigridDirection, NearKernel,
    NewtonInfo, NewtonParams, NonlinearProblem, PreconditionerChoice, SymbolicCholesky,
};
use std::ops::DerefMut;
use std::sync::Arc;

const LENGTH: f64 = 4.0;
const INCOMPLETE: LinearSolver = LinearSolver::Pcg {
    preconditioner: PreconditionerChoice::BlockIc0,
    max_iterations: 5_000,
};

fn bend([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x + 0.3 / LENGTH * z * z, y, z]
}

fn twist([x, y, z]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = (z / LENGTH * std::f64::consts::FRAC_PI_3).sin_cos();
    let (x, y) = (x - 0.5, y - 0.5);
    [0.5 + cos * x - sin * y, 0.5 + sin * x + cos * y, 1.1 * z]
}

/// n × n × 4n cubes.
struct Bar {
    assembly: Assembly<3>,
    start: Vec<[f64; 3]>,
}

impl Bar {
    fn new(n: usize, bent: bool) -> Self {
        let mesh = kuhn_grid(n, n, 4 * n, [1.0, 1.0, LENGTH]).unwrap();
        let at = |z: f64| {
            let there = |k: &usize| (mesh.nodes()[*k][2] - z).abs() < 1e-9;
            (0..mesh.nodes().len()).filter(there).collect::<Vec<_>>()
        };
        let (lower, upper) = (at(0.0), at(LENGTH));
        let dofs = if bent {
            let aside: Vec<(usize, usize)> = upper.iter().map(|&k| (k, 0)).collect();
            Dofs::new(mesh.nodes(), &lower, &aside)
        } else {
            Dofs::with_prescribed_nodes(mesh.nodes(), &[lower, upper].concat())
        };
        let place = if bent { bend } else { twist };
        let flesh = NeoHookean {
            mu: 3.4e4,
            lambda: 3.1e5,
        };
        let builder = AssemblyBuilder::new(&mesh, dofs.unwrap()).unwrap();
        Self {
            assembly: builder.material(flesh).unwrap().build().unwrap(),
            start: mesh.nodes().iter().map(|&p| place(p)).collect(),
        }
    }

    fn problem(&self) -> Quasistatic<'_, 3> {
        Quasistatic::new(&self.assembly, self.start.clone(), vec![]).unwrap()
    }

    fn solve(&self, linear_solver: LinearSolver) -> NewtonInfo {
        let problem = self.problem();
        let settings = settings(linear_solver);
        Newton::new(&problem)
            .solve(&problem, &mut problem.unknowns(), &settings)
            .unwrap()
    }
}

fn settings(linear_solver: LinearSolver) -> NewtonParams {
    NewtonParams {
        relative_gradient_tolerance: 1e-8,
        linear_solver,
        ..NewtonParams::default()
    }
}

/// A bent bar takes an incomplete factor 80 iterations for each digit, a hierarchy 10.
#[test]
fn a_bent_bar_goes_on_by_multigrid() {
    let bar = Bar::new(12, true);
    let (auto, incomplete) = (bar.solve(LinearSolver::Auto), bar.solve(INCOMPLETE));
    assert_eq!((auto.factorizations, incomplete.factorizations), (0, 0));
    let (few, many) = (auto.linear_iterations, incomplete.linear_iterations);
    assert!(few + 150 < many, "{few} of {many}");
    assert!((auto.energy - incomplete.energy).abs() < 1e-9 * incomplete.energy);
}

/// A twisted one takes it 40: less than a hierarchy costs.
#[test]
fn a_twisted_bar_keeps_its_incomplete_factor() {
    let bar = Bar::new(18, false);
    let symbolic = SymbolicCholesky::new(&bar.problem().pattern().unwrap());
    assert!(MultigridDirection::<3, 6>::is_cheaper_than(&symbolic, 1.0));
    let (auto, incomplete) = (bar.solve(LinearSolver::Auto), bar.solve(INCOMPLETE));
    assert_eq!((auto.factorizations, incomplete.factorizations), (0, 0));
    assert_eq!(auto.linear_iterations, incomplete.linear_iterations);
    assert_eq!(auto.energy, incomplete.energy);
}

/// A problem with another near kernel.
struct Near<'a>(Quasistatic<'a, 3>, fn(usize) -> NearKernel);

impl NonlinearProblem<3> for Near<'_> {
    fn blocks(&self) -> usize {
        self.0.blocks()
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        self.0.pattern()
    }
    fn energy(&self, x: &[f64]) -> f64 {
        self.0.energy(x)
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        self.0.gradient(x, g);
    }
    fn hessian(&self, x: &[f64], projection: HessianProjection, out: &mut BlockSymmetric<3>) {
        self.0.hessian(x, projection, out);
    }
    fn largest_step(&self, x: &[f64], dx: &[f64]) -> f64 {
        self.0.largest_step(x, dx)
    }
    fn near_kernel(&self, _x: &[f64]) -> NearKernel {
        self.1(self.0.blocks())
    }
}

/// A near kernel of the wrong length is met when a hierarchy is to be made of it, constants are no body's:
/// a factor takes over.
#[test]
fn a_near_kernel_of_no_body_ends_no_solve() {
    let bar = Bar::new(12, true);
    let solve = |near: fn(usize) -> NearKernel, linear_solver| {
        let (problem, mut x) = (Near(bar.problem(), near), bar.problem().unknowns());
        let settings = NewtonParams {
            relative_gradient_tolerance: 1e-11,
            ..settings(linear_solver)
        };
        let mut newton = Newton::new(&problem.0);
        let info = newton.deref_mut().solve(&problem, &mut x, &settings);
        let info = info.unwrap();
        kept(&problem.0, &x, &settings, info.stop);
        info
    };
    let expected = solve(NearKernel::constants::<3>, INCOMPLETE).energy;
    let short: fn(usize) -> NearKernel = |_| NearKernel::new(vec![vec![1.0]; 6]);
    for near in [short, NearKernel::constants::<3>] {
        let info = solve(near, LinearSolver::Auto);
        assert!(info.factorizations > 0, "{info:?}");
        assert!((info.energy - expected).abs() < 1e-9 * expected);
    }
}
