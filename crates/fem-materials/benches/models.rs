//! What a model's energy, stress and clamped derivative cost at one F: `cargo bench -p fem-materials`.
#![allow(non_snake_case)]

use criterion::{Criterion, criterion_group, criterion_main};
use fem_kinematics::{HessianProjection, Mat};
use fem_materials::{Material, NeoHookean, StVenantKirchhoff, StableNeoHookean};
use std::hint::black_box;

fn of<M: Material<3>>(criterion: &mut Criterion, name: &str, model: M) {
    let F = Mat([[1.1, 0.2, 0.0], [-0.1, 0.9, 0.05], [0.0, 0.1, 1.2]]);
    criterion.bench_function(&format!("{name}, energy"), |b| {
        b.iter(|| model.energy(black_box(&F)));
    });
    criterion.bench_function(&format!("{name}, stress"), |b| {
        b.iter(|| model.stress(black_box(&F)));
    });
    criterion.bench_function(&format!("{name}, clamped derivative"), |b| {
        b.iter(|| model.evaluate(black_box(&F), HessianProjection::Clamp));
    });
}

fn models(criterion: &mut Criterion) {
    let (mu, lambda) = (1e4, 9e4);
    of(criterion, "neo-Hookean", NeoHookean { mu, lambda });
    of(
        criterion,
        "stable neo-Hookean",
        StableNeoHookean { mu, lambda },
    );
    of(
        criterion,
        "St. Venant-Kirchhoff",
        StVenantKirchhoff { mu, lambda },
    );
}

criterion_group!(benches, models);
criterion_main!(benches);
