//! Every kind of term against differences of its own energy, dense matrices and other numbers of
//! threads.

use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{
    Assembly, AssemblyBuilder, AssemblyError, Cavity, Configuration, Dofs, EnergySink, Fiber,
    GradientSink, Gravity, HessianSink, ImplicitSurface, NodalLoads, Penalty, Scaled, Spring,
    Springs, Stencils, Term, VolumePatches,
};
use fem_kinematics::Mat;
use fem_materials::curves::PhysBam;
use fem_materials::{FiberLaw, HessianProjection, NeoHookean, Stretch};
use fem_solvers::{BlockSymmetric, LinearOperator};
use std::ops::Range;

type Point = [f64; 3];

/// k/2 |x_a − x_b|² − c/2 |x_a − x_c|²/10 with a control c: three nodes, no order among them.
struct Strings {
    nodes: Vec<[usize; 3]>,
    control: usize,
}

impl Strings {
    fn parts(&self, at: Configuration<3>, s: usize) -> [(usize, f64, Point); 2] {
        let [a, b, c] = self.nodes[s].map(|n| at.positions()[n]);
        let weight = -0.1 * at.controls()[self.control];
        [
            (1, 20.0, std::array::from_fn(|i| a[i] - b[i])),
            (2, weight, std::array::from_fn(|i| a[i] - c[i])),
        ]
    }
}

impl Term<3> for Strings {
    fn stencils(&self) -> Stencils {
        Stencils::new(self.nodes.iter().copied()).in_batches_of(3)
    }
    fn energy(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut EnergySink) {
        for s in stencils {
            let of =
                |(_, k, d): (usize, f64, Point)| 0.5 * k * d.iter().map(|c| c * c).sum::<f64>();
            sink.energy(s, self.parts(at, s).map(of).iter().sum());
        }
    }
    fn gradient(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut GradientSink<3>) {
        for s in stencils {
            let of =
                |(_, k, d): (usize, f64, Point)| 0.5 * k * d.iter().map(|c| c * c).sum::<f64>();
            sink.energy(s, self.parts(at, s).map(of).iter().sum());
            for (vertex, k, d) in self.parts(at, s) {
                sink.add(s, 0, d.map(|d| k * d));
                sink.add(s, vertex, d.map(|d| -k * d));
            }
        }
    }
    fn hessian(
        &self,
        at: Configuration<3>,
        _: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<3>,
    ) {
        for s in stencils {
            for (vertex, k, _) in self.parts(at, s) {
                let block = Mat::<f64, 3>::identity().scale(k);
                sink.add(s, 0, 0, block.0);
                sink.add(s, vertex, vertex, block.0);
                sink.add(s, 0, vertex, block.scale(-1.0).0);
            }
        }
    }
    fn controls(&self) -> usize {
        self.control + 1
    }
    fn control_gradient(
        &self,
        at: Configuration<3>,
        control: usize,
        stencils: Range<usize>,
        sink: &mut GradientSink<3>,
    ) {
        for s in stencils.filter(|_| control == self.control) {
            let d = self.parts(at, s)[1].2;
            sink.add(s, 0, d.map(|d| -0.1 * d));
            sink.add(s, 2, d.map(|d| 0.1 * d));
        }
    }
    fn largest_step(&self, _: Configuration<3>, _: &[Point], _: Range<usize>) -> f64 {
        7.0
    }
    fn one_sided(&self) -> bool {
        true
    }
}

fn strings(count: usize) -> Strings {
    let node = |k: usize, stride: usize| (stride * k + 5 * (k / 3)) % count;
    let nodes = (0..count).map(|k| [node(k, 7), node(k, 3), node(k, 11)]);
    let differ = |n: &[usize; 3]| n[0] != n[1] && n[0] != n[2] && n[1] != n[2];
    Strings {
        nodes: nodes.filter(differ).collect(),
        control: 3,
    }
}

fn fibers(mesh: &SimplexMesh<3>) -> Vec<Fiber> {
    (0..mesh.elements().len())
        .filter(|e| e % 3 != 0)
        .map(|e| Fiber {
            element: e,
            control: e % 2,
            direction: [(e as f64).cos(), 0.0, (e as f64).sin()],
            max_isometric_stress: 3e3,
            optimal_stretch: 1.0,
        })
        .collect()
}

