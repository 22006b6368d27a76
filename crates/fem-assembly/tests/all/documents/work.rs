//! What an assembly evaluates, counted by a material and a tension curve that count.

use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs, Fiber};
use fem_kinematics::{Mat, Real, Tensor4};
use fem_materials::curves::{CurvePoint, PhysBam, TensionCurve};
use fem_materials::{FiberLaw, HessianProjection, Material, NeoHookean, Stretch};
use fem_solvers::BlockSymmetric;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

const FLESH: NeoHookean = NeoHookean {
    mu: 1e3,
    lambda: 4e3,
};
static ENERGIES: AtomicUsize = AtomicUsize::new(0);
static STRESSES: AtomicUsize = AtomicUsize::new(0);
static DIFFERENTIALS: AtomicUsize = AtomicUsize::new(0);
static DERIVATIVES: AtomicUsize = AtomicUsize::new(0);
static FILTERED: AtomicUsize = AtomicUsize::new(0);
static PULLS: AtomicUsize = AtomicUsize::new(0);

fn add(counter: &AtomicUsize) {
    counter.fetch_add(1, Relaxed);
}

#[derive(Clone, Copy)]
struct Counting;

impl Material<3> for Counting {
    fn energy<T: Real>(&self, F: &Mat<T, 3>) -> T {
        add(&ENERGIES);
        FLESH.energy(F)
    }
    fn stress<T: Real>(&self, F: &Mat<T, 3>) -> Mat<T, 3> {
        add(&STRESSES);
        FLESH.stress(F)
    }
    fn stress_differential<T: Real>(&self, F: &Mat<T, 3>, dF: &Mat<T, 3>) -> Mat<T, 3> {
        add(&DIFFERENTIALS);
        FLESH.stress_differential(F, dF)
    }
    fn stress_derivative<T: Real>(&self, F: &Mat<T, 3>) -> Tensor4<T, 3> {
        add(&DERIVATIVES);
        FLESH.stress_derivative(F)
    }
    fn filtered_derivative<T: Real>(
        &self,
        F: &Mat<T, 3>,
        filter: HessianProjection,
    ) -> Tensor4<T, 3> {
        add(&FILTERED);
        FLESH.filtered_derivative(F, filter)
    }
}

#[derive(Clone, Copy)]
struct CountingCurve;

impl TensionCurve for CountingCurve {
    fn active<T: Real>(&self, l: T) -> CurvePoint<T> {
        add(&PULLS);
        PhysBam::default().active(l)
    }
    fn passive<T: Real>(&self, l: T) -> CurvePoint<T> {
        PhysBam::default().passive(l)
    }
}

/// The counters since the last call: energy, stress, differential, derivative, filtered, pulls.
fn taken() -> [usize; 6] {
    [
        &ENERGIES,
        &STRESSES,
        &DIFFERENTIALS,
        &DERIVATIVES,
        &FILTERED,
        &PULLS,
    ]
    .map(|c| c.swap(0, Relaxed))
}

#[test]
fn no_derivative_and_no_fiber_is_evaluated_that_nobody_asked_for() {
    // 48 tetrahedra, six packs of eight; fibers in five of them, one pack.
    let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
    let rest = mesh.nodes();
    let fibers: Vec<Fiber> = (0..5)
        .map(|element| Fiber {
            element,
            control: 0,
            direction: [0.0, 0.6, 0.8],
            max_isometric_stress: 1e3,
            optimal_stretch: 1.0,
        })
        .collect();
    let law = FiberLaw {
        curve: CountingCurve,
        stretch: Stretch::Total,
    };
    let body = AssemblyBuilder::new(&mesh, Dofs::all_free(rest).unwrap())
        .unwrap()
        .material(Counting)
        .unwrap()
        .fibers(law, 1, &fibers)
        .unwrap()
        .build()
        .unwrap();
    let x: Vec<[f64; 3]> = rest.iter().map(|p| [1.1 * p[0], p[1], p[2]]).collect();
    let mut rows = vec![0.0; body.dofs().vector_len()];
    let mut hessian = BlockSymmetric::zeros(body.pattern().clone());
    taken();

    body.energy(body.configuration(&x, &[0.5]).unwrap());
    assert_eq!(taken(), [6, 0, 0, 0, 0, 1], "an energy");
    body.gradient(body.configuration(&x, &[0.5]).unwrap(), &mut rows);
    assert_eq!(taken(), [6, 6, 0, 0, 0, 1], "a gradient, with its energy");
    body.hessian_vector(body.configuration(&x, &[0.5]).unwrap(), &x, &mut rows);
    assert_eq!(taken(), [0, 0, 6, 0, 0, 1], "a product");
    body.hessian(
        body.configuration(&x, &[0.5]).unwrap(),
        HessianProjection::None,
        &mut hessian,
    );
    assert_eq!(taken(), [0, 0, 0, 6, 0, 1], "a Hessian");
    body.control_gradient(body.configuration(&x, &[0.5]).unwrap(), 0, &mut rows);
    assert_eq!(taken(), [0, 0, 0, 0, 0, 1], "the force of a muscle");
    body.volume_ratios(body.positions(&x).unwrap());
    assert_eq!(taken(), [0; 6], "volumes");
}
