//! Nobody pays for what a scene does not need: what a solve evaluates, counted and pinned.

use crate::promise::{Newton, solve_renewing};
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{
    Assembly, AssemblyBuilder, Configuration, Dofs, EnergySink, Evaluations, Fiber, FleshContact,
    FleshContactParams, GradientSink, HessianSink, Passes, Quasistatic, Stencils, Term,
};
use fem_kinematics::{HessianProjection, Real};
use fem_materials::curves::{CurvePoint, PhysBam, Tendon, TensionCurve};
use fem_materials::isotropic::ByStretches;
use fem_materials::{CorotatedLinear, FiberLaw, Material, NeoHookean, Stretch};
use fem_solvers::{BlockSymmetric, NewtonParams};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

const FLESH: NeoHookean = NeoHookean {
    mu: 1e4,
    lambda: 4e4,
};

/// A bar whose first layer of cells only prescribed nodes feel, the others stretched.
struct Bar {
    mesh: SimplexMesh<3>,
    dofs: Dofs<3>,
    moved: Vec<[f64; 3]>,
    /// Elements with a free node.
    felt: u64,
}

fn bar(stretch: f64) -> Bar {
    bar_of([6, 2, 2], stretch)
}

/// Of cubes of 1 m.
fn bar_of(cells: [usize; 3], stretch: f64) -> Bar {
    let [long, wide, high] = cells;
    let size = cells.map(|n| n as f64);
    let mesh = kuhn_grid(long, wide, high, size).unwrap();
    let is_prescribed = |p: &[f64; 3]| p[0] <= 1.0 || p[0] == size[0];
    let rest = mesh.nodes();
    let prescribed: Vec<usize> = (0..rest.len())
        .filter(|&n| is_prescribed(&rest[n]))
        .collect();
    let dofs = Dofs::with_prescribed_nodes(rest, &prescribed).unwrap();
    let moved = rest
        .iter()
        .map(|p| [p[0].min(1.0) + stretch * (p[0] - 1.0).max(0.0), p[1], p[2]]);
    let felt = (mesh.connectivity().chunks(4))
        .filter(|element| element.iter().any(|&n| !is_prescribed(&rest[n as usize])))
        .count() as u64;
    Bar {
        moved: moved.collect(),
        dofs,
        felt,
        mesh,
    }
}

impl Bar {
    fn builder(&self) -> AssemblyBuilder<3> {
        AssemblyBuilder::new(&self.mesh, self.dofs.clone()).unwrap()
    }
    fn of(&self, material: impl Material<3> + 'static) -> Assembly<3> {
        self.builder().material(material).unwrap().build().unwrap()
    }
    /// What a solve evaluates.
    fn solve(&self, body: &Assembly<3>) -> Evaluations {
        let controls = vec![0.0; body.controls()];
        let problem = Quasistatic::new(body, self.moved.clone(), controls).unwrap();
        let mut x = problem.unknowns();
        let mut newton = Newton::new(&problem);
        let done = newton.solve(&problem, &mut x, &NewtonParams::default());
        assert!(done.unwrap().iterations > 1);
        newton.evaluated()
    }
}

#[test]
fn each_felt_element_counts_once_in_each_pass_and_no_other() {
    let bar = bar(1.1);
    let all = bar.mesh.connectivity().len() as u64 / 4;
    assert_eq!(all - bar.felt, 24);
    let body = bar.of(FLESH);
    let at = body.configuration(&bar.moved, &[]).unwrap();
    let mut forces = vec![0.0; body.dofs().vector_len()];
    body.gradient(at, &mut forces).unwrap();
    body.free_energy(at);
    body.hessian_vector(at, &vec![[0.0; 3]; bar.moved.len()], &mut forces)
        .unwrap();
    let felt = Passes {
        energies: bar.felt,
        gradients: bar.felt,
        hessians: 0,
        products: bar.felt,
        by_control: 0,
    };
    assert_eq!(body.evaluations().elements, felt);
    let before = body.evaluations();
    body.energy(at);
    body.forces_everywhere(at);
    let since = body.evaluations() - before;
    assert_eq!(
        (since.elements.energies, since.elements.gradients),
        (all, all)
    );
    assert_eq!((since.fibers, since.others), Default::default());
}

#[test]
fn a_definite_solve_of_a_closed_form_decomposes_and_projects_nothing() {
    let bar = bar(1.2);
    let body = bar.of(FLESH);
    let done = bar.solve(&body);
    assert!(done.elements.hessians > bar.felt);
    assert_eq!((done.decompositions, done.projections), (0, 0));
    assert_eq!((done.fibers, done.contacts), Default::default());
    assert_eq!(done.searches, 0);
}

