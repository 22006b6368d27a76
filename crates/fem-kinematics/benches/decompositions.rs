//! What a decomposition costs, scalar and eight at a time: `cargo bench -p fem-kinematics`.
#![allow(non_snake_case)]

use criterion::{Criterion, criterion_group, criterion_main};
use fem_kinematics::{
    F64x8, Lanes, Mat, Pack, PackedKernel, ROW_MAJOR_3D, Real, Tensor4, dispatch_packed, from_flat,
    polar, signed_qr, signed_svd,
};
use std::hint::black_box;

/// Deformation gradients without any structure.
fn matrices() -> [Mat<f64, 3>; 8] {
    core::array::from_fn(|n| {
        Mat::from_fn(|i, j| f64::from(i == j) + 0.3 * ((3 * i + j + 7 * n) as f64).sin())
    })
}

#[derive(Clone, Copy)]
enum Of {
    Svd,
    Polar,
    Qr,
}

impl Of {
    #[inline(always)]
    fn apply<T: Real>(self, F: &Mat<T, 3>) -> T {
        match self {
            Self::Svd => signed_svd(F).sigma[2],
            Self::Polar => polar(F).R.0[0][1],
            Self::Qr => signed_qr(F).R.0[0][1],
        }
    }
}

/// Eight matrices in the widest registers of the processor.
struct Eight(Of, Mat<F64x8, 3>);

impl PackedKernel for Eight {
    type Output = F64x8;
    const WAITS: bool = true;
    #[inline(always)]
    fn run<V: Pack>(self) -> F64x8 {
        let mut results = F64x8::default();
        for part in 0..8 / V::WIDTH {
            let first = part * V::WIDTH;
            let F = Mat::<V, 3>::from_fn(|i, j| V::load(&self.1.0[i][j].0, first));
            self.0.apply(&F).store(&mut results.0, first);
        }
        results
    }
}

fn decompositions(criterion: &mut Criterion) {
    let all = matrices();
    let packed = Mat::<F64x8, 3>::from_fn(|i, j| Lanes(core::array::from_fn(|n| all[n].0[i][j])));
    for (name, of) in [("svd", Of::Svd), ("polar", Of::Polar), ("qr", Of::Qr)] {
        criterion.bench_function(&format!("{name}, one"), |b| {
            b.iter(|| of.apply(black_box(&all[0])));
        });
        criterion.bench_function(&format!("{name}, eight"), |b| {
            b.iter(|| dispatch_packed(Eight(of, *black_box(&packed))));
        });
    }
}

fn projection(criterion: &mut Criterion) {
    let flat = core::array::from_fn(|i| core::array::from_fn(|j| ((i * j + i + j) as f64).cos()));
    let tensor: Tensor4<f64, 3> = from_flat(&flat, &ROW_MAJOR_3D);
    criterion.bench_function("numeric projection of dP/dF", |b| {
        b.iter(|| black_box(&tensor).project(|x| x.max(0.0)));
    });
}

criterion_group!(benches, decompositions, projection);
criterion_main!(benches);
