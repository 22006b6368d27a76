//! What can move with nothing to stop it is found before a solve.
#![allow(non_snake_case)]

use crate::promise::Newton;
use fem_assembly::mesh::{Orientation, Orphans, SimplexMesh, kuhn_grid};
use fem_assembly::{
    AssemblyBuilder, Dofs, FreePart, NodalLoads, Quasistatic, RigidMotion, Springs,
};
use fem_materials::{HessianProjection, Lame, NeoHookean, Space};
use fem_solvers::{BlockSymmetric, CholeskyError, CholeskyFactor, NewtonFailure, SymbolicCholesky};
use std::sync::Arc;

fn parts(mesh: &SimplexMesh<3>, nodes: &[usize], axes: &[(usize, usize)]) -> Vec<FreePart<3>> {
    let dofs = Dofs::new(mesh.nodes(), nodes, axes).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 1e5,
    };
    let builder = AssemblyBuilder::new(mesh, dofs)
        .unwrap()
        .material(flesh)
        .unwrap();
    // A load pulls, it does not hold.
    let load = NodalLoads::new(vec![(13, [1.0, 0.0, 0.0])]).unwrap();
    let assembly = builder.term(load).unwrap().build().unwrap();
    let at = assembly.configuration(mesh.nodes(), &[]).unwrap();
    assembly.free_motions(at)
}

fn block() -> SimplexMesh<3> {
    kuhn_grid(2, 2, 2, [1.0; 3]).unwrap()
}

fn at(mesh: &SimplexMesh<3>, wanted: impl Fn(&[f64; 3]) -> bool) -> Vec<usize> {
    (0..mesh.nodes().len())
        .filter(|&n| wanted(&mesh.nodes()[n]))
        .collect()
}

#[test]
fn a_body_that_nothing_holds_has_six_motions_and_a_held_one_none() {
    let mesh = block();
    let free = parts(&mesh, &[], &[]);
    assert_eq!(
        (free.len(), free[0].nodes, free[0].motions.len()),
        (1, 27, 6)
    );
    assert!(
        free[0]
            .to_string()
            .ends_with("held by nothing: 6 free motions")
    );
    assert!(parts(&mesh, &at(&mesh, |p| p[0] == 0.0), &[]).is_empty());
    // Six axes, no more than it takes.
    let [a, b, c] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|q| at(&mesh, |p| *p == q)[0]);
    let axes = [(a, 0), (a, 1), (a, 2), (b, 1), (b, 2), (c, 2)];
    assert!(parts(&mesh, &[], &axes).is_empty());
    let missing = parts(&mesh, &[], &axes[..5]);
    assert_eq!(missing[0].motions.len(), 1);
}

#[test]
fn a_body_held_at_a_point_or_a_line_turns_about_it() {
    let mesh = block();
    let point = parts(&mesh, &at(&mesh, |p| *p == [1.0, 0.5, 0.0]), &[]);
    assert_eq!(point[0].motions.len(), 3);
    let line = parts(&mesh, &at(&mesh, |p| p[0] == 1.0 && p[1] == 0.5), &[]);
    let [RigidMotion::Rotation { axis, through }] = line[0].motions[..] else {
        panic!("{line:?}");
    };
    assert!((axis[2].abs() - 1.0).abs() < 1e-9, "{axis:?}");
    assert!(
        (through[0] - 1.0).abs() < 1e-9 && (through[1] - 0.5).abs() < 1e-9,
        "{through:?}"
    );
    // A plane of rollers leaves two slides and a turn.
    let rollers: Vec<(usize, usize)> = at(&mesh, |p| p[2] == 0.0).iter().map(|&n| (n, 2)).collect();
    let motions = parts(&mesh, &[], &rollers)[0].motions.clone();
    let slides = motions.iter().filter(|m| match m {
        RigidMotion::Translation { along } => along[2].abs() < 1e-9,
        RigidMotion::Rotation { .. } => false,
    });
    assert_eq!((motions.len(), slides.count()), (3, 2));
}

#[test]
fn two_bodies_and_a_lost_node_are_told_apart() {
    let one = block();
    let mut nodes = one.nodes().to_vec();
    nodes.extend(one.nodes().iter().map(|p| [p[0] + 3.0, p[1], p[2]]));
    nodes.push([9.0; 3]);
    let both = one.elements().flat_map(|e| {
        let e: [u32; 4] = std::array::from_fn(|k| e[k]);
        [e, e.map(|n| n + 27)]
    });
    let elements: Vec<u32> = both.flatten().collect();
    let mesh = SimplexMesh::with_repairs(nodes, elements, Orientation::Refuse, Orphans::Allow)
        .unwrap()
        .0;
    let prescribed = at(&mesh, |p| p[0] == 0.0);
    let free = parts(&mesh, &prescribed, &[]);
    assert_eq!(free.len(), 2, "{free:?}");
    assert_eq!(
        (free[0].nodes, free[0].motions.len(), free[0].alone),
        (27, 6, false)
    );
    assert!(free[1].alone && free[1].first_node == 54);
    // A point has no turns.
    assert_eq!(free[1].motions.len(), 3);
    assert_eq!(
        free[1].to_string(),
        "node 54 belongs to no element, and nothing holds it"
    );
}