const CONTROLS: [f64; 9] = [0.3, 0.8, 0.5, 1.5, -0.7, 0.4, 0.6, -0.2, 90.0];
const NAMES: [&str; 15] = [
    "elastic",
    "fibers",
    "obstacle",
    "loads",
    "gravity",
    "strings",
    "edges",
    "nodes",
    "scaled",
    "strength",
    "stiffness",
    "springs",
    "inside",
    "capped",
    "mantle",
];

fn flesh() -> NeoHookean {
    NeoHookean {
        mu: 1e3,
        lambda: 4e3,
    }
}

fn ball(nodes: usize) -> Penalty<3> {
    Penalty {
        nodes: (0..nodes).collect(),
        stiffness: 500.0,
        obstacle: ImplicitSurface::Sphere {
            center: [0.5, 0.5, 2.6],
            radius: 0.8,
        },
    }
}

fn bulk(mesh: &SimplexMesh<3>) -> Vec<f64> {
    (0..mesh.num_elements())
        .map(|e| 1e3 * (1 + e % 4) as f64)
        .collect()
}

/// One at a point inside each third element.
fn springs(mesh: &SimplexMesh<3>) -> Springs<3, 4> {
    let spring = |nodes: [u32; 4]| Spring {
        nodes: nodes.map(|n| n as usize),
        weights: [0.4, 0.1, 0.3, 0.2],
        anchor: [0.1, -0.3, 2.5],
        stiffness: 40.0,
    };
    Springs::new(mesh.tets().step_by(3).map(spring).collect()).unwrap()
}

fn held(count: usize) -> Springs<3, 1> {
    Springs::at_nodes((0..count).map(|n| (n, [0.0, 0.1, 0.2])), 30.0).unwrap()
}

/// The boundary without its bottom.
fn top(mesh: &SimplexMesh<3>) -> Vec<[u32; 3]> {
    let mut faces = mesh.boundary().faces;
    faces.retain(|face| face.iter().any(|&n| mesh.node(n)[2] > 0.0));
    faces
}

fn add(builder: AssemblyBuilder<3>, mesh: &SimplexMesh<3>, name: &str) -> AssemblyBuilder<3> {
    let count = mesh.nodes().len();
    let loads = || NodalLoads::new((0..count).map(|n| (n, [1.0, n as f64, -2.0])).collect());
    let law = FiberLaw {
        curve: PhysBam::default(),
        stretch: Stretch::Total,
    };
    match name {
        "elastic" => builder.material(flesh()),
        "fibers" => builder.fibers(law, 3, &fibers(mesh)),
        "obstacle" => builder.penalty(ball(count)),
        "loads" => builder.term(loads().unwrap()),
        "gravity" => builder.term(Gravity::new(mesh, 1e3, [0.0, 0.0, -9.81]).unwrap()),
        "strings" => builder.term(strings(count)),
        "edges" => builder.mean_volume(&VolumePatches::around_edges(mesh), &bulk(mesh)),
        "nodes" => builder.mean_volume(
            &VolumePatches::around_nodes(mesh).restricted_to(|e| e < 24),
            &bulk(mesh),
        ),
        "strength" => builder.changed_by(5, |b| b.fibers(law, 3, &fibers(mesh))),
        "stiffness" => builder.changed_by(6, |b| {
            let patches = VolumePatches::around_nodes(mesh).restricted_to(|e| e < 12);
            b.region(&[0, 3, 4, 9, 17], flesh())?
                .mean_volume(&patches, &bulk(mesh))
        }),
        "springs" => builder
            .term(springs(mesh))
            .unwrap()
            .term(Scaled::new(held(count), 7).unwrap()),
        "inside" => builder.term(Cavity::closed(mesh.boundary().faces, 700.0).unwrap()),
        "capped" => {
            let cavity = Cavity::capped(Cavity::turned(top(mesh)), 1.0, |n| n == 3).unwrap();
            builder.term(Scaled::new(cavity, 8).unwrap())
        }
        "mantle" => builder.term(Cavity::about(top(mesh), [0.3, 0.2, -0.5], -60.0).unwrap()),
        _ => builder
            .term(Scaled::new(loads().unwrap(), 2).unwrap())
            .unwrap()
            .term(Scaled::new(ball(count), 4).unwrap()),
    }
    .unwrap()
}

