//! Triangles solved to equilibrium: the same code as tetrahedra, one dimension less.

use super::random::{Random, Triangles};
use crate::promise::Newton;
use approx::assert_relative_eq;
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, Quasistatic};
use fem_materials::inversion::Thresholded;
use fem_materials::isotropic::ByStretches;
use fem_materials::{CorotatedLinear, HessianProjection, Material, NeoHookean};
use fem_solvers::{
    AssumedPositiveDefinite, BlockSymmetric, Identity, LinearOperator, LinearSolver, Merit,
    NewtonFailure, NewtonParams, PcgParams, PreconditionerChoice, Structure, pcg,
};
use proptest::prelude::*;

const FLESH: NeoHookean = NeoHookean {
    mu: 3e3,
    lambda: 7e3,
};

fn tight(linear_solver: LinearSolver) -> NewtonParams {
    NewtonParams {
        linear_solver,
        relative_gradient_tolerance: 1e-12,
        ..NewtonParams::default()
    }
}

fn boundary(mesh_nodes: &[[f64; 2]]) -> Vec<usize> {
    let on_edge = |p: &[f64; 2]| p.iter().any(|&c| c == 0.0 || c == 1.0);
    (0..mesh_nodes.len())
        .filter(|&n| on_edge(&mesh_nodes[n]))
        .collect()
}

fn patch_test(material: impl Material<2> + 'static) {
    let mesh = Triangles::new(5, 4).mesh();
    let rest = mesh.nodes();
    let affine = |p: &[f64; 2]| {
        [
            1.3 * p[0] + 0.4 * p[1] - 0.2,
            -0.3 * p[0] + 0.8 * p[1] + 0.1,
        ]
    };
    let prescribed = boundary(rest);
    let dofs = Dofs::with_prescribed_nodes(rest, &prescribed).unwrap();
    let body = AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(material)
        .unwrap()
        .build()
        .unwrap();
    let mut random = Random(4);
    let start: Vec<[f64; 2]> = rest
        .iter()
        .enumerate()
        .map(|(n, p)| {
            let exact = affine(p);
            if prescribed.contains(&n) {
                exact
            } else {
                random.near(&exact, 0.03)
            }
        })
        .collect();
    let problem = Quasistatic::new(&body, start, vec![]).unwrap();
    let mut x = problem.unknowns();
    let params = tight(LinearSolver::Auto);
    Newton::new(&problem)
        .solve(&problem, &mut x, &params)
        .unwrap();
    for (p, q) in rest.iter().zip(problem.positions(&x).unwrap()) {
        let exact = affine(p);
        let apart = (0..2).fold(0.0_f64, |m, k| m.max((q[k] - exact[k]).abs()));
        assert!(apart <= 1e-11, "{apart:e}");
    }
}

#[test]
fn a_uniform_stretch_of_the_boundary_stretches_all_triangles_alike() {
    patch_test(FLESH);
    patch_test(ByStretches(CorotatedLinear {
        mu: 3e3,
        lambda: 7e3,
    }));
}

/// The square on rollers, pulled to 1.5: plane neo-Hookean with P₂₂ = 0.
fn pulled_square() -> (Assembly<2>, Vec<[f64; 2]>) {
    let mesh = Triangles::new(6, 6).mesh();
    let rest = mesh.nodes();
    let rollers: Vec<(usize, usize)> = (0..rest.len())
        .flat_map(|n| {
            let [x, y] = rest[n];
            let side = (x == 0.0 || x == 1.0).then_some((n, 0));
            side.into_iter().chain((y == 0.0).then_some((n, 1)))
        })
        .collect();
    let dofs = Dofs::new(rest, &[], &rollers).unwrap();
    let body = AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(FLESH)
        .unwrap()
        .build()
        .unwrap();
    let start = rest.iter().map(|p| [1.5 * p[0], p[1]]).collect();
    (body, start)
}

/// μ (s − 1/s) + λ ln(1.5 s)/s = 0 for the lateral stretch s.
fn lateral_stretch() -> f64 {
    let (mut low, mut high) = (0.5_f64, 1.0);
    for _ in 0..100 {
        let s = 0.5 * (low + high);
        let P22 = FLESH.mu * (s - 1.0 / s) + FLESH.lambda * (1.5 * s).ln() / s;
        if P22 < 0.0 { low = s } else { high = s }
    }
    low
}

