//! Bodies cut by planes of symmetry: prescribed axes of partly free nodes are no unknowns.
#![allow(non_snake_case)]

use crate::promise::Newton;
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{
    Assembly, AssemblyBuilder, Configuration, Dofs, EnergySink, GradientSink, HessianSink,
    Quasistatic, Stencils, Term,
};
use fem_kinematics::Mat;
use fem_materials::{Material, NeoHookean};
use fem_solvers::{
    BlockSymmetric, CholeskyFactor, HessianProjection, LinearSolver, MultigridDirection,
    MultigridParams, NewtonParams, PreconditionerChoice,
};
use std::ops::Range;

const FLESH: NeoHookean = NeoHookean {
    mu: 1e4,
    lambda: 4e4,
};
const STRETCH: f64 = 1.3;

/// An eighth of a block of n³ cubes whose top moves up and slides sideways.
fn dofs(nodes: &[[f64; 3]]) -> Dofs<3> {
    let axes = nodes.iter().enumerate().flat_map(|(n, p)| {
        let prescribed = [p[0] == 0.0, p[1] == 0.0, p[2] == 0.0 || p[2] == 1.0];
        (0..3).filter(move |&k| prescribed[k]).map(move |k| (n, k))
    });
    Dofs::new(nodes, &[], &axes.collect::<Vec<_>>()).unwrap()
}

fn eighth(n: usize) -> Assembly<3> {
    let mesh = kuhn_grid(n, n, n, [1.0; 3]).unwrap();
    let builder = AssemblyBuilder::new(&mesh, dofs(mesh.nodes())).unwrap();
    builder.material(FLESH).unwrap().build().unwrap()
}

