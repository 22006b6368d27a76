//! Flesh against flesh: differences, threads, blocks pressed together, a start from penetration.

use crate::promise::{Newton, solve_renewing};
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{
    Assembly, AssemblyBuilder, Configuration, Dofs, EnergySink, FleshContact, FleshContactParams,
    GradientSink, HessianSink, Quasistatic, RenewingError, Stencils, Term,
};
use fem_kinematics::HessianProjection;
use fem_materials::NeoHookean;
use fem_solvers::{BlockSymmetric, LinearOperator, LinearSolver, NewtonParams, ProjectionPolicy};

use std::ops::Range;

pub(crate) type Point = [f64; 3];
pub(crate) const PARAMS: FleshContactParams = FleshContactParams {
    activation: 0.05,
    pressure: 1e5,
    depth: 0.3,
    margin: 0.2,
    neighbors: 2,
    edges: true,
};

/// Two blocks, the upper one turned and shifted, `gap` above the lower, which is [0, 1]² × [0, 1].
pub(crate) fn blocks(gap: f64) -> SimplexMesh<3> {
    let low = kuhn_grid(4, 4, 3, [1.0; 3]).unwrap();
    let high = kuhn_grid(3, 3, 2, [0.8, 0.8, 0.7]).unwrap();
    let turned = high.nodes().iter().map(|p| {
        let (s, c) = 0.3_f64.sin_cos();
        [
            0.2 + c * p[0] - s * p[1],
            0.03 + s * p[0] + c * p[1],
            1.0 + gap + p[2],
        ]
    });
    let nodes: Vec<Point> = low.nodes().iter().copied().chain(turned).collect();
    let first = low.num_nodes() as u32;
    let above = high.connectivity().iter().map(|n| n + first);
    let elements = low.connectivity().iter().copied().chain(above).collect();
    SimplexMesh::new(nodes, elements).unwrap()
}

fn assembly(mesh: &SimplexMesh<3>, gap: f64) -> Assembly<3> {
    with_pressure(mesh, gap, PARAMS.pressure)
}

fn with_pressure(mesh: &SimplexMesh<3>, gap: f64, pressure: f64) -> Assembly<3> {
    let params = FleshContactParams { pressure, ..PARAMS };
    let contact = FleshContact::new(mesh, &mesh.boundary().faces, params).unwrap();
    touching(mesh, gap, contact)
}

/// Blocks that are prescribed below and above, touching each other.
pub(crate) fn touching(
    mesh: &SimplexMesh<3>,
    gap: f64,
    contact: impl Term<3> + 'static,
) -> Assembly<3> {
    let rest = mesh.nodes();
    let is_prescribed = |n: &usize| rest[*n][2] == 0.0 || rest[*n][2] > 1.65 + gap;
    let prescribed: Vec<usize> = (0..rest.len()).filter(is_prescribed).collect();
    let dofs = Dofs::with_prescribed_nodes(rest, &prescribed).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 4e4,
    };
    let builder = AssemblyBuilder::new(mesh, dofs).unwrap();
    builder
        .material(flesh)
        .unwrap()
        .term(contact)
        .unwrap()
        .build()
        .unwrap()
}

/// Everything above the lower block, lower by `by`.
pub(crate) fn lowered(mesh: &SimplexMesh<3>, by: f64) -> Vec<Point> {
    let rest = mesh.nodes().iter().enumerate();
    let of = |(n, p): (usize, &Point)| [p[0], p[1], p[2] - if n >= 100 { by } else { 0.0 }];
    rest.map(of).collect()
}

pub(crate) fn force(assembly: &Assembly<3>, x: &[Point]) -> Vec<f64> {
    let mut g = vec![0.0; assembly.dofs().vector_len()];
    assembly
        .gradient(assembly.configuration(x, &[]).unwrap(), &mut g)
        .unwrap();
    g
}