#[test]
fn a_pulled_square_thins_as_the_closed_form_says_with_every_linear_solver() {
    let (body, start) = pulled_square();
    let s = lateral_stretch();
    let pull = FLESH.mu * (1.5 - 1.0 / 1.5) + FLESH.lambda * (1.5 * s).ln() / 1.5;
    let pcg = |preconditioner| LinearSolver::Pcg {
        preconditioner,
        max_iterations: 2000,
    };
    for solver in [
        LinearSolver::Direct,
        LinearSolver::QrLeastSquares,
        pcg(PreconditionerChoice::Identity),
        pcg(PreconditionerChoice::BlockJacobi),
        pcg(PreconditionerChoice::BlockIc0),
    ] {
        let problem = Quasistatic::new(&body, start.clone(), vec![]).unwrap();
        let mut x = problem.unknowns();
        let info = Newton::new(&problem)
            .solve(&problem, &mut x, &tight(solver))
            .unwrap();
        assert!(info.iterations < 12, "{solver:?}: {info:?}");
        let shape = problem.positions(&x).unwrap();
        for (p, q) in body.rest().iter().zip(&shape) {
            let apart = (q[0] - 1.5 * p[0]).abs().max((q[1] - s * p[1]).abs());
            assert!(apart <= 1e-10, "{solver:?}: {apart:e}");
        }
        let forces = body.forces_everywhere(body.configuration(&shape, &[]).unwrap());
        let right: f64 = body
            .rest()
            .iter()
            .zip(&forces)
            .filter(|(p, _)| p[0] == 1.0)
            .map(|(_, f)| f[0])
            .sum();
        assert_relative_eq!(right, -pull, max_relative = 1e-9);
    }
}

/// The Hessian as nothing but its product.
struct Product<'a>(&'a Assembly<2>, &'a [[f64; 2]]);

impl LinearOperator for Product<'_> {
    fn dim(&self) -> usize {
        self.0.dofs().vector_len()
    }
    fn structure(&self) -> Structure {
        Structure::Symmetric
    }
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let mut displacement = vec![[0.0; 2]; self.1.len()];
        self.0.dofs().scatter(x, &mut displacement).unwrap();
        let at = self.0.configuration(self.1, &[]).unwrap();
        self.0.hessian_vector(at, &displacement, y).unwrap();
    }
}

#[test]
fn conjugate_gradients_on_the_product_alone_give_the_dense_newton_step() {
    let mesh = Triangles::new(6, 5).mesh();
    let rest = mesh.nodes();
    let prescribed: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][0] == 0.0).collect();
    let dofs = Dofs::with_prescribed_nodes(rest, &prescribed).unwrap();
    let body = AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(FLESH)
        .unwrap()
        .build()
        .unwrap();
    let mut random = Random(8);
    let x: Vec<[f64; 2]> = rest
        .iter()
        .map(|p| random.near(&[1.1 * p[0], p[1]], 0.01))
        .collect();
    let n = body.dofs().vector_len();
    let mut gradient = vec![0.0; n];
    body.gradient(body.configuration(&x, &[]).unwrap(), &mut gradient)
        .unwrap();
    let rhs: Vec<f64> = gradient.iter().map(|g| -g).collect();

    let mut hessian = BlockSymmetric::zeros(body.pattern().clone());
    body.hessian(
        body.configuration(&x, &[]).unwrap(),
        HessianProjection::None,
        &mut hessian,
    );
    let dense = gauss(hessian.to_dense(), rhs.clone());
    let operator = Product(&body, &x);
    let params = PcgParams {
        relative_tolerance: 1e-13,
        ..PcgParams::default()
    };
    let mut step = vec![0.0; n];
    pcg(
        &AssumedPositiveDefinite(&operator),
        &Identity,
        &rhs,
        &mut step,
        &params,
    )
    .unwrap();
    let size = dense.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for (a, b) in step.iter().zip(&dense) {
        assert!((a - b).abs() <= 1e-10 * size, "{a} {b}");
    }
}