#[test]
fn a_model_of_the_stretches_decomposes_once_for_each_evaluation() {
    let bar = bar(1.2);
    let body = bar.of(ByStretches(CorotatedLinear {
        mu: 1e4,
        lambda: 2e4,
    }));
    let done = bar.solve(&body);
    let Passes {
        energies,
        gradients,
        hessians,
        products,
        ..
    } = done.elements;
    assert_eq!(
        done.decompositions,
        energies + gradients + hessians + products
    );
}

#[test]
fn squashed_flesh_is_projected_and_stretched_flesh_is_not() {
    let projected = |stretch| {
        let bar = bar(stretch);
        let body = bar.of(FLESH);
        let done = bar.solve(&body);
        // An isotropic model is projected in the frame of its stretches.
        assert_eq!(done.decompositions, done.projections);
        done.projections / bar.felt
    };
    assert_eq!(projected(1.2), 0);
    assert!(projected(0.3) > 0);
}

/// Fibers along the bar, each of the muscle that is said.
fn pulled<C>(bar: &Bar, curve: C, fibers: &[(usize, usize)]) -> Assembly<3>
where
    C: TensionCurve + Clone + 'static,
{
    let fiber = |&(element, control): &(usize, usize)| Fiber {
        element,
        control,
        direction: [1.0, 0.0, 0.0],
        max_isometric_stress: 1e5,
        optimal_stretch: 1.0,
    };
    let fibers: Vec<Fiber> = fibers.iter().map(fiber).collect();
    let law = FiberLaw {
        curve,
        stretch: Stretch::Total,
    };
    let builder = bar.builder().material(FLESH).unwrap();
    builder.fibers(law, 2, &fibers).unwrap().build().unwrap()
}

/// Two in elements that only prescribed nodes feel, one of each muscle, and three at the other end, of
/// which one is of the first muscle.
fn some(bar: &Bar) -> [(usize, usize); 5] {
    let last = bar.mesh.connectivity().len() / 4 - 1;
    [(0, 0), (1, 1), (last - 2, 0), (last - 1, 1), (last, 1)]
}

#[test]
fn fibers_are_evaluated_where_there_are_some() {
    let bar = bar(1.1);
    let body = pulled(&bar, PhysBam::default(), &some(&bar));
    let gradients = |controls: [f64; 2]| {
        let at = body.configuration(&bar.moved, &controls).unwrap();
        let before = body.evaluations();
        body.gradient(at, &mut vec![0.0; body.dofs().vector_len()])
            .unwrap();
        let done = body.evaluations() - before;
        assert_eq!(done.elements.gradients, bar.felt);
        done.fibers.gradients
    };
    assert_eq!(gradients([0.5, 0.0]), 3);
    // Relaxed ones have a passive tension.
    assert_eq!(gradients([0.0; 2]), 3);
}

#[test]
fn a_relaxed_fiber_without_passive_tension_is_not_evaluated_and_nothing_changes() {
    let bar = bar(1.1);
    let none = PhysBam {
        P1: 0.0,
        ..PhysBam::default()
    };
    let body = pulled(&bar, none, &some(&bar));
    // The same curve, of which nobody knows that it has no passive tension.
    let unknown = pulled(&bar, Unknown(none), &some(&bar));
    let all = |body: &Assembly<3>, controls: [f64; 2]| {
        let at = body.configuration(&bar.moved, &controls).unwrap();
        let mut gradient = vec![0.0; body.dofs().vector_len()];
        let mut product = gradient.clone();
        let mut hessian = BlockSymmetric::zeros(body.pattern().clone());
        let before = body.evaluations();
        let energy = (body.energy(at), body.gradient(at, &mut gradient).unwrap());
        body.hessian_vector(at, &bar.moved, &mut product).unwrap();
        body.hessian(at, HessianProjection::Clamp, &mut hessian);
        let projected = hessian.values().to_vec();
        body.hessian(at, HessianProjection::None, &mut hessian);
        let forces = body.forces_everywhere(at);
        let sums = (gradient, product, hessian.values().to_vec(), projected);
        let done = body.evaluations() - before;
        (done.fibers, energy, sums, forces)
    };
    // Felt by free nodes, and all.
    for (controls, felt, every) in [([0.0; 2], 0, 0), ([0.5, 0.0], 1, 2), ([0.5, 1.0], 3, 5)] {
        let (counted, energy, sums, forces) = all(&body, controls);
        let expected = Passes {
            energies: every,
            gradients: felt + every,
            hessians: 2 * felt,
            products: felt,
            by_control: 0,
        };
        assert_eq!(counted, expected, "{controls:?}");
        let (evaluated, its_energy, its_sums, its_forces) = all(&unknown, controls);
        assert_eq!((evaluated.energies, evaluated.products), (5, 3));
        assert_eq!((energy, sums), (its_energy, its_sums));
        assert_eq!(forces, its_forces);
    }
}

#[derive(Clone)]
struct Unknown(PhysBam);