fn moved(assembly: &Assembly<3>, x: &[Point], d: &[f64], t: f64) -> Vec<Point> {
    let mut u = assembly.dofs().gather(x).unwrap();
    u.iter_mut().zip(d).for_each(|(u, d)| *u += t * d);
    let mut all = x.to_vec();
    assembly.dofs().scatter(&u, &mut all).unwrap();
    all
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn derivatives_hold_along_random_directions_and_along_the_gradient() {
    let mesh = blocks(0.1);
    derivatives_hold(&mut assembly(&mesh, 0.1), &lowered(&mesh, 0.12));
}

/// Differences of the energy and of the forces, at waves over these positions.
pub(crate) fn derivatives_hold(assembly: &mut Assembly<3>, quiet: &[Point]) {
    let wave = |n: usize, i: usize| 0.004 * (3.7 * n as f64 + 1.3 * i as f64).sin();
    let x: Vec<Point> = (0..quiet.len())
        .map(|n| std::array::from_fn(|i| quiet[n][i] + wave(n, i)))
        .collect();
    assembly
        .renew(assembly.configuration(&x, &[]).unwrap())
        .unwrap();
    let g = force(assembly, &x);
    let largest = g.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(largest > 1.0, "{largest}");
    let random = |p: f64| {
        (0..g.len())
            .map(|i| (12.9898 * i as f64 + p).sin())
            .collect()
    };
    let along = g.iter().map(|v| v / largest).collect();
    for direction in [random(0.3), random(1.9), along] {
        let direction: Vec<f64> = direction;
        let at = assembly.configuration(&x, &[]).unwrap();
        let energy = |t| {
            let y = moved(assembly, &x, &direction, t);
            assembly.energy(assembly.configuration(&y, &[]).unwrap())
        };
        // A force has a kink where a pair begins to feel: the error there is proportional to h.
        let h = 3e-7;
        let slope =
            (8.0 * (energy(h) - energy(-h)) - energy(2.0 * h) + energy(-2.0 * h)) / (12.0 * h);
        let scale = dot(&g, &g).sqrt() * dot(&direction, &direction).sqrt();
        assert!(
            (slope - dot(&g, &direction)).abs() <= 1e-6 * scale,
            "{slope}"
        );
        let mut matrix = BlockSymmetric::zeros(assembly.pattern().clone());
        assembly.hessian(at, HessianProjection::None, &mut matrix);
        let mut product = vec![0.0; g.len()];
        matrix.apply(&direction, &mut product);
        let of = |t| force(assembly, &moved(assembly, &x, &direction, t));
        let (a, b, c, d) = (of(h), of(-h), of(2.0 * h), of(-2.0 * h));
        let top = product.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for i in 0..g.len() {
            let slope = (8.0 * (a[i] - b[i]) - c[i] + d[i]) / (12.0 * h);
            assert!(
                (slope - product[i]).abs() <= 1e-6 * top,
                "{slope} {}",
                product[i]
            );
        }
    }
}

/// Deeper than any look reaches there are no pairs; just short of that a body that saw none there must find
/// what one finds that has seen nothing before, though nothing has moved far.
#[test]
fn a_look_where_little_has_moved_reaches_as_deep_as_any_other() {
    // A small block above the middle of a large one, so that nothing is near but top and bottom.
    let low = kuhn_grid(4, 4, 3, [1.0; 3]).unwrap();
    let high = kuhn_grid(2, 2, 2, [0.4, 0.4, 0.7]).unwrap();
    let above = high
        .nodes()
        .iter()
        .map(|p| [p[0] + 0.3, p[1] + 0.3, p[2] + 1.1]);
    let nodes = low.nodes().iter().copied().chain(above).collect();
    let tets = high
        .connectivity()
        .iter()
        .map(|n| n + low.num_nodes() as u32);
    let tets = low.connectivity().iter().copied().chain(tets).collect();
    let mesh = SimplexMesh::new(nodes, tets).unwrap();
    let [beyond, short] = [0.02, -0.02].map(|more| {
        let by = 0.1 + PARAMS.depth + PARAMS.margin + more;
        lowered(&mesh, by)
    });
    let (mut known, mut fresh) = (assembly(&mesh, 0.1), assembly(&mesh, 0.1));
    let at = known.configuration(&beyond, &[]).unwrap();
    known.renew(at).unwrap();
    let before = force(&known, &short);
    for body in [&mut known, &mut fresh] {
        let at = body.configuration(&short, &[]).unwrap();
        body.renew(at).unwrap();
    }
    let there = force(&known, &short);
    assert!(there != before, "nothing was found");
    assert!(there == force(&fresh, &short));
}

#[test]
fn blocks_pressed_together_and_started_inside_each_other_stay_apart_with_the_same_bits() {
    let solve = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| {
            let mesh = blocks(0.1);
            let mut assembly = with_pressure(&mesh, 0.1, 1e4);
            let start = lowered(&mesh, 0.16); // 0.06 inside each other
            let problem = Quasistatic::new(&assembly, start.clone(), vec![]).unwrap();
            let mut newton = Newton::new(&problem);
            let params = NewtonParams {
                projection: ProjectionPolicy::ExactThenShifted,
                linear_solver: LinearSolver::Direct,
                max_iterations: 200,
                ..NewtonParams::default()
            };
            let done = solve_renewing(&mut assembly, &mut newton, start, &[], &params).unwrap();
            // Of the pairs of a fresh look, not of those that the solve ended with.
            let mut fresh = with_pressure(&mesh, 0.1, 1e4);
            let there = done.positions.clone();
            fresh
                .renew(fresh.configuration(&there, &[]).unwrap())
                .unwrap();
            let stop = done.info.unwrap().stop;
            crate::promise::came_to_rest(&fresh, &there, &[], &params, stop);
            let forces =
                assembly.forces_everywhere(assembly.configuration(&done.positions, &[]).unwrap());
            (done, forces)
        })
    };
    let (done, forces) = solve(1);
    let lowest = done.positions[100..]
        .iter()
        .fold(f64::INFINITY, |m, p| m.min(p[2]));
    let inner = (0..3).all(|i| forces.iter().map(|f| f[i]).sum::<f64>().abs() < 1e-6);
    let pressed: f64 = forces[..100].iter().map(|f| f[2]).sum();
    assert!(inner && pressed < -10.0, "{pressed}");
    assert!(lowest > 0.8, "{lowest}");
    let mesh = blocks(0.1);
    let depth = |x: &[Point]| {
        let mut contact = FleshContact::new(&mesh, &mesh.boundary().faces, PARAMS).unwrap();
        let fresh = assembly(&mesh, 0.1);
        contact.renew(fresh.configuration(x, &[]).unwrap());
        contact.deepest(x).unwrap()
    };
    let (before, after) = (depth(&lowered(&mesh, 0.16)), depth(&done.positions));
    assert!((before - 0.06).abs() < 1e-9, "{before}");
    assert!(after < 0.02, "{after}");
    for threads in [2, 3, 8] {
        assert!(
            solve(threads) == (done.clone(), forces.clone()),
            "{threads} threads"
        );
    }
}

