//! Every kind of register gives the same bits, also those that dispatch would not choose here.

use super::quad::{Plain, x86};
use super::registers::{Avx2, Avx2Pair, Avx512, Sse2};
use super::{
    InstructionSet, Pack, PackedKernel, Quad, QuadKernel, QuadScalar, dispatch_registers,
    portable_only, widest,
};
use crate::lanes::{F64x8, Lanes};
use crate::mat::Mat;
use crate::scalar::Real;
use crate::svd::signed_svd;

struct Sample(F64x8, F64x8);

impl PackedKernel for Sample {
    type Output = Vec<F64x8>;
    #[inline(always)]
    fn run<V: Pack>(self) -> Vec<F64x8> {
        let mut results = vec![F64x8::default(); COUNT];
        for part in 0..8 / V::WIDTH {
            let first = part * V::WIDTH;
            let (a, b) = (V::load(&self.0.0, first), V::load(&self.1.0, first));
            for (result, value) in results.iter_mut().zip(sampled(a, b)) {
                value.store(&mut result.0, first);
            }
        }
        results
    }
}

/// How many results there are.
const COUNT: usize = 32;

#[inline(always)]
fn sampled<V: Real>(a: V, b: V) -> [V; COUNT] {
    let F = Mat::<V, 3>([[a, b, a * b], [b, a - b, a], [a + b, a / b, b]]);
    let svd = signed_svd(&F);
    let mask = (a.lt(b) | b.lt(V::zero())) & !a.le(V::one());
    let mut out = [V::zero(); COUNT];
    let numbers = [
        a.ln(),
        a.ln_1p(),
        b.exp(),
        b.exp_m1(),
        a.sqrt(),
        -b,
        b.abs(),
        a.powf(-2.0 / 3.0),
        a.powf(0.3),
        V::select(mask, a, b),
        if V::any(a.lt(a)) { a } else { b },
    ];
    let of_matrix = svd.sigma.into_iter().chain(svd.U.0.into_iter().flatten());
    let of_matrix = of_matrix.chain(svd.V.0.into_iter().flatten());
    for (out, value) in out.iter_mut().zip(numbers.into_iter().chain(of_matrix)) {
        *out = value;
    }
    out
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
    #[target_feature(enable = "avx2")]
    fn avx2_pair(k: Sample) -> Vec<F64x8> {
        k.run::<Avx2Pair>()
    }
    let sample = || {
        Sample(
            Lanes([0.5, 1.5, 1e-300, 2.0, 1e200, 1e-320, 3.0, 0.999]),
            Lanes([-0.5, 1.25, 1e-3, 700.0, -700.0, 1e-20, 0.3, -2.0]),
        )
    };
    // What runs where there are no such registers.
    let expected = sample().run::<f64>();
    assert!(expected.iter().all(|lanes| *lanes != F64x8::default()));
    let Sample(a, b) = sample();
    assert!(same(&sampled(a, b), &expected), "arrays of lanes");
    assert!(same(&sample().run::<Sse2>(), &expected));
    if widest() != InstructionSet::Baseline {
        // SAFETY: AVX2 was just detected (a processor with AVX-512 has it).
        assert!(same(&unsafe { avx2(sample()) }, &expected));
        // SAFETY: likewise.
        assert!(same(&unsafe { avx2_pair(sample()) }, &expected));
    }
    if widest() == InstructionSet::Avx512 {
        // SAFETY: AVX-512 was just detected.
        assert!(same(&unsafe { avx512(sample()) }, &expected));
    }
}

/// How many numbers a pack holds.
struct Width;

impl PackedKernel for Width {
    type Output = usize;
    fn run<V: Pack>(self) -> usize {
        V::WIDTH
    }
}

/// The same, where what is computed waits.
struct WaitingWidth;

impl PackedKernel for WaitingWidth {
    type Output = usize;
    const WAITS: bool = true;
    fn run<V: Pack>(self) -> usize {
        V::WIDTH
    }
}

