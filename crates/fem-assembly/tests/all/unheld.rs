//! Whoever solves a body that too little holds is told so: before the solve where it is asked for, and by
//! the error of a solve that failed.

use crate::promise::{Newton, solve_renewing};
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{
    Assembly, AssemblyBuilder, AssemblyError, Dofs, NodalLoads, Penalty, Quasistatic, RenewingError,
};
use fem_kinematics::ImplicitSurface;
use fem_materials::NeoHookean;
use fem_solvers::{LinearSolver, NewtonError, NewtonParams, PreconditionerChoice};

/// A cube pulled at one corner and held where asked.
fn cube(held: impl Fn(&[f64; 3]) -> bool) -> Assembly<3> {
    let mesh = kuhn_grid(3, 3, 3, [1.0; 3]).unwrap();
    let nodes: Vec<usize> = (0..mesh.num_nodes())
        .filter(|&n| held(&mesh.nodes()[n]))
        .collect();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &nodes).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 1e5,
    };
    let load = NodalLoads::new(vec![(mesh.num_nodes() - 1, [40.0, -30.0, 20.0])]).unwrap();
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let builder = builder.material(flesh).unwrap().term(load).unwrap();
    builder.build().unwrap()
}

fn failed(body: &Assembly<3>, params: &NewtonParams) -> NewtonError {
    let problem = Quasistatic::new(body, body.rest().to_vec(), vec![]).unwrap();
    let mut x = problem.unknowns();
    let solved = Newton::new(&problem).solve(&problem, &mut x, params);
    solved.expect_err("cannot have an equilibrium")
}

fn refused(body: &Assembly<3>) -> String {
    let held = Quasistatic::held(body, body.rest().to_vec(), vec![]);
    let error = held.expect_err("is not held");
    assert!(matches!(error, AssemblyError::Free { others: 0, .. }));
    error.to_string()
}

#[test]
fn a_loaded_body_that_nothing_holds_is_named_whichever_solver_fails() {
    let body = cube(|_| false);
    let named = refused(&body);
    for part in ["64 nodes", "held by nothing: 6 free motions", "prescribe"] {
        assert!(named.contains(part), "{named}");
    }
    let pcg = LinearSolver::Pcg {
        preconditioner: PreconditionerChoice::BlockJacobi,
        max_iterations: 500,
    };
    for linear_solver in [
        LinearSolver::Auto,
        LinearSolver::Direct,
        LinearSolver::DirectSingle,
        pcg,
    ] {
        let params = NewtonParams {
            linear_solver,
            ..NewtonParams::default()
        };
        let error = failed(&body, &params);
        assert_eq!(
            error.undetermined.as_deref(),
            Some(&*format!("where the solve ended, {named}")),
            "{linear_solver:?}"
        );
        assert!(error.to_string().ends_with(&named), "{error}");
    }
    // The same through what renews stencils.
    let mut body = body;
    let problem = Quasistatic::new(&body, body.rest().to_vec(), vec![]).unwrap();
    let (mut newton, start) = (Newton::new(&problem), body.rest().to_vec());
    let params = NewtonParams::default();
    match solve_renewing(&mut body, &mut newton, start, &[], &params) {
        Err(RenewingError::Newton { source, .. }) => {
            assert!(source.undetermined.unwrap().ends_with(&named))
        }
        other => panic!("{other:?}"),
    }
}