#[test]
fn nothing_is_felt_and_no_pattern_changes_where_nothing_is_near() {
    let mesh = blocks(2.0);
    let mut far = assembly(&mesh, 2.0);
    let pattern = far.pattern().clone();
    let contact = FleshContact::new(&mesh, &mesh.boundary().faces, PARAMS).unwrap();
    assert_eq!(contact.pairs(), 0);
    let x = lowered(&mesh, 0.5);
    assert!(!far.renew(far.configuration(&x, &[]).unwrap()).unwrap());
    assert!(std::sync::Arc::ptr_eq(&pattern, far.pattern()));
    // 0.01 apart at rest, a fifth of the activation: silent all the same.
    let mesh = blocks(0.01);
    let near = assembly(&mesh, 0.01);
    assert!(force(&near, mesh.nodes()).iter().all(|g| g.abs() < 1e-9));
}

/// The Hessian has the same numbers in a pattern that grew as in one made for what touches now, and
/// after `forget` the pattern is that one.
#[test]
fn a_pattern_grows_while_pairs_come_and_go_until_it_is_forgotten() {
    let mesh = blocks(0.3);
    let mut used = assembly(&mesh, 0.3);
    let at_rest = used.pattern().clone();
    let mut before = at_rest.stored();
    for by in [0.2, 0.32, 0.1, 0.25] {
        let x = lowered(&mesh, by);
        used.renew(used.configuration(&x, &[]).unwrap()).unwrap();
        let grown = used.pattern().stored();
        assert!(grown >= before, "{by}: {grown} < {before}");
        before = grown;
        let mut fresh = assembly(&mesh, 0.3);
        fresh.renew(fresh.configuration(&x, &[]).unwrap()).unwrap();
        let hessian = |body: &Assembly<3>| {
            let mut matrix = BlockSymmetric::zeros(body.pattern().clone());
            let at = body.configuration(&x, &[]).unwrap();
            body.hessian(at, HessianProjection::None, &mut matrix);
            matrix
        };
        let (own, other) = (hessian(&used), hessian(&fresh));
        for row in 0..own.pattern().blocks() {
            for (&column, k) in own
                .pattern()
                .row(row)
                .iter()
                .zip(own.pattern().row_start()[row]..)
            {
                let found = own.values()[k];
                let place = other.pattern().find(row, column as usize);
                let expected = place.map_or([[0.0; 3]; 3], |k| other.values()[k]);
                assert_eq!(found, expected, "{by}: block ({row}, {column})");
            }
        }
        assert_eq!(force(&used, &x), force(&fresh, &x));
    }
    assert!(before > at_rest.stored());
    used.forget();
    let rest = mesh.nodes().to_vec();
    assert!(used.renew(used.configuration(&rest, &[]).unwrap()).unwrap());
    assert_eq!(**used.pattern(), *at_rest);
}

