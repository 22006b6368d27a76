//! dx/dθ of a block of flesh with muscles, by columns and by adjoints: `cargo bench -p face-rig`.

use criterion::{Criterion, criterion_group, criterion_main};
use face_rig::anatomy::EmbeddedPoint;
use face_rig::rig::{Direction, EmbeddedPoints, JacobianRoute, Parameters, Rig, RigParams};
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs, Fiber};
use fem_materials::curves::PhysBam;
use fem_materials::{FiberLaw, StableNeoHookean, Stretch};

const MUSCLES: usize = 8;

/// Flesh between two plates: the lower one is the cranium, the upper one the jaw.
fn rig() -> Rig {
    let mesh = kuhn_grid(6, 6, 12, [0.04, 0.04, 0.08]).expect("a grid");
    let rest = mesh.nodes();
    let at = |z: f64| (0..rest.len()).filter(move |&n| (rest[n][2] - z).abs() < 1e-9);
    let (cranium, jaw): (Vec<usize>, Vec<usize>) = (at(0.0).collect(), at(0.08).collect());
    let prescribed = [cranium, jaw.clone()].concat();
    let fiber = |element| Fiber {
        element,
        control: element % MUSCLES,
        direction: [0.0, 0.6, 0.8],
        max_isometric_stress: 2e4,
        optimal_stretch: 1.0,
    };
    let fibers: Vec<Fiber> = (0..mesh.num_elements()).map(fiber).collect();
    let law = FiberLaw {
        curve: PhysBam::default(),
        stretch: Stretch::Total,
    };
    let (mu, lambda) = (1e4, 9e4);
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed).expect("nodes");
    let builder = AssemblyBuilder::new(&mesh, dofs).expect("a mesh");
    let builder = builder.material(StableNeoHookean { mu, lambda });
    let builder = builder.and_then(|b| b.fibers(law, MUSCLES, &fibers));
    let assembly = builder.and_then(AssemblyBuilder::build).expect("flesh");
    Rig::new(assembly, &jaw, RigParams::default()).expect("a rig")
}

fn derivative(criterion: &mut Criterion) {
    let mut rig = rig();
    let mut pose = Parameters::rest(MUSCLES);
    pose.activations.fill(0.3);
    rig.solve(&pose).expect("an equilibrium");
    let nodes = (0..rig.assembly().rest().len() as u32).step_by(10);
    let points = EmbeddedPoints(nodes.map(EmbeddedPoint::node).collect());
    let directions = Direction::all(MUSCLES);
    let mut group = criterion.benchmark_group("3456 elements");
    for (name, route) in [
        ("columns", JacobianRoute::Columns),
        ("adjoint", JacobianRoute::Adjoint),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| {
                let sensitivity = rig.sensitivity().expect("stable");
                sensitivity.jacobian(&points, &directions, route).unwrap()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, derivative);
criterion_main!(benches);
