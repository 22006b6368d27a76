//! Stencils that are told apart before they are evaluated: the same bits as with all of them.

use crate::contact::{PARAMS, Point, blocks, lowered, touching};
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{
    Assembly, AssemblyBuilder, Configuration, ContactPoint, Dofs, EnergySink, FleshContact,
    GradientSink, HessianSink, RigidContact, RigidContactParams, RigidSurface, Stencils, Term,
};
use fem_kinematics::{HessianProjection, ImplicitSurface};
use fem_materials::NeoHookean;
use fem_solvers::BlockSymmetric;
use std::ops::Range;

/// A term all of whose stencils are evaluated, and planned ahead if it says so.
struct Whole<T>(T, bool);

impl<T: Term<3>> Term<3> for Whole<T> {
    fn stencils(&self) -> Stencils {
        self.0.stencils()
    }
    fn energy(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut EnergySink) {
        self.0.energy(at, stencils, sink);
    }
    fn gradient(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut GradientSink<3>) {
        self.0.gradient(at, stencils, sink);
    }
    fn hessian(
        &self,
        at: Configuration<3>,
        projection: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<3>,
    ) {
        self.0.hessian(at, projection, stencils, sink);
    }
    fn renew(&mut self, at: Configuration<3>) -> bool {
        self.0.renew(at)
    }
    fn changes(&self) -> bool {
        self.1
    }
}

/// Energy, forces everywhere and of free nodes, matrix and product, bit by bit.
fn all(assembly: &Assembly<3>, x: &[Point]) -> Vec<u64> {
    let at = assembly.configuration(x, &[]).unwrap();
    let mut numbers = vec![assembly.energy(at)];
    let mut gradient = vec![0.0; assembly.dofs().vector_len()];
    numbers.push(assembly.gradient(at, &mut gradient).unwrap());
    numbers.extend(assembly.absolute_forces(at));
    numbers.extend(assembly.forces_everywhere(at).as_flattened());
    for projection in [HessianProjection::None, HessianProjection::Clamp] {
        let mut matrix = BlockSymmetric::zeros(assembly.pattern().clone());
        assembly.hessian(at, projection, &mut matrix);
        numbers.extend(matrix.values().as_flattened().as_flattened());
    }
    let mut product = vec![0.0; gradient.len()];
    let direction: Vec<Point> = x.iter().map(|p| p.map(|c| (9.0 * c).sin())).collect();
    assembly
        .hessian_vector(at, &direction, &mut product)
        .unwrap();
    numbers.extend(gradient);
    numbers.extend(product);
    numbers.iter().map(|n| n.to_bits()).collect()
}

#[test]
fn pairs_that_are_silent_change_no_bit() {
    let gap = 0.02;
    let mesh = blocks(gap);
    let contact = FleshContact::new(&mesh, &mesh.boundary().faces, PARAMS).unwrap();
    let mut assemblies = [
        touching(&mesh, gap, contact.clone()),
        touching(&mesh, gap, Whole(contact.clone(), true)),
        touching(&mesh, gap, Whole(contact.clone(), false)),
    ];
    // Far, touching, deep, and touching again: what was active before must not stay.
    for by in [-0.5, 0.04, 0.15, 0.03] {
        let x = lowered(&mesh, by);
        let mut told = Vec::new();
        for assembly in &mut assemblies {
            let at = assembly.configuration(&x, &[]).unwrap();
            assembly.renew(at).unwrap();
            told.push(all(assembly, &x));
        }
        assert!(told[0] == told[1] && told[1] == told[2], "{by}");
    }
    let x = lowered(&mesh, 0.04);
    let mut moved = contact;
    moved.renew(assemblies[0].configuration(&x, &[]).unwrap());
    let active = moved.active(assemblies[0].positions(&x).unwrap()).unwrap();
    let (active, pairs) = (active.len(), moved.pairs());
    assert!(active > 0 && active < pairs / 2, "{active} of {pairs}");
}

fn on_a_floor(mesh: &SimplexMesh<3>, term: impl Term<3> + 'static) -> Assembly<3> {
    let rest = mesh.nodes();
    let floor: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == 0.0).collect();
    let dofs = Dofs::with_prescribed_nodes(rest, &floor).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 4e4,
    };
    let builder = AssemblyBuilder::new(mesh, dofs).unwrap();
    let builder = builder.material(flesh).unwrap().term(term).unwrap();
    builder.build().unwrap()
}

#[test]
fn points_that_are_far_from_solids_change_no_bit() {
    let mesh = kuhn_grid(4, 4, 4, [1.0; 3]).unwrap();
    let ball = ImplicitSurface::Sphere {
        center: [0.5, 0.5, 1.28],
        radius: 0.3,
    };
    let points = ContactPoint::on_faces(&mesh, &mesh.boundary().faces);
    let params = RigidContactParams {
        activation: 0.05,
        pressure: 1e4,
        depth: f64::INFINITY,
    };
    let surfaces = vec![RigidSurface::Implicit(ball)];
    let rigid = RigidContact::new(surfaces, None, points, mesh.nodes(), params).unwrap();
    let assemblies = [
        on_a_floor(&mesh, rigid.clone()),
        on_a_floor(&mesh, Whole(rigid.clone(), false)),
    ];
    for by in [0.0, 0.05, 0.4, 0.02] {
        let x: Vec<Point> = mesh
            .nodes()
            .iter()
            .map(|p| [p[0], p[1], p[2] * (1.0 + by)])
            .collect();
        assert_eq!(all(&assemblies[0], &x), all(&assemblies[1], &x), "{by}");
    }
    let raised: Vec<Point> = mesh
        .nodes()
        .iter()
        .map(|p| [p[0], p[1], 1.05 * p[2]])
        .collect();
    let active = rigid
        .active(assemblies[0].positions(&raised).unwrap())
        .unwrap();
    assert!(!active.is_empty() && active.len() < 40, "{}", active.len());
}
