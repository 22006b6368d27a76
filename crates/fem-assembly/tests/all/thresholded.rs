//! The threshold of document 000, 5.5 over whole bodies: what a builder lifts is what the wrapped material
//! computes element by element.

use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, Fiber, Quasistatic};
use fem_materials::curves::PhysBam;
use fem_materials::field::At;
use fem_materials::inversion::{Threshold, Thresholded};
use fem_materials::{FiberLaw, FiberTerm, HessianProjection, NeoHookean, Stretch};
use fem_solvers::{BlockSymmetric, LinearOperator, Merit, NonlinearProblem};

const FLESH: NeoHookean = NeoHookean {
    mu: 1e4,
    lambda: 4e4,
};
const LEAST: f64 = 0.25;
const ACTIVATION: f64 = 0.4;

fn law() -> FiberLaw<PhysBam> {
    FiberLaw {
        curve: PhysBam::default(),
        stretch: Stretch::Isochoric,
    }
}

/// One fiber in every other element.
fn fibers(mesh: &SimplexMesh<3>) -> Vec<Fiber> {
    let fiber = |element: usize| Fiber {
        element,
        control: 0,
        direction: [0.6, 0.0, 0.8],
        max_isometric_stress: 3e4,
        optimal_stretch: 1.1,
    };
    (0..mesh.num_elements()).step_by(2).map(fiber).collect()
}

fn builder(mesh: &SimplexMesh<3>) -> AssemblyBuilder<3> {
    let held: Vec<usize> = (0..mesh.num_nodes())
        .filter(|&n| mesh.nodes()[n][2] == 0.0)
        .collect();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &held).unwrap();
    AssemblyBuilder::new(mesh, dofs).unwrap()
}

fn lifted(mesh: &SimplexMesh<3>) -> Assembly<3> {
    let threshold = Threshold::new(LEAST).unwrap();
    let flesh = builder(mesh).thresholded(threshold, |builder| {
        builder.material(FLESH)?.fibers(law(), 1, &fibers(mesh))
    });
    flesh.unwrap().build().unwrap()
}

/// The same by the wrapper around each material, each fiber with its activation a material of its own.
fn wrapped(mesh: &SimplexMesh<3>, activation: f64) -> Assembly<3> {
    let flesh = Thresholded::new(FLESH, LEAST).unwrap();
    let mut builder = builder(mesh).material(flesh).unwrap().controls(1);
    for fiber in fibers(mesh) {
        let local = FiberTerm {
            direction: fiber.direction,
            max_isometric_stress: fiber.max_isometric_stress,
            optimal_stretch: fiber.optimal_stretch,
            activation,
        };
        let field = law();
        let one = Thresholded::new(At { field, local }, LEAST).unwrap();
        builder = builder.region(&[fiber.element], one).unwrap();
    }
    builder.build().unwrap()
}

/// Some elements squeezed, some inside out, some as good as at rest.
fn crumpled(mesh: &SimplexMesh<3>) -> Vec<[f64; 3]> {
    let wave = |n: usize, phase: f64| (1.7 * n as f64 + phase).sin();
    let moved = |(n, p): (usize, &[f64; 3])| {
        let size = 0.45 * p[0];
        [
            p[0] + size * wave(n, 0.3),
            p[1] + size * wave(n, 1.1),
            p[2] + size * wave(n, 2.9),
        ]
    };
    mesh.nodes().iter().enumerate().map(moved).collect()
}

fn near(a: &[f64], b: &[f64], what: &str) {
    let size = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(size > 0.0 && a.len() == b.len(), "{what}");
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= 1e-12 * size, "{what}: {a} {b}");
    }
}

#[test]
fn a_lifted_body_is_that_of_the_wrapped_material_and_its_fibers() {
    let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
    let (body, other) = (lifted(&mesh), wrapped(&mesh, ACTIVATION));
    let x = crumpled(&mesh);
    let at = body.configuration(&x, &[ACTIVATION]).unwrap();
    let ratios = body.volume_ratios(at).unwrap();
    let count = |f: &dyn Fn(f64) -> bool| ratios.iter().filter(|r| f(**r)).count();
    assert!(
        count(&|r| r < 0.0) > 3 && count(&|r| r > 0.5) > 3,
        "{ratios:?}"
    );
    near(&[body.energy(at)], &[other.energy(at)], "energy");
    let [here, there] = [&body, &other].map(|b| b.forces_everywhere(at));
    near(here.as_flattened(), there.as_flattened(), "forces");
    let direction: Vec<[f64; 3]> = (0..x.len())
        .map(|n| [0.0, 1.0, 2.0].map(|phase| (0.9 * n as f64 + phase).cos()))
        .collect();
    let [here, there] =
        [&body, &other].map(|b| b.hessian_vector_everywhere(at, &direction).unwrap());
    near(here.as_flattened(), there.as_flattened(), "product");
    let free = body.dofs().gather(&direction).unwrap();
    for projection in [
        HessianProjection::None,
        HessianProjection::Clamp,
        HessianProjection::Absolute,
    ] {
        let [here, there] = [&body, &other].map(|b| {
            let mut matrix = BlockSymmetric::zeros(b.pattern().clone());
            b.hessian(at, projection, &mut matrix);
            let mut product = vec![0.0; free.len()];
            matrix.apply(&free, &mut product);
            product
        });
        near(&here, &there, "Hessian");
    }
    // Forces are affine in the activation.
    let mut column = vec![0.0; free.len()];
    body.control_gradient(at, 0, &mut column).unwrap();
    let [relaxed, tense] = [0.0, 1.0].map(|a| {
        let mut gradient = vec![0.0; free.len()];
        wrapped(&mesh, a).gradient(at, &mut gradient).unwrap();
        gradient
    });
    let slope: Vec<f64> = tense.iter().zip(&relaxed).map(|(t, r)| t - r).collect();
    near(&column, &slope, "column");
}

#[test]
fn above_the_threshold_nothing_changes_and_the_residual_is_what_must_fall() {
    let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
    let plain = builder(&mesh).material(FLESH).unwrap().build().unwrap();
    let threshold = Threshold::new(LEAST).unwrap();
    let body = builder(&mesh).thresholded(threshold, |b| b.material(FLESH));
    let body = body.unwrap().build().unwrap();
    let x: Vec<[f64; 3]> = (mesh.nodes().iter())
        .map(|p| [1.1 * p[0] + 0.2 * p[2], p[1], 0.7 * p[2]])
        .collect();
    let at = body.configuration(&x, &[]).unwrap();
    let [here, there] = [&body, &plain].map(|b| b.forces_everywhere(at));
    near(here.as_flattened(), there.as_flattened(), "forces");
    let merit = |b: &Assembly<3>| Quasistatic::new(b, x.clone(), vec![]).unwrap().merit();
    assert_eq!(merit(&body), Merit::ResidualNorm);
    assert_eq!(merit(&plain), Merit::Energy);
    // Only what was added inside is lifted.
    let outside = builder(&mesh).thresholded(threshold, |b| b.controls(0).region(&[], FLESH));
    let outside = outside.unwrap().material(FLESH).unwrap().build().unwrap();
    let inverted = crumpled(&mesh);
    let energy = |b: &Assembly<3>| b.energy(b.configuration(&inverted, &[]).unwrap());
    assert!(energy(&body).is_finite());
    assert_eq!(energy(&outside), f64::INFINITY);
}