/// A point or a line leaves motions that a load may or may not bring to rest; both are named.
#[test]
fn what_a_point_or_a_line_leaves_free_is_named() {
    let short = NewtonParams {
        max_iterations: 1,
        ..NewtonParams::default()
    };
    let point = cube(|p| *p == [0.0; 3]);
    let line = cube(|p| p[0] == 0.0 && p[1] == 0.0);
    for (body, motions) in [(&point, "3 free motions"), (&line, "1 free motions; about")] {
        let named = refused(body);
        assert!(named.contains(motions), "{named}");
        // Stressed by its load by now, and elsewhere.
        let told = failed(body, &short).undetermined.unwrap();
        assert!(told.starts_with("where the solve ended, "), "{told}");
        assert!(told.contains(motions), "{told}");
    }
    // A face holds; that a solve has too few steps is then all there is to say.
    let face = cube(|p| p[0] == 0.0);
    assert!(Quasistatic::held(&face, face.rest().to_vec(), vec![]).is_ok());
    let error = failed(&face, &short);
    assert_eq!(error.undetermined, None);
    assert!(error.to_string().ends_with("not converged"), "{error}");
}

/// A cube between rollers that leave it its way along z, pushed along it at every node (N), over a plate
/// at `plate`.
fn lift(push: f64, plate: Option<f64>) -> Assembly<3> {
    let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
    let nodes = mesh.nodes();
    let rollers = |k: usize| (0..nodes.len()).filter(move |&n| nodes[n][k] == 0.0);
    let axes: Vec<_> = (0..2)
        .flat_map(|k| rollers(k).map(move |n| (n, k)))
        .collect();
    let dofs = Dofs::new(nodes, &[], &axes).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 1e4,
    };
    let loads = (0..nodes.len()).map(|n| (n, [0.0, 0.0, push])).collect();
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let builder = builder.material(flesh).unwrap();
    let builder = builder.term(NodalLoads::new(loads).unwrap()).unwrap();
    let obstacle = |height| ImplicitSurface::HalfSpace {
        point: [0.0, 0.0, height],
        normal: [0.0, 0.0, 1.0],
    };
    let touched = |height| Penalty {
        nodes: rollers(2).collect(),
        stiffness: 1e4,
        obstacle: obstacle(height),
    };
    let builder = match plate {
        Some(height) => builder.penalty(touched(height)).unwrap(),
        None => builder,
    };
    builder.build().unwrap()
}

/// What a solve in too few steps says, and how high the cube's lower side then is (m): from 0.1 below its
/// rest.
fn in_few_steps(body: &Assembly<3>) -> (Option<Box<str>>, f64) {
    let lowered = body.rest().iter().map(|p| [p[0], p[1], p[2] - 0.1]);
    let problem = Quasistatic::new(body, lowered.collect(), vec![]).unwrap();
    let few = NewtonParams {
        max_iterations: 1,
        linear_solver: LinearSolver::Direct,
        ..NewtonParams::default()
    };
    let mut x = problem.unknowns();
    let error = Newton::new(&problem).solve(&problem, &mut x, &few);
    let lowest = problem
        .positions(&x)
        .unwrap()
        .iter()
        .fold(9.0_f64, |m, p| m.min(p[2]));
    (error.expect_err("needs more").undetermined, lowest)
}

#[test]
fn a_body_is_told_what_holds_it_where_its_solve_ended() {
    let along =
        "component of 27 nodes (node 0 among them), held by too little: 1 free motions; along";
    // In free air, at rest as well as at the end.
    let air = lift(-2.0, None);
    assert!(refused(&air).starts_with(along));
    let told = in_few_steps(&air).0.unwrap();
    let expected = format!("where the solve ended, {along}");
    assert!(told.starts_with(&expected), "{told}");
    // It has come down on a plate that is out of reach at rest.
    let landed = lift(-2.0, Some(-0.05));
    assert!(refused(&landed).starts_with(along));
    let (told, height) = in_few_steps(&landed);
    assert!(height < -0.05, "{height}");
    assert_eq!(told, None);
    // A plate that it rests on and is pulled away from.
    let pulled = lift(2.0, Some(0.01));
    assert!(Quasistatic::held(&pulled, pulled.rest().to_vec(), vec![]).is_ok());
    let (told, height) = in_few_steps(&pulled);
    assert!(height > 0.01, "{height}");
    let (told, expected) = (told.unwrap(), format!("held at rest, but {expected}"));
    assert!(told.starts_with(&expected), "{told}");
}