/// Two sides of one lip: where the front is hollow, its lower part has the top's rim ahead of it, and the
/// more the lip rolls, the more the two seem to face each other.
#[test]
fn the_sides_of_a_wedge_are_no_partners() {
    let grid = kuhn_grid(6, 6, 6, [1.0; 3]).unwrap();
    let front = |[x, y, z]: Point, roll: f64| [x * (1.0 + 0.25 * y * y) + roll * y, y, z];
    let lip = |roll: f64| grid.nodes().iter().map(|p| front(*p, roll)).collect();
    let rest: Vec<Point> = lip(0.0);
    let mesh = SimplexMesh::new(rest.clone(), grid.connectivity().to_vec()).unwrap();
    let side = |f: &&[u32; 3]| {
        let on = |axis: usize| f.iter().all(|&n| grid.nodes()[n as usize][axis] == 1.0);
        on(0) || on(1)
    };
    let faces: Vec<[u32; 3]> = mesh.boundary().faces.iter().filter(side).copied().collect();
    // Nothing of the lip is farther from the rest of it than what can be entered.
    let params = FleshContactParams {
        depth: 0.6,
        ..PARAMS
    };
    let mut contact = FleshContact::new(&mesh, &faces, params).unwrap();
    let dofs = Dofs::with_prescribed_nodes(&rest, &[0]).unwrap();
    let body = AssemblyBuilder::new(&mesh, dofs).unwrap().build().unwrap();
    for roll in [0.0, 0.3, 0.6, 1.0] {
        let x = lip(roll);
        contact.renew(body.configuration(&x, &[]).unwrap());
        assert_eq!(contact.pairs(), 0, "rolled by {roll}");
    }
}

/// A wide face and, above it, a tetrahedron that points down at it.
fn pointed() -> SimplexMesh<3> {
    let nodes = vec![
        [-10.0, -10.0, 0.0],
        [10.0, -10.0, 0.0],
        [0.0, 20.0, 0.0],
        [0.0, 0.0, -5.0],
        [0.0, 0.0, 1.0],
        [-0.4, -0.3, 2.0],
        [0.4, -0.3, 2.0],
        [0.0, 0.5, 2.0],
    ];
    let (low, high) = ([0, 2, 1, 3], [4, 5, 6, 7]);
    SimplexMesh::new(nodes, [low, high].concat()).unwrap()
}