fn assembly(names: &[&str], cells: [usize; 3]) -> (Assembly<3>, Vec<Point>) {
    let mesh = kuhn_grid(cells[0], cells[1], cells[2], [1.0, 1.0, 2.0]).unwrap();
    let rest = mesh.nodes();
    let prescribed: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == 0.0).collect();
    let dofs = Dofs::new(rest, &prescribed, &[(rest.len() - 1, 1)]).unwrap();
    let mut builder = AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .controls(CONTROLS.len());
    for name in names {
        builder = add(builder, &mesh, name);
    }
    let moved = rest.iter().map(|p| {
        let (s, c) = (0.2 * p[2]).sin_cos();
        let x = c * p[0] - s * p[1] + 0.03 * p[2] * p[1];
        [x, s * p[0] + c * p[1], 1.1 * p[2] + 0.05 * p[0]]
    });
    let x = moved.collect();
    (builder.build().unwrap(), x)
}

fn gradient(assembly: &Assembly<3>, x: &[Point], controls: &[f64]) -> Vec<f64> {
    let mut g = vec![0.0; assembly.dofs().vector_len()];
    let energy = assembly
        .gradient(assembly.configuration(x, controls).unwrap(), &mut g)
        .unwrap();
    let alone = assembly.free_energy(assembly.configuration(x, controls).unwrap());
    assert_eq!(energy.to_bits(), alone.to_bits());
    g
}

fn hessian(
    assembly: &Assembly<3>,
    at: Configuration<3>,
    projection: HessianProjection,
) -> BlockSymmetric<3> {
    let mut hessian = BlockSymmetric::zeros(assembly.pattern().clone());
    assembly.hessian(at, projection, &mut hessian);
    hessian
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn close(name: &str, a: &[f64], b: &[f64], tolerance: f64) {
    let scale = b.iter().fold(1e-3_f64, |m, v| m.max(v.abs()));
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        let near = (a - b).abs() <= tolerance * scale;
        assert!(near, "{name}, entry {i}: {a} against {b}, scale {scale}");
    }
}

/// Sixth-order central difference.
fn difference(f: impl Fn(f64) -> Vec<f64>, h: f64) -> Vec<f64> {
    let term = |k: f64| {
        let (high, low) = (f(k * h), f(-k * h));
        let of = |(a, b): (f64, f64)| (a - b) / h;
        high.into_iter().zip(low).map(of).collect::<Vec<_>>()
    };
    let (one, two, three) = (term(1.0), term(2.0), term(3.0));
    (0..one.len())
        .map(|i| 0.75 * one[i] - 0.15 * two[i] + three[i] / 60.0)
        .collect()
}

fn moved(assembly: &Assembly<3>, x: &[Point], direction: &[f64], t: f64) -> Vec<Point> {
    let mut all = x.to_vec();
    let mut unknowns = assembly.dofs().gather(x).unwrap();
    let pairs = unknowns.iter_mut().zip(direction);
    pairs.for_each(|(u, d)| *u += t * d);
    assembly.dofs().scatter(&unknowns, &mut all).unwrap();
    all
}

#[test]
fn every_term_has_the_derivatives_of_its_energy() {
    for name in NAMES {
        let (assembly, x) = assembly(&[name], [2, 2, 3]);
        let at = assembly.configuration(&x, &CONTROLS).unwrap();
        let g = gradient(&assembly, &x, &CONTROLS);
        let largest = g.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let roller = 3 * assembly.dofs().row(x.len() - 1).unwrap() + 1;
        let random = |phase: f64| {
            let wave = (0..g.len()).map(|i| (12.9898 * i as f64 + phase).sin());
            let mut direction: Vec<f64> = wave.collect();
            direction[roller] = 0.0;
            direction
        };
        let along: Vec<f64> = g.iter().map(|v| v / largest.max(1e-300)).collect();
        for direction in [random(0.4), random(1.7), along] {
            let to = |t| moved(&assembly, &x, &direction, t);
            let energy = |t| {
                let x = to(t);
                vec![assembly.energy(assembly.configuration(&x, &CONTROLS).unwrap())]
            };
            let scale = dot(&g, &g).sqrt() * dot(&direction, &direction).sqrt();
            let slope = dot(&g, &direction);
            let error = (slope - difference(energy, 1e-4)[0]).abs();
            assert!(error <= 1e-7 * scale, "{name}: {slope} off by {error}");

            let matrix = hessian(&assembly, at, HessianProjection::None);
            let mut product = vec![0.0; g.len()];
            matrix.apply(&direction, &mut product);
            let differences = difference(|t| gradient(&assembly, &to(t), &CONTROLS), 1e-4);
            close(name, &product, &differences, 1e-6);
            let mut displacement = vec![[0.0; 3]; x.len()];
            assembly
                .dofs()
                .scatter(&direction, &mut displacement)
                .unwrap();
            let mut matrix_free = vec![0.0; g.len()];
            assembly
                .hessian_vector(at, &displacement, &mut matrix_free)
                .unwrap();
            close(name, &matrix_free, &product, 1e-12);
            let mut everywhere = assembly
                .dofs()
                .gather(
                    &assembly
                        .hessian_vector_everywhere(at, &displacement)
                        .unwrap(),
                )
                .unwrap();
            everywhere[roller] = 0.0;
            close(name, &everywhere, &product, 1e-12);
        }
    }
}

