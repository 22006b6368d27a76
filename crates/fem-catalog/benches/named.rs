//! Models by their names on a block of ten thousand elements: building it, its forces, and products with
//! its stiffness, and its Hessian. `cargo bench -p fem-catalog`

use criterion::{Criterion, criterion_group, criterion_main};
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{Assembly, AssemblyBuilder, Dofs};
use fem_materials::HessianProjection;
use fem_materials::registry::Parameters;
use fem_solvers::BlockSymmetric;

/// A name and its parameters in SI units: a polynomial, principal stretches with a decomposition,
/// invariants, and two with elementary functions.
const MODELS: [(&str, &[(&str, &str)]); 5] = [
    (
        "stable_neo_hookean",
        &[("young", "3e4"), ("poisson", "0.45")],
    ),
    ("fixed_corotated", &[("young", "3e4"), ("poisson", "0.45")]),
    ("inv_neo_hookean", &[("young", "3e4"), ("poisson", "0.45")]),
    (
        "ogden",
        &[
            ("mu", "6.3e5 1.2e3 -1e4"),
            ("alpha", "1.3 5.0 -2.0"),
            ("K", "5e6"),
        ],
    ),
    (
        "hgo",
        &[
            ("c", "3e3"),
            ("K", "1e5"),
            ("k1", "2.4e3"),
            ("k2", "0.84"),
            ("a1", "0.8 0.6 0"),
            ("a2", "0.8 -0.6 0"),
        ],
    ),
];

fn block(mesh: &SimplexMesh<3>, (name, values): (&str, &[(&str, &str)])) -> Assembly<3> {
    let rest = mesh.nodes();
    let bottom: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == 0.0).collect();
    let elements: Vec<usize> = (0..mesh.num_elements()).collect();
    let values = values.iter().map(|&(name, text)| (name, text.to_owned()));
    let values: Parameters = values.collect();
    let dofs = Dofs::with_prescribed_nodes(rest, &bottom).expect("nodes");
    let builder = AssemblyBuilder::new(mesh, dofs).expect("a mesh");
    let builder = fem_catalog::region(builder, &elements, name, &values).expect("a model");
    builder.and_then(AssemblyBuilder::build).expect("a block")
}

fn named(criterion: &mut Criterion) {
    let mesh = kuhn_grid(12, 12, 12, [1.0; 3]).expect("a grid");
    let bent = mesh.nodes().iter();
    let bent: Vec<[f64; 3]> = bent
        .map(|&[x, y, z]| [x + 0.1 * z * z, y, z + 0.05 * x * z])
        .collect();
    let dx = vec![[1e-3; 3]; bent.len()];
    for model in MODELS {
        let body = block(&mesh, model);
        let at = body.configuration(&bent, &[]).expect("finite");
        let mut gradient = vec![0.0; body.dofs().vector_len()];
        let mut matrix = BlockSymmetric::zeros(body.pattern().clone());
        let mut group = criterion.benchmark_group(format!("10368 elements of {}", model.0));
        group.sample_size(20);
        group.bench_function("built", |b| b.iter(|| block(&mesh, model)));
        group.bench_function("gradient", |b| {
            b.iter(|| body.gradient(at, &mut gradient).unwrap());
        });
        group.bench_function("product", |b| {
            b.iter(|| body.hessian_vector(at, &dx, &mut gradient).unwrap());
        });
        group.bench_function("Hessian", |b| {
            b.iter(|| body.hessian(at, HessianProjection::None, &mut matrix));
        });
        group.finish();
    }
}

criterion_group!(benches, named);
criterion_main!(benches);
