//! Forces and Hessian against the energy, on a twisted bar with muscles, a roller and obstacles; and
//! against the formulas of the documents, on single elements and on triangles.
#![allow(non_snake_case)]

#[path = "documents/finite_volume.rs"]
mod finite_volume;
#[path = "documents/plane.rs"]
mod plane;
#[path = "documents/random.rs"]
mod random;
#[path = "documents/work.rs"]
mod work;

use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, Fiber, ImplicitSurface, Penalty};
use fem_materials::curves::PhysBam;
use fem_materials::{FiberLaw, HessianProjection, NeoHookean, Stretch};
use fem_solvers::{BlockSymmetric, LinearOperator};

type Point = [f64; 3];

fn bar() -> SimplexMesh<3> {
    kuhn_grid(2, 2, 3, [1.0, 1.0, 2.0]).unwrap()
}

fn assembly(stretch: Stretch) -> (Assembly<3>, Vec<Point>) {
    let mesh = bar();
    let rest = mesh.nodes();
    let prescribed: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == 0.0).collect();
    let dofs = Dofs::new(rest, &prescribed, &[(rest.len() - 1, 1)]).unwrap();
    let count = mesh.elements().len();
    let fibers: Vec<Fiber> = (0..count)
        .filter(|e| e % 3 != 0)
        .flat_map(|e| {
            let angle = e as f64;
            let one = Fiber {
                element: e,
                control: e % 2,
                direction: [angle.cos(), angle.sin(), 0.0],
                max_isometric_stress: 3e3,
                optimal_stretch: 1.0,
            };
            let two = Fiber {
                control: 2,
                direction: [0.0, 0.6, 0.8],
                ..one
            };
            [one, two].into_iter().take(1 + e % 2)
        })
        .collect();
    let curve = PhysBam::default();
    let built = AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(NeoHookean {
            mu: 1e3,
            lambda: 4e3,
        })
        .unwrap()
        .fibers(FiberLaw { curve, stretch }, 3, &fibers)
        .unwrap()
        .penalty(Penalty {
            nodes: (0..rest.len()).collect(),
            stiffness: 500.0,
            obstacle: ImplicitSurface::Sphere {
                center: [0.5, 0.5, 2.6],
                radius: 0.8,
            },
        })
        .unwrap()
        .penalty(Penalty {
            nodes: (0..rest.len()).collect(),
            stiffness: 300.0,
            obstacle: ImplicitSurface::HalfSpace {
                point: [0.1, 0.0, 0.0],
                normal: [1.0, 0.0, 0.0],
            },
        })
        .unwrap()
        .build()
        .unwrap();
    let twisted = rest
        .iter()
        .map(|p| {
            let (s, c) = (0.2 * p[2]).sin_cos();
            [
                c * p[0] - s * p[1] + 0.03 * p[2] * p[1],
                s * p[0] + c * p[1],
                1.1 * p[2] + 0.05 * p[0],
            ]
        })
        .collect();
    (built, twisted)
}

const ACTIVATIONS: [f64; 3] = [0.3, 0.8, 0.5];

fn wave(n: usize, phase: f64) -> Vec<f64> {
    (0..n).map(|i| (1.3 * i as f64 + phase).sin()).collect()
}

/// Sixth-order central difference of a vector function along a direction. The step is small
/// because contacts and the tension curve have kinks that a longer one would straddle.
fn difference(f: impl Fn(f64) -> Vec<f64>, h: f64) -> Vec<f64> {
    let term = |k: f64| {
        let (high, low) = (f(k * h), f(-k * h));
        high.iter()
            .zip(low)
            .map(|(a, b)| (a - b) / h)
            .collect::<Vec<_>>()
    };
    let (one, two, three) = (term(1.0), term(2.0), term(3.0));
    (0..one.len())
        .map(|i| 0.75 * one[i] - 0.15 * two[i] + three[i] / 60.0)
        .collect()
}

fn moved(assembly: &Assembly<3>, x: &[Point], direction: &[f64], t: f64) -> Vec<Point> {
    let mut all = x.to_vec();
    let mut unknowns = assembly.dofs().gather(x).unwrap();
    unknowns
        .iter_mut()
        .zip(direction)
        .for_each(|(u, d)| *u += t * d);
    assembly.dofs().scatter(&unknowns, &mut all).unwrap();
    all
}

fn clear_roller(assembly: &Assembly<3>, direction: &mut [f64]) {
    let row = assembly.dofs().row(assembly.rest().len() - 1).unwrap();
    direction[3 * row + 1] = 0.0;
}

fn close(a: &[f64], b: &[f64], tolerance: f64) {
    let scale = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!(
            (a - b).abs() <= tolerance * scale,
            "entry {i}: {a} against {b}, scale {scale}"
        );
    }
}