#[test]
fn every_control_has_the_force_that_it_adds() {
    let (assembly, x) = assembly(&NAMES, [2, 2, 3]);
    assert_eq!(assembly.controls(), CONTROLS.len());
    let at = assembly.configuration(&x, &CONTROLS).unwrap();
    for control in 0..CONTROLS.len() {
        let with = |value: f64| {
            let mut controls = CONTROLS;
            controls[control] = value;
            gradient(&assembly, &x, &controls)
        };
        let ones = with(1.0).into_iter().zip(with(0.0));
        let slope: Vec<f64> = ones.map(|(a, b)| a - b).collect();
        let mut exact = vec![0.0; slope.len()];
        assembly.control_gradient(at, control, &mut exact).unwrap();
        assert!(exact.iter().any(|v| *v != 0.0), "control {control}");
        close("control", &exact, &slope, 1e-10);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits_of_all_terms() {
    let evaluate = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| {
            let (assembly, x) = assembly(&NAMES, [9, 9, 42]);
            let at = assembly.configuration(&x, &CONTROLS).unwrap();
            let n = assembly.dofs().vector_len();
            let (mut product, mut force) = (vec![0.0; n], vec![0.0; n]);
            assembly.hessian_vector(at, &x, &mut product).unwrap();
            assembly.control_gradient(at, 3, &mut force).unwrap();
            let matrix = hessian(&assembly, at, HessianProjection::None);
            let clamped = hessian(&assembly, at, HessianProjection::Clamp);
            // Two parts of one term go into the same sums.
            let mut shared = BlockSymmetric::zeros(assembly.pattern().clone());
            assembly.one_sided_hessian(at, HessianProjection::None, 0.3, &mut shared);
            let numbers = [gradient(&assembly, &x, &CONTROLS), product, force].concat();
            let matrices = [matrix.values(), clamped.values(), shared.values()].concat();
            let all = numbers.iter().chain(matrices.as_flattened().as_flattened());
            let bits: Vec<u64> = all.map(|v| v.to_bits()).collect();
            (assembly.energy(at).to_bits(), bits)
        })
    };
    let one = evaluate(1);
    for threads in [2, 3, 8] {
        assert!(evaluate(threads) == one, "{threads} threads");
    }
}

#[test]
fn forces_everywhere_are_those_on_the_free_nodes_and_more() {
    let (assembly, x) = assembly(&NAMES, [2, 2, 3]);
    let at = assembly.configuration(&x, &CONTROLS).unwrap();
    let mut forces = assembly
        .dofs()
        .gather(&assembly.forces_everywhere(at))
        .unwrap();
    forces[3 * assembly.dofs().row(x.len() - 1).unwrap() + 1] = 0.0;
    let g = gradient(&assembly, &x, &CONTROLS);
    let minus: Vec<f64> = forces.iter().map(|f| -f).collect();
    close("forces", &minus, &g, 1e-13);
}

