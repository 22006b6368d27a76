//! Energy, gradient, Hessian and product of a block of neo-Hookean flesh: `cargo bench -p fem-assembly`.

use criterion::{Criterion, criterion_group, criterion_main};
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs};
use fem_materials::{HessianProjection, NeoHookean};
use fem_solvers::BlockSymmetric;

fn energy(criterion: &mut Criterion) {
    let mesh = kuhn_grid(8, 8, 16, [1.0, 1.0, 2.0]).expect("a grid");
    let rest = mesh.nodes();
    let bottom: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == 0.0).collect();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &bottom).expect("nodes");
    let (mu, lambda) = (1e4, 9e4);
    let builder = AssemblyBuilder::new(&mesh, dofs).expect("a mesh");
    let builder = builder.material(NeoHookean { mu, lambda });
    let assembly = builder.and_then(AssemblyBuilder::build).expect("a block");
    let bent = mesh.nodes().iter();
    let bent: Vec<[f64; 3]> = bent
        .map(|&[x, y, z]| [x + 0.1 * z * z, y, z + 0.05 * x * z])
        .collect();
    let at = assembly.configuration(&bent, &[]).expect("finite");
    let mut gradient = vec![0.0; assembly.dofs().vector_len()];
    let mut hessian = BlockSymmetric::zeros(assembly.pattern().clone());
    let mut group = criterion.benchmark_group("6144 elements");
    group.bench_function("energy", |b| b.iter(|| assembly.energy(at)));
    group.bench_function("gradient", |b| {
        b.iter(|| assembly.gradient(at, &mut gradient).unwrap());
    });
    group.bench_function("clamped Hessian", |b| {
        b.iter(|| assembly.hessian(at, HessianProjection::Clamp, &mut hessian));
    });
    let dx = vec![[1e-3; 3]; bent.len()];
    group.bench_function("product", |b| {
        b.iter(|| assembly.hessian_vector(at, &dx, &mut gradient).unwrap());
    });
    group.finish();
}

criterion_group!(benches, energy);
criterion_main!(benches);