impl TensionCurve for Unknown {
    fn active<T: Real>(&self, l: T) -> CurvePoint<T> {
        self.0.active(l)
    }
    fn passive<T: Real>(&self, l: T) -> CurvePoint<T> {
        self.0.passive(l)
    }
}

#[test]
fn a_force_by_a_control_takes_the_stencils_that_listen_to_it() {
    let bar = bar(1.1);
    let counted = |body: &Assembly<3>, controls: &[f64], control| {
        let at = body.configuration(&bar.moved, controls).unwrap();
        let before = body.evaluations();
        body.control_gradient(at, control, &mut vec![0.0; body.dofs().vector_len()])
            .unwrap();
        let done = body.evaluations() - before;
        (done.fibers.by_control, done.elements.by_control)
    };
    let body = pulled(&bar, PhysBam::default(), &some(&bar));
    assert_eq!(counted(&body, &[0.0; 2], 0), (1, 0));
    assert_eq!(counted(&body, &[0.0; 2], 1), (2, 0));
    // Nothing in a ligament listens, also to the control that it names.
    let ligament = pulled(&bar, Tendon { toe: 0.03 }, &some(&bar));
    assert_eq!(counted(&ligament, &[0.0; 2], 0), (0, 0));
    // All of what a control scales.
    let scaled = bar
        .builder()
        .changed_by(0, |builder| builder.material(FLESH));
    let scaled = scaled.unwrap().build().unwrap();
    assert_eq!(counted(&scaled, &[0.0], 0), (0, bar.felt));
}

/// Two cubes of 1 m, the upper one above a gap, and where they are when its top has come down by 0.1.
struct Cubes {
    mesh: SimplexMesh<3>,
    lowered: Vec<[f64; 3]>,
    contact: FleshContact,
}

impl Cubes {
    fn new(gap: f64) -> Self {
        let low = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
        let nodes = low.nodes().iter();
        let high = nodes.clone().map(|p| [p[0], p[1], p[2] + 1.0 + gap]);
        let both: Vec<[f64; 3]> = nodes.copied().chain(high).collect();
        let first = low.num_nodes() as u32;
        let below = low.connectivity().iter().copied();
        let elements = below.chain(low.connectivity().iter().map(|n| n + first));
        let down = |p: &[f64; 3]| match p[2] >= 2.0 + gap {
            true => [p[0], p[1], p[2] - 0.1],
            false => *p,
        };
        let lowered = both.iter().map(down).collect();
        let mesh = SimplexMesh::new(both, elements.collect()).unwrap();
        let params = FleshContactParams {
            activation: 0.05,
            pressure: 1e4,
            depth: 0.3,
            margin: 0.1,
            neighbors: 2,
            edges: true,
        };
        let contact = FleshContact::new(&mesh, &mesh.boundary().faces, params).unwrap();
        Self {
            mesh,
            lowered,
            contact,
        }
    }

    /// Bottom and top are held.
    fn builder(&self) -> AssemblyBuilder<3> {
        let rest = self.mesh.nodes();
        let top = rest.iter().fold(0.0_f64, |top, p| top.max(p[2]));
        let ends = |n: &usize| rest[*n][2] == 0.0 || rest[*n][2] == top;
        let prescribed: Vec<usize> = (0..rest.len()).filter(ends).collect();
        let dofs = Dofs::with_prescribed_nodes(rest, &prescribed).unwrap();
        let builder = AssemblyBuilder::new(&self.mesh, dofs).unwrap();
        builder.material(FLESH).unwrap()
    }
}

#[test]
fn nothing_touches_far_from_a_surface() {
    let touched = |gap: f64| {
        let cubes = Cubes::new(gap);
        let builder = cubes.builder().term(cubes.contact).unwrap();
        let mut body = builder.build().unwrap();
        let start = cubes.lowered;
        let mut newton = Newton::new(&Quasistatic::new(&body, start.clone(), vec![]).unwrap());
        let params = NewtonParams::default();
        solve_renewing(&mut body, &mut newton, start, &[], &params).unwrap();
        newton.evaluated()
    };
    let far = touched(1.0);
    assert!(far.searches > 0 && far.elements.hessians > 0);
    assert_eq!(far.contacts, Passes::default());
    assert!(touched(0.02).contacts.hessians > 0);
}

