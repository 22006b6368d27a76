//! Rigid motions as the near kernel of a stiffness, and Newton's method on a multigrid hierarchy.

use crate::promise::Newton;
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, Quasistatic};
use fem_materials::NeoHookean;
use fem_solvers::{
    BlockSymmetric, HessianProjection, LinearOperator, LinearSolver, MultigridDirection,
    MultigridParams, NewtonFailure, NewtonParams, NonlinearProblem,
};

const FLESH: NeoHookean = NeoHookean {
    mu: 3e4,
    lambda: 2e5,
};

/// n × n × 4n cubes; its ends are prescribed.
fn bar(n: usize) -> Assembly<3> {
    let mesh = kuhn_grid(n, n, 4 * n, [0.1, 0.1, 0.4]).unwrap();
    let prescribed: Vec<usize> = (0..mesh.nodes().len())
        .filter(|&k| mesh.nodes()[k][2] == 0.0 || mesh.nodes()[k][2] > 0.4 - 1e-9)
        .collect();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed).unwrap();
    built(AssemblyBuilder::new(&mesh, dofs).unwrap())
}

fn built(builder: AssemblyBuilder<3>) -> Assembly<3> {
    builder.material(FLESH).unwrap().build().unwrap()
}

/// Its far end turned by 60° and drawn out by a tenth, what is between in proportion.
fn twisted(rest: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let turn = |&[x, y, z]: &[f64; 3]| {
        let (sin, cos) = (z / 0.4 * std::f64::consts::FRAC_PI_3).sin_cos();
        let (x, y) = (x - 0.05, y - 0.05);
        [cos * x - sin * y + 0.05, sin * x + cos * y + 0.05, 1.1 * z]
    };
    rest.iter().map(turn).collect()
}

fn params() -> MultigridParams {
    MultigridParams {
        coarsest: 20,
        ..MultigridParams::default()
    }
}

#[test]
fn a_turned_free_body_resists_no_motion_of_its_near_kernel() {
    let mesh = kuhn_grid(2, 3, 2, [0.1, 0.2, 0.1]).unwrap();
    let dofs = Dofs::all_free(mesh.nodes()).unwrap();
    let body = built(AssemblyBuilder::new(&mesh, dofs).unwrap());
    // A quarter turn about z and a shift: rotations of the rest shape would not do.
    let turned = mesh.nodes().iter().map(|&[x, y, z]| [2.0 - y, x, z]);
    let problem = Quasistatic::new(&body, turned.collect(), vec![]).unwrap();
    let x = problem.unknowns();
    let mut stiffness = BlockSymmetric::zeros(problem.pattern().unwrap());
    problem.hessian(&x, HessianProjection::None, &mut stiffness);
    let kernel = problem.near_kernel(&x);
    assert_eq!(kernel.count(), 6);
    let size = stiffness.diagonal().iter().fold(0.0_f64, |m, v| m.max(*v));
    let mut force = vec![0.0; x.len()];
    for motion in kernel.vectors() {
        assert!(motion.iter().any(|v| v.abs() > 0.4));
        stiffness.apply(motion, &mut force);
        assert!(force.iter().all(|f| f.abs() < 1e-12 * size));
    }
}

#[test]
fn a_prescribed_axis_does_not_move() {
    let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
    let dofs = Dofs::new(mesh.nodes(), &[0], &[(5, 1), (7, 2)]).unwrap();
    let rows = [(5, 1), (7, 2)].map(|(node, axis)| 3 * dofs.row(node).unwrap() + axis);
    let body = built(AssemblyBuilder::new(&mesh, dofs).unwrap());
    let problem = Quasistatic::new(&body, mesh.nodes().to_vec(), vec![]).unwrap();
    let kernel = problem.near_kernel(&problem.unknowns());
    for motion in kernel.vectors() {
        assert!(rows.iter().all(|&row| motion[row] == 0.0));
        assert!(motion.iter().any(|&v| v != 0.0));
    }
}

#[test]
fn multigrid_and_a_factor_find_the_same_twist() {
    let body = bar(4);
    let problem = Quasistatic::new(&body, twisted(body.rest()), vec![]).unwrap();
    let settings = NewtonParams {
        relative_gradient_tolerance: 1e-10,
        linear_solver: LinearSolver::Direct,
        ..NewtonParams::default()
    };
    let (mut exact, mut x) = (problem.unknowns(), problem.unknowns());
    let direct = Newton::new(&problem)
        .solve(&problem, &mut exact, &settings)
        .unwrap();
    let direction = MultigridDirection::<3, 6>::new(params());
    let mut newton = Newton::with_direction(&problem, direction);
    let info = newton.solve(&problem, &mut x, &settings).unwrap();
    assert_eq!(info.factorizations, 0);
    assert!((info.energy - direct.energy).abs() < 1e-12 * direct.energy);
    let off = x.iter().zip(&exact).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-11);
    // To 1e-10 in few iterations more than a digit takes.
    assert!(info.linear_iterations < 120, "{}", info.linear_iterations);

    // The derivative by a force, by the same hierarchy.
    let load: Vec<f64> = (0..x.len()).map(|k| (k as f64).sin()).collect();
    let found = newton
        .linearized(&problem, &x, &load, 1e-10, &settings)
        .unwrap();
    let mut expected = load.clone();
    let factor = newton.factor_at(&problem, &x).unwrap();
    factor.solve_in_place(&mut expected);
    let size = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-7 * size;
    assert!(found.iter().zip(&expected).all(close));
}

#[test]
fn the_wrong_number_of_vectors_ends_a_solve() {
    let body = bar(2);
    let problem = Quasistatic::new(&body, twisted(body.rest()), vec![]).unwrap();
    let direction = MultigridDirection::<3, 3>::new(params());
    let error = Newton::with_direction(&problem, direction)
        .solve(&problem, &mut problem.unknowns(), &NewtonParams::default())
        .unwrap_err();
    assert!(
        matches!(error.reason, NewtonFailure::Preconditioner(_)),
        "{error}"
    );
}
