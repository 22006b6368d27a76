//! Quadratic triangles and tetrahedra: patch test, order of convergence against a manufactured
//! solution, derivatives with fibers in them, stiffness fields, other numbers of threads.
#![allow(non_snake_case)]

use crate::promise::Newton;
use fem_assembly::mesh::{QuadraticMesh, SimplexMesh, kuhn_grid};
use fem_assembly::{
    Assembly, AssemblyBuilder, AssemblyError, Dofs, Fiber, Gravity, NodalLoads, Quasistatic,
};
use fem_kinematics::Mat;
use fem_materials::curves::PhysBam;
use fem_materials::{
    FiberLaw, HessianProjection, Lame, Material, NeoHookean, Space, StVenantKirchhoff, Stretch,
};
use fem_solvers::{BlockSymmetric, NewtonParams};

const FLESH: NeoHookean = NeoHookean {
    mu: 1e3,
    lambda: 4e3,
};

/// The unit square in 2 n² triangles.
fn square(n: usize) -> SimplexMesh<2> {
    let at = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    let step = 1.0 / n as f64;
    let nodes = (0..(n + 1) * (n + 1)).map(|k| [k / (n + 1), k % (n + 1)].map(|i| step * i as f64));
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        triangles.extend([a, b, c, a, c, d]);
    }
    SimplexMesh::new(nodes.collect(), triangles).unwrap()
}

fn cube(n: usize) -> SimplexMesh<3> {
    kuhn_grid(n, n, n, [1.0; 3]).unwrap()
}

fn boundary<const D: usize>(nodes: &[[f64; D]]) -> Vec<usize> {
    let outside = |x: &[f64; D]| x.iter().any(|c| !(1e-12..=1.0 - 1e-12).contains(c));
    (0..nodes.len()).filter(|&n| outside(&nodes[n])).collect()
}

fn solved<const D: usize>(body: &Assembly<D>, start: Vec<[f64; D]>) -> Vec<[f64; D]> {
    let problem = Quasistatic::new(body, start, vec![0.0; body.controls()]).unwrap();
    let mut x = problem.unknowns();
    let params = NewtonParams {
        relative_gradient_tolerance: 1e-12,
        ..NewtonParams::default()
    };
    Newton::new(&problem)
        .solve(&problem, &mut x, &params)
        .unwrap();
    problem.positions(&x).unwrap()
}

fn patch<const D: usize>(body: &Assembly<D>) {
    let rest = body.rest().to_vec();
    let exact = |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|i| {
            let slope = |j: usize| 0.1 * ((3 * i + 2 * j) as f64).sin();
            x[i] + (0..D).map(|j| slope(j) * x[j]).sum::<f64>()
        })
    };
    let inner: Vec<bool> = (0..rest.len())
        .map(|n| body.dofs().row(n).is_some())
        .collect();
    let start = rest.iter().zip(&inner).enumerate().map(|(n, (x, &inner))| {
        let wiggle = if inner { 0.01 * (n as f64).sin() } else { 0.0 };
        exact(x).map(|c| c + wiggle)
    });
    let shape = solved(body, start.collect());
    for (x, y) in rest.iter().zip(shape) {
        let exact = exact(x);
        for i in 0..D {
            assert!((y[i] - exact[i]).abs() < 1e-12, "{y:?} against {exact:?}");
        }
    }
}

#[test]
fn a_uniform_stretch_of_the_boundary_stretches_all_elements_alike() {
    let plane = QuadraticMesh::from_linear(&square(3)).unwrap();
    let dofs = Dofs::with_prescribed_nodes(plane.nodes(), &boundary(plane.nodes())).unwrap();
    let builder = AssemblyBuilder::quadratic(&plane, dofs).unwrap();
    patch(&builder.material(FLESH).unwrap().build().unwrap());
    let solid = QuadraticMesh::from_linear(&cube(2)).unwrap();
    let dofs = Dofs::with_prescribed_nodes(solid.nodes(), &boundary(solid.nodes())).unwrap();
    let builder = AssemblyBuilder::quadratic(&solid, dofs).unwrap();
    patch(&builder.material(FLESH).unwrap().build().unwrap());
}

/// x = X + u with a smooth u that no element contains.
fn shape_wanted<const D: usize>(X: [f64; D]) -> [f64; D] {
    std::array::from_fn(|i| {
        let (a, b) = (X[i], X[(i + 1) % D]);
        X[i] + 0.06 * (2.0 * a + 0.5 * i as f64).sin() * (1.5 * b).cos()
    })
}