/// The tip of [`pointed`] at this height, turned by so many degrees about itself.
fn tip(mesh: &SimplexMesh<3>, height: f64, degrees: f64) -> Vec<Point> {
    let (s, c) = degrees.to_radians().sin_cos();
    let place = |(n, p): (usize, &Point)| match n {
        0..4 => *p,
        _ => [
            p[0],
            c * p[1] - s * (p[2] - 1.0),
            height + s * p[1] + c * (p[2] - 1.0),
        ],
    };
    mesh.nodes().iter().enumerate().map(place).collect()
}

/// Contact of its points and triangles, and a body to make configurations of.
fn points_alone(mesh: &SimplexMesh<3>) -> (FleshContact, Assembly<3>) {
    let params = FleshContactParams {
        margin: 0.05,
        edges: false,
        ..PARAMS
    };
    let contact = FleshContact::new(mesh, &mesh.boundary().faces, params).unwrap();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &[0]).unwrap();
    let body = AssemblyBuilder::new(mesh, dofs).unwrap().build().unwrap();
    (contact, body)
}

/// One look finds what is near where a step starts and where it leads. What pushes without a reason
/// leaves with it, and stays where energies must fall.
#[test]
fn a_look_for_a_step_is_a_look_at_its_start_and_one_along_it() {
    let mesh = pointed();
    let (mut contact, body) = points_alone(&mesh);
    let below = |by: f64| -> Vec<Point> {
        let moved = |n: usize| [0.0, 0.0, if n < 4 { 0.0 } else { -by }];
        (0..8).map(moved).collect()
    };
    let [near, touching] = [0.3, -0.01].map(|height| tip(&mesh, height, 0.0));
    let aside = tip(&mesh, -0.01, 96.0);
    let at = |x| body.configuration(x, &[]).unwrap();
    assert!(contact.renew_for_step(at(&near), &below(0.31)));
    assert_eq!(contact.pairs(), 1);
    contact.forget();
    contact.renew(at(&near));
    assert_eq!(contact.pairs(), 0);
    // Turned aside the tip still pushes, and no look would find it.
    for (drops, left) in [(false, 1), (true, 0)] {
        contact.renew(at(&touching));
        assert_eq!(contact.pairs(), 1);
        let changed = match drops {
            true => contact.renew_for_step(at(&aside), &below(1e-3)),
            false => contact.renew_along(at(&aside), &below(1e-3)),
        };
        assert_eq!((changed, contact.pairs()), (drops, left));
    }
}

/// What settled is asked for again where it settled, and nowhere else, however near: a tip that turns to face
/// its partner by a hundredth of a degree.
#[test]
fn a_place_beside_one_that_settled_is_looked_at() {
    let mesh = pointed();
    let (mut contact, body) = points_alone(&mesh);
    let look = |contact: &mut FleshContact, degrees: f64| {
        let x = tip(&mesh, -0.01, degrees);
        contact.renew(body.configuration(&x, &[]).unwrap());
        contact.pairs()
    };
    let (mut faces, mut looks_away) = (90.0, 95.0);
    while looks_away - faces > 0.01 {
        let degrees = 0.5 * (faces + looks_away);
        contact.forget();
        match look(&mut contact, degrees) {
            0 => looks_away = degrees,
            _ => faces = degrees,
        }
    }
    for _ in 0..2 {
        let found = [faces, faces, faces, looks_away, looks_away, looks_away];
        let found = found.map(|degrees| look(&mut contact, degrees) > 0);
        assert_eq!(found, [true, true, true, false, false, false]);
    }
}

