//! One stop rule for soft and stiff, small and large, near and far.

use crate::promise::Newton;
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{
    Assembly, AssemblyBuilder, Configuration, Dofs, EnergySink, GradientSink, HessianSink,
    Quasistatic, Stencils, Term,
};
use fem_materials::{HessianProjection, NeoHookean};
use fem_solvers::{LinearSolver, NewtonInfo, NewtonParams, PreconditionerChoice};
use std::ops::Range;

const N: usize = 4;

fn flesh(mu: f64) -> NeoHookean {
    NeoHookean {
        mu,
        lambda: 4.0 * mu,
    }
}

fn grid(size: f64) -> SimplexMesh<3> {
    kuhn_grid(2 * N, N, N, [2.0 * size, size, size]).unwrap()
}

/// Both ends prescribed.
fn prescribed_ends(mesh: &SimplexMesh<3>, size: f64) -> Dofs<3> {
    let at_end = |p: &[f64; 3]| p[0] == 0.0 || (p[0] - 2.0 * size).abs() < 1e-9 * size;
    let nodes: Vec<usize> = (0..mesh.nodes().len())
        .filter(|&n| at_end(&mesh.nodes()[n]))
        .collect();
    Dofs::with_prescribed_nodes(mesh.nodes(), &nodes).unwrap()
}

fn middle(mesh: &SimplexMesh<3>, element: usize) -> [f64; 3] {
    let nodes = mesh.elements().nth(element).unwrap();
    std::array::from_fn(|k| {
        nodes
            .iter()
            .map(|&n| mesh.nodes()[n as usize][k])
            .sum::<f64>()
            / 4.0
    })
}

/// `mu` in the elements that `stiff` does not choose, `ratio` times that in the others.
fn two_parts(mu: f64, ratio: f64, stiff: impl Fn([f64; 3]) -> bool) -> Assembly<3> {
    let mesh = grid(1.0);
    let (mut hard, mut soft) = (Vec::new(), Vec::new());
    for e in 0..mesh.elements().len() {
        let part = if stiff(middle(&mesh, e)) {
            &mut hard
        } else {
            &mut soft
        };
        part.push(e);
    }
    let dofs = prescribed_ends(&mesh, 1.0);
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let builder = builder.region(&soft, flesh(mu)).unwrap();
    let builder = builder.region(&hard, flesh(ratio * mu)).unwrap();
    builder.build().unwrap()
}

/// The far end pulled by a tenth and to the side; the flesh starts at rest.
fn pulled(assembly: &Assembly<3>, size: f64, share: f64) -> Vec<[f64; 3]> {
    let moved = |p: &[f64; 3]| match p[0] > 1.999 * size {
        true => [p[0] + 0.2 * share * size, p[1] + 0.1 * share * size, p[2]],
        false => *p,
    };
    assembly.rest().iter().map(moved).collect()
}

fn solve(
    assembly: &Assembly<3>,
    start: Vec<[f64; 3]>,
    linear_solver: LinearSolver,
    what: &str,
) -> (Vec<[f64; 3]>, NewtonInfo) {
    let params = NewtonParams {
        linear_solver,
        ..NewtonParams::default()
    };
    let problem = Quasistatic::new(assembly, start, vec![]).unwrap();
    let mut x = problem.unknowns();
    let info = Newton::new(&problem)
        .solve(&problem, &mut x, &params)
        .unwrap_or_else(|e| panic!("{what}: {e}"));
    (problem.positions(&x).unwrap(), info)
}

fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.fold(0.0, |m, (a, b)| f64::max(m, (a - b).abs()))
}

fn pcg(preconditioner: PreconditionerChoice) -> LinearSolver {
    LinearSolver::Pcg {
        preconditioner,
        max_iterations: 2_000,
    }
}

/// A free node that no stiff element touches.
fn soft_node(assembly: &Assembly<3>, stiff: impl Fn([f64; 3]) -> bool) -> usize {
    let mesh = grid(1.0);
    let mut free: Vec<bool> = (0..mesh.num_nodes())
        .map(|n| assembly.dofs().row(n).is_some())
        .collect();
    for (e, nodes) in mesh.elements().enumerate() {
        if stiff(middle(&mesh, e)) {
            nodes.iter().for_each(|&n| free[n as usize] = false);
        }
    }
    free.iter().position(|&free| free).unwrap()
}