/// What has a stiffness holds, whether a node is prescribed or not.
#[test]
fn springs_hold_what_they_pull_back() {
    let mesh = block();
    let free = |held: &[usize]| {
        let dofs = Dofs::all_free(mesh.nodes()).unwrap();
        let flesh = NeoHookean {
            mu: 1e4,
            lambda: 1e5,
        };
        let springs = Springs::at_nodes(held.iter().map(|&n| (n, mesh.nodes()[n])), 50.0).unwrap();
        let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
        let builder = builder.material(flesh).unwrap().term(springs).unwrap();
        let assembly = builder.build().unwrap();
        let at = assembly.configuration(mesh.nodes(), &[]).unwrap();
        let parts = assembly.free_motions(at);
        parts.iter().map(|part| part.motions.len()).sum::<usize>()
    };
    // One point leaves three turns, a line one, a face none.
    assert_eq!(free(&at(&mesh, |p| *p == [1.0, 0.5, 0.0])), 3);
    assert_eq!(free(&at(&mesh, |p| p[0] == 1.0 && p[1] == 0.5)), 1);
    assert_eq!(free(&at(&mesh, |p| p[0] == 1.0)), 0);
}

/// Moduli of 0 hold nothing, however much is prescribed; any one of them above 0 holds.
#[test]
fn flesh_without_stiffness_is_named_and_flesh_with_any_is_not() {
    let mesh = block();
    let prescribed = at(&mesh, |p| p[2] == 0.0);
    let of = |mu: f64, lambda: f64, nodes: &[usize], axes: &[(usize, usize)]| {
        let dofs = Dofs::new(mesh.nodes(), nodes, axes).unwrap();
        let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
        let flesh = NeoHookean { mu, lambda };
        let assembly = builder.material(flesh).unwrap().build().unwrap();
        let at = assembly.configuration(mesh.nodes(), &[]).unwrap();
        assembly.free_motions(at)
    };
    let parts = |mu: f64, lambda: f64| of(mu, lambda, &prescribed, &[]);
    let limp = parts(0.0, 0.0);
    let [part] = &limp[..] else {
        panic!("{limp:?}");
    };
    assert!(part.limp && !part.alone);
    assert_eq!((part.nodes, part.motions.len()), (18, 6));
    assert!(part.to_string().contains("no stiffness at all"), "{part}");
    for (mu, lambda) in [(0.0, 1e-200), (1e-200, 0.0), (1e4, 1e5)] {
        assert!(parts(mu, lambda).is_empty(), "{mu:e} {lambda:e}");
    }
    // Axes that leave it no motion as a whole do not stiffen it.
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let [a, b, c, d] = corners.map(|q| at(&mesh, |p| *p == q)[0]);
    let axes = [(a, 0), (a, 1), (b, 1), (b, 2), (c, 2), (d, 0)];
    let limp = of(0.0, 0.0, &[], &axes);
    let none = |part: &FreePart<3>| part.limp && part.motions.is_empty();
    assert!(limp.len() == 1 && none(&limp[0]), "{limp:?}");
    assert!(of(1e4, 1e5, &[], &axes).is_empty());
}

#[test]
fn the_stiffness_of_a_free_body_is_singular_and_is_not_factored_into_numbers() {
    // Rounding makes its zero pivots positive or negative; which, differs from mesh to mesh.
    for n in 1..7 {
        for young in [1e-6, 3e4, 1e12] {
            let mesh = kuhn_grid(n, n, n + 1, [0.9, 1.0, 1.3]).unwrap();
            let Lame { lambda, mu } = Lame::from_young_poisson(young, 0.45, Space::Solid).unwrap();
            let stiffness = |held: &[usize]| {
                let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), held).unwrap();
                let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
                let body = builder.material(NeoHookean { mu, lambda }).unwrap();
                let body = body.build().unwrap();
                let mut K = BlockSymmetric::zeros(body.pattern().clone());
                let at = body.configuration(mesh.nodes(), &[]).unwrap();
                body.hessian(at, HessianProjection::None, &mut K);
                let symbolic = Arc::new(SymbolicCholesky::new(body.pattern()));
                let error = CholeskyFactor::<f64, 3>::factor(&symbolic, &K).err();
                // The factor behind derivatives is no other.
                let problem = Quasistatic::new(&body, mesh.nodes().to_vec(), vec![]).unwrap();
                let mut newton = Newton::new(&problem);
                let at_rest = newton.factor_at(&problem, &problem.unknowns()).err();
                let refused = matches!(at_rest, Some(NewtonFailure::Cholesky(_)));
                assert_eq!(refused, error.is_some(), "{at_rest:?}");
                error
            };
            // One node or two leave rotations.
            for held in [&[][..], &[0], &[0, 1]] {
                let error = stiffness(held);
                let refused = matches!(error, Some(CholeskyError::NotPositiveDefinite { .. }));
                assert!(refused, "{n} {young}: {held:?} {error:?}");
            }
            assert_eq!(stiffness(&[0, 1, n + 1]), None, "{n} {young}");
        }
    }
}