/// The Hessian of strings is constant: minus and plus multiples of the identity in known places.
#[test]
fn blocks_in_any_order_land_in_a_dense_matrix_where_they_belong() {
    let (assembly, x) = assembly(&["strings"], [2, 2, 3]);
    let at = assembly.configuration(&x, &CONTROLS).unwrap();
    let dofs = assembly.dofs();
    let (count, n) = (x.len(), dofs.free_nodes());
    let mut dense = vec![vec![0.0; n]; n];
    for [a, b, c] in strings(count).nodes {
        for (other, k) in [(b, 20.0), (c, -0.1 * CONTROLS[3])] {
            let (p, q) = (dofs.row(a), dofs.row(other));
            let mut add = |p: Option<usize>, q: Option<usize>, k: f64| {
                if let (Some(p), Some(q)) = (p, q) {
                    dense[p][q] += k;
                }
            };
            for (p, q, k) in [(p, p, k), (q, q, k), (p, q, -k), (q, p, -k)] {
                add(p, q, k);
            }
        }
    }
    let matrix = hessian(&assembly, at, HessianProjection::None);
    for column in 0..n {
        let mut unit = vec![0.0; 3 * n];
        unit[3 * column] = 1.0;
        let mut product = vec![0.0; 3 * n];
        matrix.apply(&unit, &mut product);
        let expected: Vec<f64> = dense
            .iter()
            .flat_map(|row| [row[column], 0.0, 0.0])
            .collect();
        close("dense", &product, &expected, 1e-13);
    }
}

#[test]
fn a_term_times_a_negative_number_is_projected_exactly() {
    let (scaled, x) = assembly(&["scaled"], [2, 2, 3]);
    let matrix = |c: f64, projection| {
        let controls = [0.0, 0.0, 0.0, 0.0, c, 0.0, 0.0, 0.0, 0.0];
        let at = scaled.configuration(&x, &controls).unwrap();
        hessian(&scaled, at, projection).values().to_vec()
    };
    let (clamp, none) = (HessianProjection::Clamp, HessianProjection::None);
    // cH = (cH)⁺ − (−cH)⁺.
    let (positive, negative) = (matrix(-0.7, clamp), matrix(0.7, clamp));
    let whole = matrix(-0.7, none);
    let roller = scaled
        .pattern()
        .diagonal(scaled.dofs().row(x.len() - 1).unwrap());
    for place in (0..whole.len()).filter(|&p| p != roller) {
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
            let sum = positive[place][i][j] - negative[place][i][j];
            assert!((sum - whole[place][i][j]).abs() < 1e-10);
        }
    }
}

#[test]
fn gravity_is_the_weight_of_the_body() {
    let (assembly, x) = assembly(&["gravity"], [2, 2, 3]);
    let at = assembly.configuration(&x, &CONTROLS).unwrap();
    let weight: f64 = assembly.forces_everywhere(at).iter().map(|f| f[2]).sum();
    assert!((weight + 1e3 * 2.0 * 9.81).abs() < 1e-8, "{weight}");
}

#[test]
fn unusable_terms_and_configurations_are_refused() {
    let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).unwrap();
    let builder = || AssemblyBuilder::new(&mesh, Dofs::all_free(mesh.nodes()).unwrap()).unwrap();
    let with = |nodes| {
        let nodes = vec![nodes];
        builder().term(Strings { nodes, control: 0 }).err()
    };
    assert_eq!(
        with([0, 1, 8]),
        Some(AssemblyError::NoSuchNode { node: 8, count: 8 })
    );
    let twice = AssemblyError::RepeatedNode {
        term: 0,
        stencil: 0,
        node: 1,
    };
    assert_eq!(with([1, 2, 1]), Some(twice));
    let again = || Strings {
        nodes: vec![],
        control: 1,
    };
    let (read, control) = (1, 1);
    let twice = AssemblyError::ScaledTwice { read, control };
    assert_eq!(Scaled::new(again(), 1).err(), Some(twice));
    assert!(Scaled::new(again(), 2).is_ok());
    assert!(NodalLoads::new(vec![(0, [f64::NAN; 3])]).is_err());
    assert!(Gravity::new(&mesh, f64::INFINITY, [0.0; 3]).is_err());
    let assembly = add(builder(), &mesh, "strings").build().unwrap();
    let x = mesh.nodes();
    assert!(assembly.configuration(x, &[0.0; 3]).is_err());
    assert!(assembly.configuration(&x[1..], &[0.0; 4]).is_err());
    assert!(assembly.configuration(x, &[f64::NAN; 4]).is_err());
    assert!(
        assembly
            .configuration(&[[f64::NAN; 3]; 8], &[0.0; 4])
            .is_err()
    );
    let at = assembly.configuration(x, &[0.0; 4]).unwrap();
    assert_eq!(assembly.largest_step(at, x).unwrap(), 7.0);
}
