//! A model by its name on a block of ten thousand elements: building it, its forces, and products with
//! its stiffness. `cargo bench -p fem-catalog`

use criterion::{Criterion, criterion_group, criterion_main};
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{Assembly, AssemblyBuilder, Dofs};
use fem_materials::registry::Parameters;

const MODEL: &str = "stable_neo_hookean";

fn block(mesh: &SimplexMesh<3>) -> Assembly<3> {
    let rest = mesh.nodes();
    let bottom: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == 0.0).collect();
    let elements: Vec<usize> = (0..mesh.num_elements()).collect();
    let soft = [("young", "3e4"), ("poisson", "0.45")];
    let soft = soft.map(|(name, text)| (name, text.to_owned()));
    let soft: Parameters = soft.into_iter().collect();
    let dofs = Dofs::with_prescribed_nodes(rest, &bottom).expect("nodes");
    let builder = AssemblyBuilder::new(mesh, dofs).expect("a mesh");
    let builder = fem_catalog::region(builder, &elements, MODEL, &soft).expect("a model");
    builder.and_then(AssemblyBuilder::build).expect("a block")
}

fn named(criterion: &mut Criterion) {
    let mesh = kuhn_grid(12, 12, 12, [1.0; 3]).expect("a grid");
    let body = block(&mesh);
    let bent = mesh.nodes().iter();
    let bent: Vec<[f64; 3]> = bent
        .map(|&[x, y, z]| [x + 0.1 * z * z, y, z + 0.05 * x * z])
        .collect();
    let at = body.configuration(&bent, &[]).expect("finite");
    let mut gradient = vec![0.0; body.dofs().unknowns()];
    let dx = vec![[1e-3; 3]; bent.len()];
    let mut group = criterion.benchmark_group("10368 elements by name");
    group.sample_size(20);
    group.bench_function("built", |b| b.iter(|| block(&mesh)));
    group.bench_function("gradient", |b| {
        b.iter(|| body.gradient(at, &mut gradient).unwrap());
    });
    group.bench_function("product", |b| {
        b.iter(|| body.hessian_vector(at, &dx, &mut gradient).unwrap());
    });
    group.finish();
}

criterion_group!(benches, named);
criterion_main!(benches);