fn gradient_wanted<const D: usize>(X: [f64; D]) -> Mat<f64, D> {
    let mut F = Mat::identity();
    for i in 0..D {
        let j = (i + 1) % D;
        let phase = 2.0 * X[i] + 0.5 * i as f64;
        F.0[i][i] += 0.12 * phase.cos() * (1.5 * X[j]).cos();
        F.0[i][j] -= 0.09 * phase.sin() * (1.5 * X[j]).sin();
    }
    F
}

/// The force per volume that holds the wanted shape: −Div P(F(X)), by differences of order six.
fn force_wanted<const D: usize>(material: &impl Material<D>, X: [f64; D]) -> [f64; D] {
    let h = 3e-3;
    let mut force = [0.0; D];
    for j in 0..D {
        let stress = |k: f64| {
            let mut at = X;
            at[j] += k * h;
            material.stress(&gradient_wanted(at))
        };
        for (k, weight) in [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)] {
            let slope = stress(k) - stress(-k);
            for i in 0..D {
                force[i] -= weight * slope.0[i][j] / h;
            }
        }
    }
    force
}

/// Barycentric points and weights (sum 1) of a rule with four Gauss points along each direction of
/// a simplex whose corners were pulled out of a cube.
fn rule<const D: usize>() -> Vec<(Vec<f64>, f64)> {
    let (a, b) = (0.339_981_043_584_856_3, 0.861_136_311_594_052_6);
    let (p, q) = (0.652_145_154_862_546_1, 0.347_854_845_137_453_9);
    let gauss = [(-b, q), (-a, p), (a, p), (b, q)].map(|(x, w)| (0.5 * (1.0 + x), 0.5 * w));
    let mut points = Vec::new();
    for k in 0..4_usize.pow(D as u32) {
        let (mut left, mut weight, mut at) = (1.0_f64, 1.0_f64, Vec::new());
        for i in 0..D {
            let (t, w): (f64, f64) = gauss[k / 4_usize.pow(i as u32) % 4];
            let power = (D - 1 - i) as i32;
            weight *= w * (1.0 - t).powi(power) * (D - i) as f64;
            at.push(left * t);
            left *= 1.0 - t;
        }
        at.push(left);
        points.push((at, weight));
    }
    points
}

fn shape_functions<const D: usize>(at: &[f64]) -> Vec<f64> {
    let corners = at.iter().map(|l| l * (2.0 * l - 1.0));
    let edges = QuadraticMesh::<D>::edges_of_an_element().iter();
    corners
        .chain(edges.map(|&[a, b]| 4.0 * at[a] * at[b]))
        .collect()
}

/// The rest position, the shape functions and the weight at each point of the rule in an element.
fn points<const D: usize>(
    mesh: &QuadraticMesh<D>,
    element: usize,
) -> Vec<([f64; D], Vec<f64>, f64)> {
    let nodes = mesh.element(element);
    let volume = mesh.corners().volume(element);
    let of = |(at, weight): (Vec<f64>, f64)| {
        let X = std::array::from_fn(|i| (0..=D).map(|a| at[a] * mesh.node(nodes[a])[i]).sum());
        (X, shape_functions::<D>(&at), weight * volume)
    };
    rule::<D>().into_iter().map(of).collect()
}

/// √∫ |x_h − x|² of the solution on a mesh whose boundary has the wanted shape.
fn error_of_displacement<const D: usize>(
    mesh: &QuadraticMesh<D>,
    built: impl Fn(Dofs<D>, NodalLoads<D>) -> Assembly<D>,
    material: &impl Material<D>,
) -> f64 {
    let mut loads = vec![[0.0; D]; mesh.num_nodes()];
    for (e, nodes) in mesh.elements().enumerate() {
        for (X, N, weight) in points(mesh, e) {
            let force = force_wanted(material, X);
            for (&node, N) in nodes.iter().zip(N) {
                for i in 0..D {
                    loads[node as usize][i] += weight * N * force[i];
                }
            }
        }
    }
    let loads = NodalLoads::new(loads.into_iter().enumerate().collect()).unwrap();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &boundary(mesh.nodes())).unwrap();
    let start = mesh.nodes().iter().map(|&X| shape_wanted(X)).collect();
    let shape = solved(&built(dofs, loads), start);
    let mut square = 0.0;
    for (e, nodes) in mesh.elements().enumerate() {
        for (X, N, weight) in points(mesh, e) {
            let wanted = shape_wanted(X);
            for i in 0..D {
                let found: f64 = nodes
                    .iter()
                    .zip(&N)
                    .map(|(&n, N)| N * shape[n as usize][i])
                    .sum();
                square += weight * (found - wanted[i]).powi(2);
            }
        }
    }
    square.sqrt()
}

