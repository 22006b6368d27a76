//! Blocks of many sizes and stiffnesses: a solve that starts at its own solution is done.

use crate::promise::Newton;
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, Quasistatic};
use fem_materials::{Material, MooneyRivlin, NeoHookean, Sum, VolumetricLog};
use fem_solvers::{NewtonParams, StopReason};

/// A cube of edge `size`, meters, in n³ cells, its ends prescribed.
fn block<M: Material<3> + 'static>(n: usize, size: f64, material: M) -> Assembly<3> {
    let mesh = kuhn_grid(n, n, n, [size; 3]).unwrap();
    let far = mesh.nodes().iter().fold(0.0_f64, |m, p| m.max(p[0]));
    let prescribed: Vec<usize> = (0..mesh.nodes().len())
        .filter(|&k| mesh.nodes()[k][0] == 0.0 || mesh.nodes()[k][0] == far)
        .collect();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed).unwrap();
    AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(material)
        .unwrap()
        .build()
        .unwrap()
}

fn solves_twice(assembly: &Assembly<3>, stretch: f64, what: &str) {
    for tolerance in [1e-8, 0.0] {
        let params = NewtonParams {
            relative_gradient_tolerance: tolerance,
            ..NewtonParams::default()
        };
        let pulled = assembly.rest().iter().map(|p| [stretch * p[0], p[1], p[2]]);
        let problem = Quasistatic::new(assembly, pulled.collect(), vec![]).unwrap();
        let mut x = problem.unknowns();
        let mut newton = Newton::new(&problem);
        for attempt in 0..3 {
            let info = newton
                .solve(&problem, &mut x, &params)
                .unwrap_or_else(|e| panic!("{what}, tolerance {tolerance}, solve {attempt}: {e}"));
            // A body at rest may have no force at all.
            assert!(
                tolerance > 0.0 || info.stop == StopReason::Rounding || info.gradient_norm == 0.0,
                "{what}: {info:?}"
            );
            if attempt > 0 {
                // Rounding can be left by one step that meets less of it.
                let most = if tolerance > 0.0 { 0 } else { 1 };
                assert!(info.iterations <= most, "{what}, solve {attempt}: {info:?}");
            }
        }
    }
}

/// The check of these tests sees a solve that stopped early.
#[test]
#[should_panic = "N promised by RelativeGradient"]
fn a_solve_that_claims_too_much_is_caught() {
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 4e4,
    };
    let body = block(2, 1.0, flesh);
    let pulled = body.rest().iter().map(|p| [1.2 * p[0], p[1], p[2]]);
    let problem = Quasistatic::new(&body, pulled.collect(), vec![]).unwrap();
    let (mut x, params) = (problem.unknowns(), NewtonParams::default());
    let loose = NewtonParams {
        relative_gradient_tolerance: 1e-3,
        ..params
    };
    let info = Newton::new(&problem)
        .solve(&problem, &mut x, &loose)
        .unwrap();
    crate::promise::kept(&problem, &x, &params, info.stop);
}

#[test]
fn a_second_solve_takes_no_step_at_every_size_and_stiffness() {
    for n in [2, 4, 8, 12] {
        // Of the larger blocks one size, of the largest one stiffness: they differ by powers, not by kind.
        let stiffnesses: &[f64] = if n == 12 { &[1e5] } else { &[1e3, 1e5, 1e9] };
        for &mu in stiffnesses {
            let sizes: &[f64] = if n >= 8 { &[1.0] } else { &[1e-3, 1.0, 1e3] };
            for &size in sizes {
                for stretch in [1.0, 1.2] {
                    let what = format!("n = {n}, mu = {mu:e}, {size:e} m, stretch {stretch}");
                    let flesh = NeoHookean {
                        mu,
                        lambda: 10.0 * mu,
                    };
                    solves_twice(&block(n, size, flesh), stretch, &what);
                    let rubber = Sum(
                        MooneyRivlin {
                            A: 0.3 * mu,
                            B: 0.2 * mu,
                        },
                        VolumetricLog { K: 20.0 * mu },
                    );
                    solves_twice(&block(n, size, rubber), stretch, &what);
                }
            }
        }
    }
}