/// Gaussian elimination with partial pivoting, rows of A one after the other.
fn gauss(mut A: Vec<f64>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n)
            .max_by(|&p, &q| A[p * n + k].abs().total_cmp(&A[q * n + k].abs()))
            .unwrap();
        for j in 0..n {
            A.swap(k * n + j, pivot * n + j);
        }
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = A[i * n + k] / A[k * n + k];
            for j in k..n {
                A[i * n + j] -= factor * A[k * n + j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| A[k * n + j] * b[j]).sum();
        b[k] = (b[k] - known) / A[k * n + k];
    }
    b
}

/// Document 000, 5.5: the threshold on F̂ (positive, PhysBAM's 0.25) gives an inverted element a force
/// that turns it back; Newton's method on the forces alone, since that stress has no energy.
#[test]
fn an_inverted_triangle_recovers_with_the_threshold_of_the_documents() {
    let mesh = Triangles::new(4, 4).mesh();
    let rest = mesh.nodes();
    let prescribed = boundary(rest);
    let dofs = Dofs::with_prescribed_nodes(rest, &prescribed).unwrap();
    let builder = || AssemblyBuilder::new(&mesh, dofs.clone()).unwrap();
    let material = Thresholded::new(FLESH, 0.25).unwrap();
    let body = builder().material(material).unwrap().build().unwrap();
    let mut start = rest.to_vec();
    let middle = rest.iter().position(|p| *p == [0.5, 0.5]).unwrap();
    start[middle] = [0.86, 0.62];
    let ratios = body.volume_ratios(body.positions(&start).unwrap()).unwrap();
    assert!(ratios.iter().any(|&J| J < -0.1));
    let params = tight(LinearSolver::Direct);

    // ln J alone refuses.
    let bare = builder().material(FLESH).unwrap().build().unwrap();
    let problem = Quasistatic::new(&bare, start.clone(), vec![]).unwrap();
    let refused = Newton::new(&problem).solve(&problem, &mut problem.unknowns(), &params);
    assert!(matches!(
        refused.unwrap_err().reason,
        NewtonFailure::OutsideDomain { .. }
    ));

    let problem = Quasistatic::new(&body, start, vec![])
        .unwrap()
        .with_merit(Merit::ResidualNorm);
    let mut x = problem.unknowns();
    Newton::new(&problem)
        .solve(&problem, &mut x, &params)
        .unwrap();
    for (p, q) in rest.iter().zip(problem.positions(&x).unwrap()) {
        assert!((p[0] - q[0]).abs().max((p[1] - q[1]).abs()) <= 1e-9);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Whatever the triangles look like: no energy and no force can tell a rotation and a shift, and
    /// forces turn along.
    #[test]
    fn a_moved_body_feels_nothing_of_it(seed: u64, angle in -4.0..4.0, shift in -3.0..3.0) {
        let mesh = Triangles::new(3, 2).mesh();
        let dofs = Dofs::all_free(mesh.nodes()).unwrap();
        let body = AssemblyBuilder::new(&mesh, dofs).unwrap().material(FLESH).unwrap().build().unwrap();
        let mut random = Random(seed);
        let x: Vec<[f64; 2]> = mesh.nodes().iter().map(|p| random.near(p, 0.12)).collect();
        prop_assume!(body.volume_ratios(body.positions(&x).unwrap()).unwrap().iter().all(|&J| J > 0.05));
        let (s, c) = f64::sin_cos(angle);
        let turn = |p: [f64; 2]| [c * p[0] - s * p[1], s * p[0] + c * p[1]];
        let moved: Vec<[f64; 2]> = x.iter().map(|&p| turn(p).map(|k| k + shift)).collect();
        let (here, there) = (body.energy(body.configuration(&x, &[]).unwrap()), body.energy(body.configuration(&moved, &[]).unwrap()));
        prop_assert!(approx::relative_eq!(here, there, max_relative = 1e-11));
        let forces = body.forces_everywhere(body.configuration(&x, &[]).unwrap());
        let scale = forces.iter().flatten().fold(0.0_f64, |m, f| m.max(f.abs()));
        for (f, g) in forces.into_iter().zip(body.forces_everywhere(body.configuration(&moved, &[]).unwrap())) {
            let f = turn(f);
            prop_assert!((f[0] - g[0]).abs().max((f[1] - g[1]).abs()) <= 1e-11 * scale);
        }
    }
}
