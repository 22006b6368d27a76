//! Whoever solves a body that too little holds is told so: before the solve where it is asked for, and by
//! the error of a solve that failed.

use crate::promise::{Newton, solve_renewing};
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{
    Assembly, AssemblyBuilder, AssemblyError, Dofs, NodalLoads, Quasistatic, RenewingError,
};
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
            Some(&*named),
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
            assert_eq!(source.undetermined.as_deref(), Some(&*named))
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
        assert_eq!(failed(body, &short).undetermined.as_deref(), Some(&*named));
    }
    // A face holds; that a solve has too few steps is then all there is to say.
    let face = cube(|p| p[0] == 0.0);
    assert!(Quasistatic::held(&face, face.rest().to_vec(), vec![]).is_ok());
    let error = failed(&face, &short);
    assert_eq!(error.undetermined, None);
    assert!(error.to_string().ends_with("not converged"), "{error}");
}