#[test]
fn displacements_converge_with_the_third_power_of_the_mesh() {
    let plane = |n: usize| {
        let mesh = QuadraticMesh::from_linear(&square(n)).unwrap();
        let built = |dofs, loads| {
            let builder = AssemblyBuilder::quadratic(&mesh, dofs).unwrap();
            let builder = builder.material(FLESH).unwrap().term(loads).unwrap();
            builder.build().unwrap()
        };
        error_of_displacement(&mesh, built, &FLESH)
    };
    let errors = [4, 8, 16].map(plane);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((2.8..3.3).contains(&order), "order {order}: {errors:?}");
    }
    let solid = |n: usize| {
        let mesh = QuadraticMesh::from_linear(&cube(n)).unwrap();
        let built = |dofs, loads| {
            let builder = AssemblyBuilder::quadratic(&mesh, dofs).unwrap();
            let builder = builder.material(FLESH).unwrap().term(loads).unwrap();
            builder.build().unwrap()
        };
        error_of_displacement(&mesh, built, &FLESH)
    };
    let errors = [2, 4, 6].map(solid);
    let order = (errors[1] / errors[2]).ln() / 1.5_f64.ln();
    assert!((2.8..3.3).contains(&order), "order {order}: {errors:?}");
}

/// A bar of quadratic tets with flesh, two muscles through each other and their weight.
fn muscle() -> (Assembly<3>, Vec<[f64; 3]>) {
    let linear = kuhn_grid(2, 3, 2, [1.0, 1.5, 1.0]).unwrap();
    let mesh = QuadraticMesh::from_linear(&linear).unwrap();
    let prescribed: Vec<usize> = (0..mesh.num_nodes())
        .filter(|&n| mesh.nodes()[n][1] == 0.0)
        .collect();
    let dofs = Dofs::new(mesh.nodes(), &prescribed, &[(mesh.num_nodes() - 1, 2)]).unwrap();
    let law = FiberLaw {
        curve: PhysBam::default(),
        stretch: Stretch::Total,
    };
    let fibers: Vec<Fiber> = (0..mesh.num_elements())
        .filter(|e| e % 3 != 1)
        .map(|e| Fiber {
            element: e,
            control: e % 2,
            direction: [0.6 * (e as f64).sin().signum(), 0.8, 0.0],
            max_isometric_stress: 3e3,
            optimal_stretch: 1.0,
        })
        .collect();
    let body = AssemblyBuilder::quadratic(&mesh, dofs)
        .unwrap()
        .material(FLESH)
        .unwrap()
        .fibers(law, 2, &fibers)
        .unwrap()
        .term(Gravity::quadratic(&mesh, 1e3, [0.0, 0.0, -9.81]).unwrap())
        .unwrap()
        .build()
        .unwrap();
    let moved = mesh.nodes().iter().enumerate().map(|(n, p)| {
        let (s, c) = (0.2 * p[1]).sin_cos();
        let wiggle = 0.01 * (n as f64).sin();
        [
            c * p[0] - s * p[2] + wiggle,
            1.15 * p[1] + 0.05 * p[0],
            s * p[0] + c * p[2],
        ]
    });
    (body, moved.collect())
}

const ACTIVATIONS: [f64; 2] = [0.7, 0.3];

