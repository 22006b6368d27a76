//! What processors without vector registers do, done here: the same bits.

use crate::mesh::kuhn_grid;
use crate::{AssemblyBuilder, Dofs, Fiber, Quasistatic};
use fem_kinematics::portable_only;
use fem_materials::curves::PhysBam;
use fem_materials::{FiberLaw, NeoHookean};
use fem_solvers::{MultigridDirection, MultigridParams, NewtonParams, ProjectionPolicy};
use promise::Newton;

#[path = "../tests/all/promise.rs"]
mod promise;

/// Where a twisted bar with a muscle ends up.
fn solved(multigrid: bool, projection: ProjectionPolicy) -> Vec<[f64; 3]> {
    let mesh = kuhn_grid(3, 3, 9, [0.1, 0.1, 0.3]).unwrap();
    let rest = mesh.nodes();
    let end = |z: f64| !(1e-9..=0.3 - 1e-9).contains(&z);
    let prescribed: Vec<usize> = (0..rest.len()).filter(|&n| end(rest[n][2])).collect();
    let dofs = Dofs::with_prescribed_nodes(rest, &prescribed).unwrap();
    // Neither their number nor that of the elements is a multiple of eight.
    let fibers = (0..101).map(|k| Fiber {
        element: 4 * k + 3,
        control: 0,
        direction: [0.0, 0.6, 0.8],
        max_isometric_stress: 1e5,
        optimal_stretch: 1.0,
    });
    let flesh = NeoHookean {
        mu: 3e4,
        lambda: 2e5,
    };
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let builder = builder.material(flesh).unwrap();
    let fibers: Vec<Fiber> = fibers.collect();
    let builder = builder.fibers(FiberLaw::<PhysBam>::default(), 1, &fibers);
    let body = builder.unwrap().build().unwrap();
    let turned = rest.iter().map(|&[x, y, z]| {
        let (sin, cos) = (z / 0.3 * std::f64::consts::FRAC_PI_3).sin_cos();
        let (x, y) = (x - 0.05, y - 0.05);
        [cos * x - sin * y + 0.05, sin * x + cos * y + 0.05, 1.1 * z]
    });
    let problem = Quasistatic::new(&body, turned.collect(), vec![0.4]).unwrap();
    let mut x = problem.unknowns();
    let params = NewtonParams {
        projection,
        ..NewtonParams::default()
    };
    let mut newton = if multigrid {
        let params = MultigridParams {
            coarsest: 20,
            ..MultigridParams::default()
        };
        Newton::with_direction(&problem, MultigridDirection::<3, 6>::new(params))
    } else {
        Newton::new(&problem)
    };
    let done = newton.solve(&problem, &mut x, &params).unwrap();
    assert!(done.iterations > 2);
    problem.positions(&x).unwrap()
}

#[test]
fn a_solve_without_vector_registers_ends_with_the_same_bits() {
    let exact = ProjectionPolicy::ExactFirst;
    let ways = [
        (false, exact),
        (true, exact),
        (false, ProjectionPolicy::AlwaysProjected),
    ];
    for (multigrid, projection) in ways {
        let wide = solved(multigrid, projection);
        portable_only(true);
        let one_by_one = solved(multigrid, projection);
        portable_only(false);
        let bits =
            |x: &[[f64; 3]]| -> Vec<u64> { x.as_flattened().iter().map(|x| x.to_bits()).collect() };
        assert_eq!(bits(&wide), bits(&one_by_one), "{multigrid} {projection:?}");
    }
}