#[test]
fn the_gradient_is_the_slope_of_the_energy_and_the_hessian_that_of_the_gradient() {
    for stretch in [Stretch::Total, Stretch::Isochoric] {
        let (assembly, x) = assembly(stretch);
        let n = assembly.dofs().vector_len();
        let mut direction = wave(n, 0.4);
        clear_roller(&assembly, &mut direction);
        let gradient_at = |x: &[Point]| {
            let mut g = vec![0.0; n];
            assembly
                .gradient(assembly.configuration(x, &ACTIVATIONS).unwrap(), &mut g)
                .unwrap();
            g
        };
        let gradient = gradient_at(&x);
        let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
        let energy = |t| {
            vec![
                assembly.energy(
                    assembly
                        .configuration(&moved(&assembly, &x, &direction, t), &ACTIVATIONS)
                        .unwrap(),
                ),
            ]
        };
        close(&[slope], &difference(energy, 1e-5), 1e-8);

        let mut hessian = BlockSymmetric::zeros(assembly.pattern().clone());
        assembly.hessian(
            assembly.configuration(&x, &ACTIVATIONS).unwrap(),
            HessianProjection::None,
            &mut hessian,
        );
        let mut product = vec![0.0; n];
        hessian.apply(&direction, &mut product);
        let differences = difference(|t| gradient_at(&moved(&assembly, &x, &direction, t)), 1e-5);
        close(&product, &differences, 1e-8);

        let mut displacement = vec![[0.0; 3]; x.len()];
        assembly
            .dofs()
            .scatter(&direction, &mut displacement)
            .unwrap();
        let mut matrix_free = vec![0.0; n];
        assembly
            .hessian_vector(
                assembly.configuration(&x, &ACTIVATIONS).unwrap(),
                &displacement,
                &mut matrix_free,
            )
            .unwrap();
        close(&matrix_free, &product, 1e-13);
    }
}

#[test]
fn the_force_of_a_muscle_is_the_slope_in_its_activation() {
    let (assembly, x) = assembly(Stretch::Total);
    let n = assembly.dofs().vector_len();
    for channel in 0..3 {
        let at = |t: f64| {
            let mut activations = ACTIVATIONS;
            activations[channel] += t;
            let mut g = vec![0.0; n];
            assembly
                .gradient(assembly.configuration(&x, &activations).unwrap(), &mut g)
                .unwrap();
            g
        };
        let mut exact = vec![0.0; n];
        assembly
            .control_gradient(
                assembly.configuration(&x, &ACTIVATIONS).unwrap(),
                channel,
                &mut exact,
            )
            .unwrap();
        // The force is affine in the activation (document 000, eq. 4): any step is exact.
        let (one, zero) = (at(1.0), at(0.0));
        let slope: Vec<f64> = one.iter().zip(zero).map(|(a, b)| a - b).collect();
        close(&exact, &slope, 1e-12);
    }
}

#[test]
fn internal_forces_and_torques_sum_to_zero() {
    let mesh = bar();
    let (_, x) = assembly(Stretch::Total);
    let body = AssemblyBuilder::new(&mesh, Dofs::all_free(mesh.nodes()).unwrap())
        .unwrap()
        .material(NeoHookean {
            mu: 1e3,
            lambda: 4e3,
        })
        .unwrap()
        .build()
        .unwrap();
    let forces = body.forces_everywhere(body.configuration(&x, &[]).unwrap());
    let largest = forces.iter().flatten().fold(0.0_f64, |m, f| m.max(f.abs()));
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let force: f64 = forces.iter().map(|f| f[k]).sum();
        let torque: f64 = forces
            .iter()
            .zip(&x)
            .map(|(f, p)| p[i] * f[j] - p[j] * f[i])
            .sum();
        assert!(force.abs() < 1e-13 * largest && torque.abs() < 1e-12 * largest);
    }
    let gradient = {
        let mut g = vec![0.0; body.dofs().vector_len()];
        body.gradient(body.configuration(&x, &[]).unwrap(), &mut g)
            .unwrap();
        g
    };
    let gathered: Vec<f64> = body
        .dofs()
        .gather(&forces)
        .unwrap()
        .iter()
        .map(|f| -f)
        .collect();
    close(&gathered, &gradient, 1e-14);
}

#[test]
fn one_and_three_threads_give_the_same_bits() {
    let evaluate = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let mesh = kuhn_grid(12, 12, 30, [1.0, 1.0, 3.0]).unwrap();
            let rest = mesh.nodes();
            let dofs = Dofs::with_prescribed_nodes(rest, &[0, 5, 11]).unwrap();
            let assembly = AssemblyBuilder::new(&mesh, dofs)
                .unwrap()
                .material(NeoHookean {
                    mu: 1e3,
                    lambda: 4e3,
                })
                .unwrap()
                .build()
                .unwrap();
            let x: Vec<Point> = rest
                .iter()
                .map(|p| [p[0] * 1.1, p[1] + 0.1 * p[0] * p[2], p[2] * 0.9])
                .collect();
            let mut gradient = vec![0.0; assembly.dofs().vector_len()];
            let energy = assembly
                .gradient(assembly.configuration(&x, &[]).unwrap(), &mut gradient)
                .unwrap();
            let mut hessian = BlockSymmetric::zeros(assembly.pattern().clone());
            assembly.hessian(
                assembly.configuration(&x, &[]).unwrap(),
                HessianProjection::None,
                &mut hessian,
            );
            (energy.to_bits(), gradient, hessian.values().to_vec())
        })
    };
    assert!(evaluate(1) == evaluate(3));
}

#[test]
fn an_inverted_element_is_named_and_gives_an_infinite_energy() {
    let (assembly, mut x) = assembly(Stretch::Total);
    assert_eq!(
        assembly.element_outside_domain(assembly.configuration(&x, &ACTIVATIONS).unwrap()),
        None
    );
    let n = x.len();
    x[n - 1][2] -= 5.0;
    let at = assembly.configuration(&x, &ACTIVATIONS).unwrap();
    assert_eq!(assembly.energy(at), f64::INFINITY);
    let element = assembly.element_outside_domain(at).unwrap();
    assert!(assembly.volume_ratios(at).unwrap()[element] <= 0.0);
}
