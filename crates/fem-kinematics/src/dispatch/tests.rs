//! Every kind of register gives the same bits, also those that dispatch would not choose here.

use super::quad::{Plain, x86};
use super::registers::{Avx2, Avx512, Sse2};
use super::{InstructionSet, Pack, PackedKernel, Quad, QuadKernel, QuadScalar, widest};
use crate::lanes::{F64x8, Lanes};
use crate::mat::Mat;
use crate::svd::signed_svd;

struct Sample(F64x8, F64x8);

impl PackedKernel for Sample {
    type Output = Vec<F64x8>;
    #[inline(always)]
    fn run<V: Pack>(self) -> Vec<F64x8> {
        let (a, b) = (V::from_lanes(self.0), V::from_lanes(self.1));
        let F = Mat::<V, 3>([[a, b, a * b], [b, a - b, a], [a + b, a / b, b]]);
        let svd = signed_svd(&F);
        let mask = (a.lt(b) | b.lt(V::zero())) & !a.le(V::one());
        let mut out = vec![
            a.ln(),
            a.ln_1p(),
            b.exp(),
            b.exp_m1(),
            a.sqrt(),
            -b,
            b.abs(),
        ];
        out.extend([a.powf(-2.0 / 3.0), a.powf(0.3), V::select(mask, a, b)]);
        out.push(if V::any(mask) { a } else { b });
        out.extend(svd.sigma);
        out.extend(svd.U.0.into_iter().flatten());
        out.into_iter().map(V::to_lanes).collect()
    }
}

fn same(a: &[F64x8], b: &[F64x8]) -> bool {
    let bits = |v: &[F64x8]| -> Vec<u64> { v.iter().flat_map(|l| l.0).map(f64::to_bits).collect() };
    bits(a) == bits(b)
}

#[test]
fn registers_agree() {
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    fn avx512(k: Sample) -> Vec<F64x8> {
        k.run::<Avx512>()
    }
    #[target_feature(enable = "avx2")]
    fn avx2(k: Sample) -> Vec<F64x8> {
        k.run::<Avx2>()
    }
    let sample = || {
        Sample(
            Lanes([0.5, 1.5, 1e-300, 2.0, 1e200, 1e-320, 3.0, 0.999]),
            Lanes([-0.5, 1.25, 1e-3, 700.0, -700.0, 1e-20, 0.3, -2.0]),
        )
    };
    let expected = sample().run::<F64x8>();
    assert!(same(&sample().run::<Sse2>(), &expected));
    if widest() != InstructionSet::Baseline {
        // SAFETY: AVX2 was just detected (a processor with AVX-512 has it).
        assert!(same(&unsafe { avx2(sample()) }, &expected));
    }
    if widest() == InstructionSet::Avx512 {
        // SAFETY: AVX-512 was just detected.
        assert!(same(&unsafe { avx512(sample()) }, &expected));
    }
}

/// Sums and products of quadruples, a fused multiply-add among them if anybody made one.
struct Nodes<T>([[T; 4]; 3]);
impl<T: Copy> QuadKernel<T> for Nodes<T> {
    type Output = [T; 4];
    #[inline(always)]
    fn run<Q: Quad<T>>(self) -> [T; 4] {
        let [a, b, c] = self.0;
        let sum = Q::load(&a) * Q::load(&b) + Q::load(&c);
        let sum = sum.plus_scaled(a[3], Q::load(&b));
        let mut out = a;
        (sum + Q::splat(b[1]) * sum).store(&mut out);
        out
    }
}

#[test]
fn quadruples_agree() {
    #[target_feature(enable = "avx2")]
    fn avx(k: Nodes<f64>) -> [f64; 4] {
        k.run::<x86::Avx>()
    }
    let wide = || {
        Nodes([
            [0.1, 1.0 / 3.0, 1e-200, 7.0],
            [0.7, -0.3, 1e-200, 1e300],
            [-0.07, 0.1, 3e-320, 1.0],
        ])
    };
    let expected = wide().run::<Plain<f64>>().map(f64::to_bits);
    assert_eq!(f64::dispatch(wide()).map(f64::to_bits), expected);
    assert_eq!(wide().run::<x86::Sse2>().map(f64::to_bits), expected);
    if widest() != InstructionSet::Baseline {
        // SAFETY: AVX2 was just detected (a processor with AVX-512 has it).
        assert_eq!(unsafe { avx(wide()) }.map(f64::to_bits), expected);
    }
    let narrow = || {
        Nodes([
            [0.1f32, 1.0 / 3.0, 1e-30, 7.0],
            [0.7, -0.3, 1e-30, 1e30],
            [-0.07, 0.1, 1e-42, 1.0],
        ])
    };
    let expected = narrow().run::<Plain<f32>>().map(f32::to_bits);
    assert_eq!(f32::dispatch(narrow()).map(f32::to_bits), expected);
    assert_eq!(narrow().run::<x86::Sse>().map(f32::to_bits), expected);
}
