//! Blocks of many sizes and stiffnesses: a solve that starts at its own solution is done.

use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, Quasistatic};
use fem_materials::{Material, MooneyRivlin, NeoHookean, Sum, VolumetricLog};
use fem_solvers::{Newton, NewtonParams, StopReason};

/// A cube of edge `size`, meters, in n³ cells, its ends held.
fn block<M: Material<3> + 'static>(n: usize, size: f64, material: M) -> Assembly<3> {
    let mesh = kuhn_grid(n, n, n, [size; 3]).unwrap();
    let far = mesh.nodes().iter().fold(0.0_f64, |m, p| m.max(p[0]));
    let held: Vec<usize> = (0..mesh.nodes().len())
        .filter(|&k| mesh.nodes()[k][0] == 0.0 || mesh.nodes()[k][0] == far)
        .collect();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &held).unwrap();
    AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(material)
        .unwrap()
        .build()
        .unwrap()
}

/// Largest force on a free node, by the sum over all nodes instead of the rows of the unknowns.
fn unbalanced(assembly: &Assembly<3>, positions: &[[f64; 3]]) -> f64 {
    let forces = assembly.forces_everywhere(assembly.configuration(positions, &[]).unwrap());
    (0..forces.len())
        .filter(|&n| assembly.dofs().row(n).is_some())
        .flat_map(|n| forces[n])
        .fold(0.0, |m, f| if f.abs() <= m { m } else { f.abs() })
}

fn solves_twice(assembly: &Assembly<3>, stretch: f64, what: &str) {
    let scale = assembly.force_scale().unwrap();
    for tolerance in [1e-8, 0.0] {
        let params = NewtonParams {
            relative_gradient_tolerance: tolerance,
            ..NewtonParams::default()
        };
        // Rounding is some 1e-16 of stiffness times size: far below what the default asks for.
        let promised = if tolerance > 0.0 { tolerance } else { 1e-11 } * scale;
        let pulled = assembly.rest().iter().map(|p| [stretch * p[0], p[1], p[2]]);
        let problem = Quasistatic::new(assembly, pulled.collect(), vec![]).unwrap();
        let mut x = problem.unknowns();
        let mut newton = Newton::new(&problem);
        for attempt in 0..3 {
            let info = newton
                .solve(&problem, &mut x, &params)
                .unwrap_or_else(|e| panic!("{what}, tolerance {tolerance}, solve {attempt}: {e}"));
            let left = unbalanced(assembly, &problem.positions(&x));
            assert!(
                left <= promised,
                "{what}: {left:e} N left of {promised:e} N, {info:?}"
            );
            // A body at rest may have no force at all.
            assert!(
                tolerance > 0.0 || info.stop == StopReason::Rounding || info.gradient_norm == 0.0,
                "{what}: {info:?}"
            );
            if attempt > 0 {
                assert!(info.iterations <= 2, "{what}, solve {attempt}: {info:?}");
            }
        }
    }
}

#[test]
fn a_second_solve_takes_at_most_two_steps_at_every_size_and_stiffness() {
    for n in [2, 4, 8] {
        for mu in [1e3, 1e5, 1e9] {
            // One size of the largest block: the sizes differ by powers, not by kind.
            let sizes: &[f64] = if n == 8 { &[1.0] } else { &[1e-3, 1.0, 1e3] };
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