fn gradient(body: &Assembly<3>, x: &[[f64; 3]], controls: &[f64]) -> (f64, Vec<f64>) {
    let mut g = vec![0.0; body.dofs().vector_len()];
    let energy = body
        .gradient(body.configuration(x, controls).unwrap(), &mut g)
        .unwrap();
    (energy, g)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Sixth-order central difference at 0.
fn slope(f: impl Fn(f64) -> f64, h: f64) -> f64 {
    let pair = |k: f64| (f(k * h) - f(-k * h)) / h;
    0.75 * pair(1.0) - 0.15 * pair(2.0) + pair(3.0) / 60.0
}

#[test]
fn fibers_in_quadratic_tets_have_the_derivatives_of_their_energy() {
    let (body, x) = muscle();
    let at = body.configuration(&x, &ACTIVATIONS).unwrap();
    let (_, g) = gradient(&body, &x, &ACTIVATIONS);
    let mut free: Vec<f64> = (0..g.len()).map(|i| (7.0 * i as f64).sin()).collect();
    let axes = g.iter().zip(&mut free);
    // The prescribed axis has no force and must not move.
    axes.filter(|(g, _)| **g == 0.0).for_each(|(_, d)| *d = 0.0);
    let length = dot(&g, &g).sqrt();
    let along: Vec<f64> = g.iter().map(|g| g / length).collect();
    for direction in [free, along] {
        let moved = |t: f64| {
            let mut unknowns = body.dofs().gather(&x).unwrap();
            unknowns
                .iter_mut()
                .zip(&direction)
                .for_each(|(u, d)| *u += t * d);
            let mut all = x.clone();
            body.dofs().scatter(&unknowns, &mut all).unwrap();
            all
        };
        let energy_slope = slope(|t| gradient(&body, &moved(t), &ACTIVATIONS).0, 1e-4);
        let exact = dot(&g, &direction);
        assert!((energy_slope - exact).abs() < 1e-7 * exact.abs().max(1.0));

        let mut all = vec![[0.0; 3]; x.len()];
        body.dofs().scatter(&direction, &mut all).unwrap();
        let mut product = vec![0.0; g.len()];
        body.hessian_vector(at, &all, &mut product).unwrap();
        let mut hessian = BlockSymmetric::zeros(body.pattern().clone());
        body.hessian(at, HessianProjection::None, &mut hessian);
        let mut of_matrix = vec![0.0; g.len()];
        fem_solvers::LinearOperator::apply(&hessian, &direction, &mut of_matrix);
        let scale = product.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for i in (0..g.len()).step_by(5) {
            let slope = slope(|t| gradient(&body, &moved(t), &ACTIVATIONS).1[i], 1e-4);
            assert!((slope - product[i]).abs() < 1e-7 * scale, "entry {i}");
            assert!((of_matrix[i] - product[i]).abs() < 1e-12 * scale);
        }
    }
    // Affine in each activation.
    for control in 0..2 {
        let mut by_control = vec![0.0; g.len()];
        body.control_gradient(at, control, &mut by_control).unwrap();
        let mut more = ACTIVATIONS;
        more[control] += 1.0;
        let (_, higher) = gradient(&body, &x, &more);
        let scale = by_control.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(scale > 1.0);
        for i in 0..g.len() {
            assert!((higher[i] - g[i] - by_control[i]).abs() < 1e-12 * scale);
        }
    }
}

#[test]
fn a_projected_quadratic_hessian_is_definite() {
    let (body, x) = muscle();
    // Squashed: the plain Hessian is not definite.
    let squashed: Vec<[f64; 3]> = x.iter().map(|p| [p[0], 0.3 * p[1], p[2]]).collect();
    let at = body.configuration(&squashed, &ACTIVATIONS).unwrap();
    let curvature = |projection| {
        let mut hessian = BlockSymmetric::zeros(body.pattern().clone());
        body.hessian(at, projection, &mut hessian);
        let n = body.dofs().vector_len();
        // The eigenvalue farthest from `shift`, by power iterations.
        let farthest = |shift: f64| {
            let mut v: Vec<f64> = (0..n).map(|i| (3.0 * i as f64).sin()).collect();
            let mut value = 0.0;
            for _ in 0..1000 {
                let mut product = vec![0.0; n];
                fem_solvers::LinearOperator::apply(&hessian, &v, &mut product);
                value = dot(&v, &product);
                let next = v.iter().zip(&product).map(|(v, p)| p - shift * v);
                v = next.collect();
                let length = dot(&v, &v).sqrt();
                v.iter_mut().for_each(|v| *v /= length);
            }
            value
        };
        farthest(farthest(0.0))
    };
    assert!(curvature(HessianProjection::None) < -1.0);
    assert!(curvature(HessianProjection::Clamp) > -1e-9);
}

#[test]
fn one_and_three_threads_give_the_same_bits() {
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let linear = kuhn_grid(6, 6, 6, [1.0; 3]).unwrap();
            let mesh = QuadraticMesh::from_linear(&linear).unwrap();
            let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &[0, 1, 7]).unwrap();
            let builder = AssemblyBuilder::quadratic(&mesh, dofs).unwrap();
            let body = builder.material(FLESH).unwrap().build().unwrap();
            let x: Vec<[f64; 3]> = mesh.nodes().iter().map(|&X| shape_wanted(X)).collect();
            let (energy, g) = gradient(&body, &x, &[]);
            let mut hessian = BlockSymmetric::zeros(body.pattern().clone());
            let at = body.configuration(&x, &[]).unwrap();
            body.hessian(at, HessianProjection::None, &mut hessian);
            let bits = |v: &f64| v.to_bits();
            (
                energy.to_bits(),
                g.iter().map(bits).collect::<Vec<_>>(),
                hessian
                    .values()
                    .as_flattened()
                    .as_flattened()
                    .iter()
                    .map(bits)
                    .collect::<Vec<_>>(),
            )
        })
    };
    assert!(of(1) == of(3));
}

