//! The built-in face of 20,000 tetrahedra, and the rig that it becomes: `cargo bench -p face-scenes`.

use criterion::{Criterion, criterion_group, criterion_main};
use face_rig::rig::RigParams;
use face_scenes::Scene;

fn builtin(criterion: &mut Criterion) {
    let face = Scene::builtin(20_000).expect("a face");
    let mut group = criterion.benchmark_group("20000 tetrahedra");
    group.sample_size(10);
    group.bench_function("face", |b| {
        b.iter(|| Scene::builtin(20_000).expect("a face"))
    });
    group.bench_function("rig", |b| {
        b.iter(|| face.rig(RigParams::default()).expect("a rig"));
    });
    group.finish();
}

criterion_group!(benches, builtin);
criterion_main!(benches);