/// The stretch across that leaves no stress there.
fn across() -> f64 {
    let stress = |s: f64| {
        let mut F = Mat::<f64, 3>::identity();
        (F[(0, 0)], F[(1, 1)], F[(2, 2)]) = (s, s, STRETCH);
        FLESH.stress(&F)[(0, 0)]
    };
    let (mut low, mut high) = (0.5, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match stress(middle) < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

fn pulled(body: &Assembly<3>) -> Quasistatic<'_, 3> {
    let pulled = body.rest().iter().map(|p| [p[0], p[1], STRETCH * p[2]]);
    Quasistatic::new(body, pulled.collect(), vec![]).unwrap()
}

#[test]
fn prescribed_axes_are_no_unknowns() {
    let body = eighth(3);
    // 4³ nodes; four faces of 16 nodes keep one coordinate each. Two nodes keep all of theirs.
    assert_eq!(body.dofs().unknowns(), 3 * 64 - 4 * 16);
    assert_eq!(body.dofs().vector_len(), 3 * 62);
    assert_eq!(body.pattern().unknowns(3), 128);
    assert_eq!(body.pattern().absent().len(), 186 - 128);
    let problem = pulled(&body);
    let mut newton = Newton::new(&problem);
    let symbolic = newton.symbolic().unwrap();
    assert_eq!((symbolic.dim(), symbolic.unknowns()), (186, 128));
    let free = kuhn_grid(3, 3, 3, [1.0; 3]).unwrap();
    let free = Dofs::all_free(free.nodes()).unwrap();
    assert_eq!((free.unknowns(), free.vector_len()), (192, 192));
}

#[test]
fn every_linear_solver_finds_the_even_stretch() {
    let body = eighth(3);
    let problem = pulled(&body);
    let s = across();
    let solvers = [
        LinearSolver::Direct,
        LinearSolver::DirectSingle,
        LinearSolver::QrLeastSquares,
        LinearSolver::Auto,
    ];
    let iterated = [
        PreconditionerChoice::Identity,
        PreconditionerChoice::BlockJacobi,
        PreconditionerChoice::BlockIc0,
    ];
    let iterated = iterated.map(|preconditioner| LinearSolver::Pcg {
        preconditioner,
        max_iterations: 2_000,
    });
    let mut newtons: Vec<(String, NewtonParams, Newton<'_, 3>)> = solvers
        .into_iter()
        .chain(iterated)
        .map(|linear_solver| {
            let params = NewtonParams {
                relative_gradient_tolerance: 1e-11,
                linear_solver,
                ..NewtonParams::default()
            };
            (format!("{linear_solver:?}"), params, Newton::new(&problem))
        })
        .collect();
    let direction = MultigridDirection::<3, 6>::new(MultigridParams::default());
    let params = newtons[0].1;
    newtons.push((
        "multigrid".into(),
        params,
        Newton::with_direction(&problem, direction),
    ));
    for (name, params, newton) in &mut newtons {
        let mut x = problem.unknowns();
        let info = newton.solve(&problem, &mut x, params).unwrap();
        assert!(info.iterations < 12, "{name}: {info:?}");
        for (found, rest) in problem.positions(&x).unwrap().iter().zip(body.rest()) {
            let exact = [s * rest[0], s * rest[1], STRETCH * rest[2]];
            let off = (0..3).map(|k| (found[k] - exact[k]).abs());
            assert!(
                off.fold(0.0, f64::max) < 1e-9,
                "{name}: {found:?} is not {exact:?}"
            );
        }
    }
}

/// A spring that comes up when it is asked.
struct Late(Option<[usize; 2]>, [usize; 2]);

impl Term<3> for Late {
    fn stencils(&self) -> Stencils {
        Stencils::new(self.0)
    }
    fn changes(&self) -> bool {
        true
    }
    fn renew(&mut self, _: Configuration<3>) -> bool {
        self.0.replace(self.1).is_none()
    }
    fn energy(&self, _: Configuration<3>, stencils: Range<usize>, sink: &mut EnergySink) {
        stencils.for_each(|s| sink.energy(s, 0.0));
    }
    fn gradient(&self, _: Configuration<3>, stencils: Range<usize>, sink: &mut GradientSink<3>) {
        stencils.for_each(|s| sink.energy(s, 0.0));
    }
    fn hessian(
        &self,
        _: Configuration<3>,
        _: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<3>,
    ) {
        let of = |k: f64| [[k; 3]; 3];
        for s in stencils {
            sink.add(s, 0, 0, of(5e3));
            sink.add(s, 1, 1, of(5e3));
            sink.add(s, 0, 1, of(-5e3));
        }
    }
}

/// The factor of a pattern that grew, or was found anew, against products without a matrix.
#[test]
fn a_pattern_that_grows_keeps_what_is_prescribed() {
    let mesh = kuhn_grid(3, 3, 3, [1.0; 3]).unwrap();
    let builder = AssemblyBuilder::new(&mesh, dofs(mesh.nodes())).unwrap();
    // From a plane of symmetry to the top, farther apart than elements reach.
    let late = Late(None, [1, 63]);
    let builder = builder.material(FLESH).unwrap().term(late).unwrap();
    let mut body = builder.build().unwrap();
    let rest = mesh.nodes().to_vec();
    let before = body.pattern().clone();
    for forgets in [false, true] {
        if forgets {
            body.forget();
        }
        let at = body.configuration(&rest, &[]).unwrap();
        body.renew(at).unwrap();
        assert_eq!(body.pattern().stored(), before.stored() + 1);
        assert_eq!(body.pattern().absent(), before.absent());
        let at = body.configuration(&rest, &[]).unwrap();
        let mut matrix = BlockSymmetric::zeros(body.pattern().clone());
        body.hessian(at, HessianProjection::None, &mut matrix);
        let problem = Quasistatic::new(&body, rest.clone(), vec![]).unwrap();
        let mut newton = Newton::new(&problem);
        let symbolic = newton.symbolic().unwrap();
        let factor = CholeskyFactor::<f64, 3>::factor(symbolic, &matrix).unwrap();
        let load: Vec<f64> = (0..body.dofs().vector_len())
            .map(|i| (i as f64).sin())
            .collect();
        let mut x = load.clone();
        factor.solve_in_place(&mut x);
        let mut moved = vec![[0.0; 3]; rest.len()];
        body.dofs().scatter(&x, &mut moved).unwrap();
        let mut product = vec![0.0; x.len()];
        body.hessian_vector(at, &moved, &mut product).unwrap();
        for (i, (product, load)) in product.iter().zip(&load).enumerate() {
            let node = body.dofs().node_of_row()[i / 3] as usize;
            match body.dofs().is_prescribed(node, i % 3) {
                true => assert_eq!((x[i], *product), (0.0, 0.0)),
                false => assert!((product - load).abs() < 1e-10, "{i}: {product} {load}"),
            }
        }
    }
}