#[test]
fn a_soft_part_of_a_stiff_body_is_balanced_too() {
    let halves = |p: [f64; 3]| p[0] > 1.0;
    // Strained alike, so that the stiff one's forces stay large.
    let layers = |p: [f64; 3]| p[1] > 0.5;
    // A stiff island that only soft flesh holds.
    let island = |p: [f64; 3]| (0.5..1.5).contains(&p[0]) && p[1] > 0.25 && p[1] < 0.75;
    type Chosen<'a> = &'a dyn Fn([f64; 3]) -> bool;
    // From rest Newton's method does not turn a stiffer island in 100 steps.
    let cases: [(&str, Chosen<'_>, &[f64]); 3] = [
        ("halves", &halves, &[1e6, 1e9]),
        ("layers", &layers, &[1e6, 1e9]),
        ("island", &island, &[1e4]),
    ];
    for (name, stiff, ratios) in cases {
        for &ratio in ratios {
            let assembly = two_parts(1e3, ratio, stiff);
            let start = pulled(&assembly, 1.0, 1.0);
            let what = format!("{name}, {ratio:e}");
            let (expected, _) = solve(&assembly, start.clone(), LinearSolver::Direct, &what);
            // Soft flesh a little out of place is not at rest, whatever the stiff part feels.
            let mut moved = expected.clone();
            moved[soft_node(&assembly, stiff)][2] += 1e-4;
            let (back, info) = solve(&assembly, moved, LinearSolver::Direct, &what);
            let off = farthest(&back, &expected);
            assert!(
                info.iterations > 0 && off < 1e-6,
                "{what}: {off:e}, {info:?}"
            );
            for preconditioner in [
                PreconditionerChoice::BlockJacobi,
                PreconditionerChoice::BlockIc0,
            ] {
                let what = format!("{what}, {preconditioner:?}");
                let (found, _) = solve(&assembly, start.clone(), pcg(preconditioner), &what);
                let off = farthest(&found, &expected);
                assert!(off < 1e-6, "{what}: {off:e} m of a pull of 0.2 m");
            }
        }
    }
}

/// A constant energy, joules, of one stencil.
struct Offset(f64);

impl Term<3> for Offset {
    fn stencils(&self) -> Stencils {
        Stencils::new([[N * N]])
    }
    fn energy(&self, _: Configuration<3>, _: Range<usize>, sink: &mut EnergySink) {
        sink.energy(0, self.0);
    }
    fn gradient(&self, _: Configuration<3>, _: Range<usize>, sink: &mut GradientSink<3>) {
        sink.energy(0, self.0);
    }
    fn hessian(
        &self,
        _: Configuration<3>,
        _: HessianProjection,
        _: Range<usize>,
        _: &mut HessianSink<3>,
    ) {
    }
}

#[test]
fn the_rule_moves_with_no_unit_no_start_and_no_offset_of_the_energy() {
    let mut shapes: Vec<Vec<[f64; 3]>> = Vec::new();
    for mu in [1e-6, 1e3, 1e12] {
        for size in [1e-3, 1.0, 1e3] {
            for offset in [0.0, 1e12] {
                let mesh = grid(size);
                let assembly = AssemblyBuilder::new(&mesh, prescribed_ends(&mesh, size)).unwrap();
                let assembly = assembly.material(flesh(mu)).unwrap();
                // In units of the energy that the body stores.
                let joules = offset * 1e-3 * mu * size.powi(3);
                let assembly = assembly.term(Offset(joules)).unwrap().build().unwrap();
                for solver in [LinearSolver::Direct, LinearSolver::DirectSingle] {
                    let what = format!("{mu:e} Pa, {size:e} m, {joules:e} J, {solver:?}");
                    let start = pulled(&assembly, size, 1.0);
                    let (found, info) = solve(&assembly, start, solver, &what);
                    assert!((1..12).contains(&info.iterations), "{what}: {info:?}");
                    let (_, again) = solve(&assembly, found.clone(), solver, &what);
                    assert_eq!(again.iterations, 0, "{what}: {again:?}");
                    // The next frame: the far end moved a little further.
                    let next = found.iter().zip(pulled(&assembly, size, 1.0 + 1e-9));
                    let at_end = |q: &[f64; 3]| q[0] > 2.1 * size;
                    let next = next.map(|(&p, q)| if at_end(&q) { q } else { p });
                    let (_, next) = solve(&assembly, next.collect(), solver, &what);
                    assert!(next.iterations <= 2, "{what}: {next:?}");
                    let (_, rest) = solve(&assembly, assembly.rest().to_vec(), solver, &what);
                    assert_eq!(rest.iterations, 0, "{what}: {rest:?}");
                    let unit = |p: &[f64; 3]| p.map(|p| p / size);
                    shapes.push(found.iter().map(unit).collect());
                }
            }
        }
    }
    for shape in &shapes {
        let off = farthest(shape, &shapes[0]);
        assert!(off < 1e-7, "{off:e}");
    }
}

#[test]
fn a_free_block_at_rest_is_done() {
    let mesh = grid(1.0);
    let dofs = Dofs::all_free(mesh.nodes()).unwrap();
    let assembly = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let assembly = assembly.material(flesh(1e5)).unwrap().build().unwrap();
    let rest = assembly.rest().to_vec();
    let (_, info) = solve(&assembly, rest, LinearSolver::Auto, "free");
    assert_eq!(info.iterations, 0);
}

/// A pull of 2 nm on a bar of 2 m: far below 1e-8 of what would strain it by one, and yet its middle
/// goes half of the way.
#[test]
fn a_tiny_pull_is_followed() {
    let mesh = grid(1.0);
    let assembly = AssemblyBuilder::new(&mesh, prescribed_ends(&mesh, 1.0)).unwrap();
    let assembly = assembly.material(flesh(1e4)).unwrap().build().unwrap();
    let start = pulled(&assembly, 1.0, 1e-8);
    let (found, info) = solve(&assembly, start, LinearSolver::Direct, "a tiny pull");
    let middle = mesh.nodes().iter().position(|p| *p == [1.0, 0.5, 0.5]);
    let way = found[middle.unwrap()][0] - 1.0;
    assert!((way / 1e-9 - 1.0).abs() < 1e-2, "{way:e} m, {info:?}");
}
