//! What an assembly evaluates, counted by a material and a tension curve that count.

use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, Fiber};
use fem_kinematics::{Mat, Pack, PackedKernel, Real, Tensor4, dispatch_packed};
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
static PROJECTED: AtomicUsize = AtomicUsize::new(0);
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
    fn projected_derivative<T: Real>(
        &self,
        F: &Mat<T, 3>,
        projection: HessianProjection,
    ) -> Tensor4<T, 3> {
        add(&PROJECTED);
        FLESH.projected_derivative(F, projection)
    }
}

/// Passive tension is there or not.
#[derive(Clone, Copy)]
struct CountingCurve {
    passive: bool,
}

impl TensionCurve for CountingCurve {
    fn active<T: Real>(&self, l: T) -> CurvePoint<T> {
        add(&PULLS);
        PhysBam::default().active(l)
    }
    fn passive<T: Real>(&self, l: T) -> CurvePoint<T> {
        match self.passive {
            true => PhysBam::default().passive(l),
            false => CurvePoint::default(),
        }
    }
    fn has_passive(&self) -> bool {
        self.passive
    }
}

/// How many of a batch's eight elements are evaluated at once here.
struct Width;

impl PackedKernel for Width {
    type Output = usize;
    fn run<V: Pack>(self) -> usize {
        V::WIDTH
    }
}

/// The counters since the last call: energy, stress, differential, derivative, projected, pulls.
fn taken() -> [usize; 6] {
    [
        &ENERGIES,
        &STRESSES,
        &DIFFERENTIALS,
        &DERIVATIVES,
        &PROJECTED,
        &PULLS,
    ]
    .map(|c| c.swap(0, Relaxed))
}

#[test]
fn no_derivative_and_no_fiber_is_evaluated_that_nobody_asked_for() {
    // 48 tetrahedra, six batches of eight; fibers in five of them, one batch.
    let each = 8 / dispatch_packed(Width);
    let all = 6 * each;
    // Where no registers are, gradients and Hessians take the fibers one by one.
    let alone = each == 8;
    let of_fibers = if alone { 5 } else { each };
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
    let body_with = |passive, stretch| {
        let curve = CountingCurve { passive };
        let law = FiberLaw { curve, stretch };
        let builder = AssemblyBuilder::new(&mesh, Dofs::all_free(rest).unwrap()).unwrap();
        let builder = builder.material(Counting).unwrap();
        let builder = builder.fibers(law, 1, &fibers).unwrap();
        builder.build().unwrap()
    };
    let body = body_with(true, Stretch::Total);
    let x: Vec<[f64; 3]> = rest.iter().map(|p| [1.1 * p[0], p[1], p[2]]).collect();
    let mut rows = vec![0.0; body.dofs().vector_len()];
    let mut hessian = BlockSymmetric::zeros(body.pattern().clone());
    taken();

    body.energy(body.configuration(&x, &[0.5]).unwrap());
    assert_eq!(taken(), [all, 0, 0, 0, 0, each], "an energy");
    body.gradient(body.configuration(&x, &[0.5]).unwrap(), &mut rows)
        .unwrap();
    assert_eq!(
        taken(),
        [all, all, 0, 0, 0, of_fibers],
        "a gradient, with its energy"
    );
    body.hessian_vector(body.configuration(&x, &[0.5]).unwrap(), &x, &mut rows)
        .unwrap();
    assert_eq!(taken(), [0, 0, all, 0, 0, each], "a product");
    body.hessian(
        body.configuration(&x, &[0.5]).unwrap(),
        HessianProjection::None,
        &mut hessian,
    );
    let by_projection = [0, 0, 0, 0, all, of_fibers];
    let exactly = [0, 0, 0, all, 0, of_fibers];
    let hessian_takes = if alone { by_projection } else { exactly };
    assert_eq!(taken(), hessian_takes, "a Hessian");
    body.control_gradient(body.configuration(&x, &[0.5]).unwrap(), 0, &mut rows)
        .unwrap();
    assert_eq!(taken(), [0, 0, 0, 0, 0, each], "the force of a muscle");
    body.volume_ratios(body.positions(&x).unwrap()).unwrap();
    assert_eq!(taken(), [0; 6], "volumes");

    let mut pulls_of_relaxed = |body: &Assembly<3>| {
        let at = body.configuration(&x, &[0.0]).unwrap();
        body.energy(at);
        body.gradient(at, &mut rows).unwrap();
        body.hessian_vector(at, &x, &mut rows).unwrap();
        for projection in [HessianProjection::None, HessianProjection::Clamp] {
            body.hessian(at, projection, &mut hessian);
        }
        let [.., pulls] = taken();
        body.control_gradient(at, 0, &mut rows).unwrap();
        (pulls, taken())
    };
    // A projected Hessian takes its five fibers one by one.
    let force = [0, 0, 0, 0, 0, each];
    let passive = 2 * each + 2 * of_fibers + 5;
    assert_eq!(pulls_of_relaxed(&body), (passive, force));
    let nothing = body_with(false, Stretch::Total);
    assert_eq!(pulls_of_relaxed(&nothing), (0, force));
    // Inside out this one has no energy but +∞.
    let walled = body_with(false, Stretch::Isochoric);
    assert_eq!(pulls_of_relaxed(&walled), (passive, force));
}