#[test]
fn what_is_portable_takes_one_number_at_a_time() {
    let widths = || [dispatch_registers(Width), dispatch_registers(WaitingWidth)];
    let wide = match widest() {
        InstructionSet::Baseline => [1, 1],
        InstructionSet::Avx2 => [4, 8],
        InstructionSet::Avx512 => [8, 8],
    };
    assert_eq!(widths(), wide);
    portable_only(true);
    let (width, set) = (widths(), widest());
    portable_only(false);
    assert_eq!((width, set), ([1, 1], InstructionSet::Baseline));
    assert_eq!(widths(), wide);
}

/// Each operation of quadruples, the sum chosen so that it vanishes when the product is rounded
/// first, and does not when somebody fuses the two.
struct Nodes<T> {
    a: [T; 4],
    b: [T; 4],
    /// Minus the rounded products a b.
    minus_ab: [T; 4],
    /// Minus the rounded products a₃ b.
    minus_a3_b: [T; 4],
}
impl<T: Copy> QuadKernel<T> for Nodes<T> {
    type Output = [[T; 4]; 4];
    #[inline(always)]
    fn run<Q: Quad<T>>(self) -> [[T; 4]; 4] {
        let (a, b) = (Q::load(&self.a), Q::load(&self.b));
        let mut out = [self.a; 4];
        (a * b + Q::load(&self.minus_ab)).store(&mut out[0]);
        (Q::load(&self.minus_a3_b).plus_scaled(self.a[3], b)).store(&mut out[1]);
        (a + b).store(&mut out[2]);
        (a * Q::splat(self.b[0])).store(&mut out[3]);
        out
    }
}

macro_rules! nodes {
    ($t:ty) => {{
        let a: [$t; 4] = [0.1, 1.0 / 3.0, -7.7, 1.0 / 7.0];
        let b: [$t; 4] = [0.7, 1.0 / 3.0, 0.3, 1e30];
        let nodes = move || Nodes {
            a,
            b,
            minus_ab: std::array::from_fn(|i| -(a[i] * b[i])),
            minus_a3_b: std::array::from_fn(|i| -(a[3] * b[i])),
        };
        let products: [$t; 4] = std::array::from_fn(|i| a[i] * b[0]);
        let sums: [$t; 4] = std::array::from_fn(|i| a[i] + b[i]);
        let expected = [[0.0; 4], [0.0; 4], sums, products];
        // The inputs would tell: fused, none of the first two rows is 0.
        for i in 0..4 {
            assert_ne!(a[i].mul_add(b[i], -(a[i] * b[i])), 0.0);
            assert_ne!(a[3].mul_add(b[i], -(a[3] * b[i])), 0.0);
        }
        (nodes, expected)
    }};
}

#[test]
fn quadruples_agree_and_are_never_fused() {
    #[target_feature(enable = "avx2")]
    fn avx2(k: Nodes<f64>) -> [[f64; 4]; 4] {
        k.run::<x86::Avx>()
    }
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    fn avx512(k: Nodes<f64>) -> [[f64; 4]; 4] {
        k.run::<x86::Avx>()
    }
    let (wide, expected) = nodes!(f64);
    assert_eq!(f64::dispatch(wide()), expected);
    assert_eq!(wide().run::<Plain<f64>>(), expected);
    assert_eq!(wide().run::<x86::Sse2>(), expected);
    if widest() != InstructionSet::Baseline {
        // SAFETY: AVX2 was just detected (a processor with AVX-512 has it).
        assert_eq!(unsafe { avx2(wide()) }, expected);
    }
    if widest() == InstructionSet::Avx512 {
        // SAFETY: AVX-512 was just detected.
        assert_eq!(unsafe { avx512(wide()) }, expected);
    }
    let (narrow, expected) = nodes!(f32);
    assert_eq!(f32::dispatch(narrow()), expected);
    assert_eq!(narrow().run::<Plain<f32>>(), expected);
    assert_eq!(narrow().run::<x86::Sse>(), expected);
}

