//! Newton steps where the flesh follows its bones to first order.

use fem_assembly::mesh::SimplexMesh;
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, Quasistatic, solve_walking};
use fem_materials::{Lame, NeoHookean, Space};
use fem_solvers::{ContinuationParams, Newton, NewtonParams};

/// A unit square of n × n cells, its lower edge prescribed and its upper one sheared by 0.8.
fn sheared(n: usize) -> (Assembly<2>, Vec<[f64; 2]>, Vec<[f64; 2]>) {
    let at = |i: usize| i as f64 / n as f64;
    let rest: Vec<[f64; 2]> = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| [at(i), at(j)]))
        .collect();
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| (j * (n + 1) + i) as u32));
    let (right, up) = (1, n as u32 + 1);
    let halves = |a: u32| [a, a + right, a + right + up, a, a + right + up, a + up];
    let mesh = SimplexMesh::new(rest.clone(), cells.flat_map(halves).collect()).unwrap();
    let edge = |p: &[f64; 2]| p[1] == 0.0 || p[1] == 1.0;
    let prescribed: Vec<usize> = (0..rest.len()).filter(|&k| edge(&rest[k])).collect();
    let dofs = Dofs::with_prescribed_nodes(&rest, &prescribed).unwrap();
    let Lame { lambda, mu } = Lame::from_young_poisson(100.0, 0.45, Space::Solid).unwrap();
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let body = builder.material(NeoHookean { mu, lambda }).unwrap().build();
    let moved = rest.iter().map(|p| [p[0] + 0.8 * p[1].floor(), p[1]]);
    let moved = moved.collect();
    (body.unwrap(), rest, moved)
}

#[test]
fn a_sheared_square_takes_few_steps_on_coarse_and_finer_meshes() {
    let steps = |n: usize| {
        let (mut body, rest, moved) = sheared(n);
        let mut newton = Newton::new(&Quasistatic::new(&body, rest.clone(), vec![]).unwrap());
        let (params, walk) = (NewtonParams::default(), ContinuationParams::default());
        let there = solve_walking(&mut body, &mut newton, rest, &moved, &[], &params, &walk);
        let there = there.unwrap();
        assert_eq!((there.walk.steps, there.walk.failures), (1, 0), "n = {n}");
        there.iterations
    };
    let counts = [10, 30, 90].map(steps);
    println!("{counts:?}");
    assert!(counts.iter().all(|&c| c <= 9), "{counts:?}");
}