#[test]
fn a_field_of_stiffness_is_the_sum_of_regions_with_their_own_materials() {
    let mesh = kuhn_grid(2, 2, 3, [1.0; 3]).unwrap();
    let elements = mesh.num_elements();
    let young: Vec<f64> = (0..elements).map(|e| 1e3 * (1 + e % 3) as f64).collect();
    let with = |young: f64| {
        let Lame { mu, lambda } = Lame::from_young_poisson(young, 0.4, Space::Solid).unwrap();
        StVenantKirchhoff { mu, lambda }
    };
    let dofs = || Dofs::with_prescribed_nodes(mesh.nodes(), &[0]).unwrap();
    let builder = || AssemblyBuilder::new(&mesh, dofs()).unwrap();
    let field = builder().scaled_material(with(1.0), &young).unwrap();
    let field = field.build().unwrap();
    let regions = (0..3).fold(builder(), |builder, k| {
        let chosen: Vec<usize> = (0..elements).filter(|e| e % 3 == k).collect();
        builder.region(&chosen, with(1e3 * (k + 1) as f64)).unwrap()
    });
    let regions = regions.build().unwrap();
    let x: Vec<[f64; 3]> = mesh.nodes().iter().map(|&X| shape_wanted(X)).collect();
    let (one, g) = gradient(&field, &x, &[]);
    let (other, h) = gradient(&regions, &x, &[]);
    assert!((one - other).abs() < 1e-12 * other);
    for (g, h) in g.iter().zip(&h) {
        assert!((g - h).abs() < 1e-10, "{g} against {h}");
    }
    let refused = builder().scaled_material(with(1.0), &young[1..]);
    assert!(matches!(
        refused.err(),
        Some(AssemblyError::WrongLength { .. })
    ));
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let mut young = young.clone();
        young[5] = bad;
        assert!(
            builder().scaled_material(with(1.0), &young).is_err(),
            "{bad}"
        );
    }
}

#[test]
fn the_weight_of_quadratic_elements_is_that_of_the_body() {
    let (body, x) = muscle();
    let linear = kuhn_grid(2, 3, 2, [1.0, 1.5, 1.0]).unwrap();
    let mesh = QuadraticMesh::from_linear(&linear).unwrap();
    let dofs = Dofs::all_free(mesh.nodes()).unwrap();
    let gravity = Gravity::quadratic(&mesh, 1e3, [0.0, 0.0, -9.81]).unwrap();
    let alone = AssemblyBuilder::quadratic(&mesh, dofs).unwrap();
    let alone = alone.term(gravity).unwrap().build().unwrap();
    let (_, g) = gradient(&alone, body.rest(), &[]);
    let weight: f64 = g.iter().skip(2).step_by(3).sum();
    assert!((weight - 1.5 * 1e3 * 9.81).abs() < 1e-8);
    // E = −ρ g·∫x over the curved shape, for which the rule of four points is exact.
    let (energy, _) = gradient(&alone, &x, &[]);
    let mut exact = 0.0;
    for (e, nodes) in mesh.elements().enumerate() {
        for (_, N, weight) in points(&mesh, e) {
            let height: f64 = nodes
                .iter()
                .zip(N)
                .map(|(&n, N)| N * x[n as usize][2])
                .sum();
            exact += 9.81e3 * weight * height;
        }
    }
    assert!((energy - exact).abs() < 1e-9 * exact.abs());
}