#[test]
fn a_look_far_from_a_surface_finds_no_pair_and_costs_no_place() {
    let looked = |gap: f64| {
        let mut cubes = Cubes::new(gap);
        let builder = cubes.builder().term(cubes.contact.clone()).unwrap();
        let mut body = builder.build().unwrap();
        // All of the upper cube comes down by 0.15.
        let down = |p: &[f64; 3]| [p[0], p[1], p[2] - 0.15 * f64::from(u8::from(p[2] > 1.0))];
        let nearer: Vec<[f64; 3]> = cubes.mesh.nodes().iter().map(down).collect();
        let at = body.configuration(&nearer, &[]).unwrap();
        let changed = cubes.contact.renew(at);
        let (before, stored) = (body.pattern().clone(), body.pattern().stored());
        assert_eq!(body.renew(at).unwrap(), changed);
        assert_eq!(body.evaluations().searches, 1);
        let same = Arc::ptr_eq(&before, body.pattern());
        let more = body.pattern().stored() - stored;
        (cubes.contact.pairs(), changed, same, more)
    };
    assert_eq!(looked(1.0), (0, false, true, 0));
    // The same cubes, near enough.
    let (pairs, changed, same, more) = looked(0.2);
    assert!(pairs > 0 && changed && !same && more > 0);
}

/// Terms of nothing that count how often each of them is evaluated.
struct Witness(Stencils, Arc<[AtomicU64]>);

impl Witness {
    fn seen(&self, stencils: Range<usize>) {
        for stencil in stencils {
            self.1[stencil].fetch_add(1, Relaxed);
        }
    }
}

impl Term<3> for Witness {
    fn stencils(&self) -> Stencils {
        self.0.clone()
    }
    fn energy(&self, _: Configuration<3>, stencils: Range<usize>, _: &mut EnergySink) {
        self.seen(stencils);
    }
    fn gradient(&self, _: Configuration<3>, stencils: Range<usize>, _: &mut GradientSink<3>) {
        self.seen(stencils);
    }
    fn hessian(
        &self,
        _: Configuration<3>,
        _: HessianProjection,
        stencils: Range<usize>,
        _: &mut HessianSink<3>,
    ) {
        self.seen(stencils);
    }
}

/// A bar of nothing but witnesses of its elements.
fn witnessed(bar: &Bar) -> (Assembly<3>, Arc<[AtomicU64]>) {
    let elements = bar.mesh.connectivity().chunks(4);
    let stencils = Stencils::new(elements.map(|e| [0, 1, 2, 3].map(|k| e[k] as usize)));
    let seen: Arc<[AtomicU64]> = (0..stencils.count()).map(|_| AtomicU64::new(0)).collect();
    let witness = Witness(stencils, seen.clone());
    (bar.builder().term(witness).unwrap().build().unwrap(), seen)
}

/// How often each was seen since the last time.
fn taken(seen: &[AtomicU64]) -> Vec<u64> {
    seen.iter().map(|n| n.swap(0, Relaxed)).collect()
}

#[test]
fn what_is_counted_is_what_was_evaluated() {
    let bar = bar(1.1);
    // So few rows have one owner.
    let (body, seen) = witnessed(&bar);
    let total = || taken(&seen).iter().sum::<u64>();
    let at = body.configuration(&bar.moved, &[]).unwrap();
    body.free_energy(at);
    body.gradient(at, &mut vec![0.0; body.dofs().vector_len()])
        .unwrap();
    let done = body.evaluations().others;
    assert_eq!(done.energies + done.gradients, 2 * bar.felt);
    assert_eq!(total(), 2 * bar.felt);
    body.energy(at);
    assert_eq!((body.evaluations().others - done).energies, total());
}

/// An element counts once, also where the owners of the rows on its two sides both evaluate it.
#[test]
fn an_element_between_two_owners_is_evaluated_by_both_and_counts_once() {
    // 1200 rows, of which an owner has 512 at least.
    let bar = bar_of([14, 9, 9], 1.1);
    let (body, seen) = witnessed(&bar);
    let dofs = body.dofs();
    assert_eq!(dofs.free_nodes(), 1200);
    let at = body.configuration(&bar.moved, &[]).unwrap();
    body.free_energy(at);
    assert_eq!(taken(&seen).iter().sum::<u64>(), bar.felt);
    body.gradient(at, &mut vec![0.0; dofs.unknowns()]).unwrap();
    let found = taken(&seen);
    let rows = bar.mesh.connectivity().chunks(4).map(|element| {
        let rows = element.iter().filter_map(|&n| dofs.row(n as usize));
        rows.clone().min().zip(rows.max())
    });
    let rows: Vec<Option<(usize, usize)>> = rows.collect();
    // There is one cut of the rows by which everything that was seen is explained.
    let explains = |cut: usize| {
        let owners = |rows: &Option<(usize, usize)>| match *rows {
            Some((least, most)) if least < cut && cut <= most => 2,
            Some(_) => 1,
            None => 0,
        };
        rows.iter().map(owners).eq(found.iter().copied())
    };
    assert!(found.contains(&2));
    assert_eq!((512..=688).filter(|&cut| explains(cut)).count(), 1);
    let done = body.evaluations().others;
    assert_eq!((done.energies, done.gradients), (bar.felt, bar.felt));
}