/// The operations that mix the numbers of a quadruple or that compare them.
struct Mixed<T>([[T; 4]; 4]);
struct MixedResult<T> {
    /// Floors, absolute values, differences, quotients, maxima, and what three numbers make.
    rows: Vec<[T; 4]>,
    integers: Vec<[i32; 4]>,
    at_most: Vec<bool>,
}
macro_rules! mixed {
    ($t:ty) => {
        impl QuadKernel<$t> for Mixed<$t> {
            type Output = MixedResult<$t>;
            #[inline(always)]
            fn run<Q: Quad<$t>>(self) -> MixedResult<$t> {
                let load = |k: usize| Q::load(&self.0[k]);
                let (a, b) = (load(0), load(1));
                let three: [$t; 3] = [self.0[2][0], self.0[2][1], self.0[2][2]];
                let mut quads = vec![a.floor(), a.abs(), a - b, a / b, a.max(b)];
                quads.push(Q::load_three(&three));
                quads.extend(Q::transposed([a, b, load(2), load(3)]));
                let mut rows: Vec<[$t; 4]> = Vec::new();
                for quad in quads {
                    rows.push([0.0; 4]);
                    quad.store(rows.last_mut().unwrap());
                }
                let mut stored = [7.0; 4];
                b.store_three(stored.first_chunk_mut::<3>().unwrap());
                rows.push(stored);
                let nan = Q::splat(<$t>::NAN);
                MixedResult {
                    rows,
                    integers: vec![a.floor().to_integers(), a.to_integers()],
                    at_most: vec![
                        a.all_at_most(a),
                        a.all_at_most(b),
                        b.all_at_most(a),
                        nan.all_at_most(a),
                        a.all_at_most(nan),
                        nan.floor().all_at_most(Q::splat(2e9))
                            && Q::splat(-2e9).all_at_most(nan.floor()),
                        Q::splat(3e9).floor().abs().all_at_most(Q::splat(2e9)),
                    ],
                }
            }
        }
        impl Mixed<$t> {
            fn check(result: &MixedResult<$t>) {
                let m = Self::sample().0;
                let each = |f: fn($t, $t) -> $t| std::array::from_fn(|i| f(m[0][i], m[1][i]));
                let mut expected: Vec<[$t; 4]> = vec![
                    m[0].map(<$t>::floor),
                    m[0].map(<$t>::abs),
                    each(|a, b| a - b),
                    each(|a, b| a / b),
                    each(<$t>::max),
                    [m[2][0], m[2][1], m[2][2], 0.0],
                ];
                expected.extend((0..4).map(|i| std::array::from_fn(|j| m[j][i])));
                expected.push([m[1][0], m[1][1], m[1][2], 7.0]);
                assert_eq!(result.rows, expected);
                assert_eq!(result.integers, [[-4, 0, 5, -8], [-3, 0, 5, -8]]);
                assert_eq!(
                    result.at_most,
                    [true, false, false, false, false, false, false]
                );
            }
            fn sample() -> Self {
                Self([
                    [-3.25, 0.75, 5.0, -8.0],
                    [-3.5, 1.25, 5.0, 2.0],
                    [0.1, 0.2, 0.3, 0.4],
                    [11.0, 12.0, 13.0, 14.0],
                ])
            }
        }
    };
}
mixed!(f64);
mixed!(f32);

#[test]
fn quadruples_are_mixed_and_compared_alike() {
    #[target_feature(enable = "avx2")]
    fn avx2(k: Mixed<f64>) -> MixedResult<f64> {
        k.run::<x86::Avx>()
    }
    Mixed::<f64>::check(&Mixed::<f64>::sample().run::<Plain<f64>>());
    Mixed::<f64>::check(&Mixed::<f64>::sample().run::<x86::Sse2>());
    Mixed::<f32>::check(&Mixed::<f32>::sample().run::<Plain<f32>>());
    Mixed::<f32>::check(&Mixed::<f32>::sample().run::<x86::Sse>());
    if widest() != InstructionSet::Baseline {
        // SAFETY: AVX2 was just detected (a processor with AVX-512 has it).
        Mixed::<f64>::check(&unsafe { avx2(Mixed::<f64>::sample()) });
    }
}