/// A pair that comes with a push and goes twice stays as long as it does not clearly face away; one
/// that is dropped even so stays as long as it is near, until all is forgotten.
#[test]
fn a_pair_that_looks_disagree_about_stays() {
    let mesh = pointed();
    let (mut contact, body) = points_alone(&mesh);
    let turned = |height: f64, degrees: f64| tip(&mesh, height, degrees);
    let (far, touching) = (turned(0.8, 0.0), turned(-0.01, 0.0));
    let (aside, away) = (turned(-0.01, 96.0), turned(-0.01, 120.0));
    let look = |contact: &mut FleshContact, x: &[Point]| {
        contact.renew(body.configuration(x, &[]).unwrap());
        contact.pairs()
    };
    let ends = |contact: &mut FleshContact, x: &[Point]| {
        contact.renew_at_equilibrium(body.configuration(x, &[]).unwrap());
        contact.pairs()
    };
    // It faces away aside, and is dropped there; the third dispute keeps it, so that it settles.
    let found = [&touching, &aside, &touching, &aside].map(|x| ends(&mut contact, x));
    assert_eq!(found, [1, 0, 1, 1]);
    // Clearly away it is dropped even so, until the eighth dispute.
    for _ in 0..4 {
        let found = [&away, &touching].map(|x| ends(&mut contact, x));
        assert_eq!(found, [0, 1]);
    }
    assert_eq!(ends(&mut contact, &away), 1);
    contact.forget();
    assert_eq!(look(&mut contact, &far), 0);
    // Looks on the way are no disputes.
    for _ in 0..9 {
        let found = [&touching, &aside].map(|x| look(&mut contact, x));
        assert_eq!(found, [1, 0]);
    }
    // What has settled is none either.
    for _ in 0..4 {
        let found = [&touching, &touching, &aside, &aside].map(|x| ends(&mut contact, x));
        assert_eq!(found, [1, 1, 0, 0]);
    }
}

/// Springs whose stencils change whenever they are asked: no equilibrium is that of its stencils.
struct Fickle {
    pair: [usize; 2],
    turns: usize,
}

impl Fickle {
    fn apart(&self, x: &[Point]) -> Point {
        let [a, b] = self.pair.map(|n| x[n]);
        std::array::from_fn(|i| a[i] - b[i])
    }
}

impl Term<3> for Fickle {
    fn stencils(&self) -> Stencils {
        Stencils::new([self.pair])
    }
    fn renew(&mut self, _: Configuration<3>) -> bool {
        self.turns > 0 && {
            self.turns -= 1;
            self.pair.swap(0, 1);
            true
        }
    }
    fn energy(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut EnergySink) {
        for s in stencils {
            let d = self.apart(at.positions());
            sink.energy(s, 0.5 * d.iter().map(|c| c * c).sum::<f64>());
        }
    }
    fn gradient(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut GradientSink<3>) {
        for s in stencils {
            let d = self.apart(at.positions());
            sink.energy(s, 0.5 * d.iter().map(|c| c * c).sum::<f64>());
            sink.add(s, 0, d);
            sink.add(s, 1, d.map(|c| -c));
        }
    }
    fn hessian(
        &self,
        _: Configuration<3>,
        _: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<3>,
    ) {
        let of =
            |k: f64| std::array::from_fn(|i| std::array::from_fn(|j| if i == j { k } else { 0.0 }));
        for s in stencils {
            sink.add(s, 0, 0, of(1.0));
            sink.add(s, 1, 1, of(1.0));
            sink.add(s, 0, 1, of(-1.0));
        }
    }
}

#[test]
fn stencils_that_never_settle_are_no_equilibrium() {
    let solve = |turns: usize| {
        let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).unwrap();
        let low: Vec<usize> = (0..8).filter(|&n| mesh.nodes()[n][2] == 0.0).collect();
        let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &low).unwrap();
        let flesh = NeoHookean {
            mu: 1e4,
            lambda: 4e4,
        };
        let pair = [low[0], (0..8).find(|n| !low.contains(n)).unwrap()];
        let builder = AssemblyBuilder::new(&mesh, dofs)
            .unwrap()
            .material(flesh)
            .unwrap();
        let mut body = builder
            .term(Fickle { pair, turns })
            .unwrap()
            .build()
            .unwrap();
        let problem = Quasistatic::new(&body, mesh.nodes().to_vec(), vec![]).unwrap();
        let mut newton = Newton::new(&problem);
        let params = NewtonParams::default();
        solve_renewing(&mut body, &mut newton, mesh.nodes().to_vec(), &[], &params)
    };
    assert!(solve(3).is_ok());
    match solve(1000) {
        Err(RenewingError::Unsettled { rounds, last }) => {
            assert!(rounds > 1 && last.positions.len() == 8);
        }
        other => panic!("{other:?}"),
    }
}
