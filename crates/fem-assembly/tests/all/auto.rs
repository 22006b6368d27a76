//! Which linear solver [`LinearSolver::Auto`] ends with, by what its steps took.

use crate::promise::Newton;
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, Quasistatic};
use fem_materials::NeoHookean;
use fem_solvers::{LinearSolver, NewtonInfo, NewtonParams, PreconditionerChoice};

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

    fn solve(&self, linear_solver: LinearSolver) -> NewtonInfo {
        let problem = Quasistatic::new(&self.assembly, self.start.clone(), vec![]).unwrap();
        let settings = NewtonParams {
            relative_gradient_tolerance: 1e-8,
            linear_solver,
            ..NewtonParams::default()
        };
        Newton::new(&problem)
            .solve(&problem, &mut problem.unknowns(), &settings)
            .unwrap()
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
    let bar = Bar::new(10, false);
    let (auto, incomplete) = (bar.solve(LinearSolver::Auto), bar.solve(INCOMPLETE));
    assert_eq!((auto.factorizations, incomplete.factorizations), (0, 0));
    assert_eq!(auto.linear_iterations, incomplete.linear_iterations);
    assert_eq!(auto.energy, incomplete.energy);
}
