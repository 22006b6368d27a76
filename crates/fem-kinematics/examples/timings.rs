//! Nanoseconds per value of the elementary functions and decompositions, scalar and in lanes.
//!
//! `cargo run --release -p fem-kinematics --example timings`
#![allow(non_snake_case)]

use fem_kinematics::*;
use std::hint::black_box;
use std::time::Instant;

const N: usize = 8 * 256;

struct Map<'a, T, F>(&'a [T], &'a mut [T], F);

impl<T: Real, F: Fn(T) -> T> Kernel for Map<'_, T, F> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (x, y) in self.0.iter().zip(self.1.iter_mut()) {
            *y = (self.2)(*x);
        }
    }
}

struct MapMatrix<'a, T, F>(&'a [Mat<T, 3>], &'a mut [T], F);

impl<T: Real, F: Fn(&Mat<T, 3>) -> T> Kernel for MapMatrix<'_, T, F> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (x, y) in self.0.iter().zip(self.1.iter_mut()) {
            *y = (self.2)(x);
        }
    }
}

struct PackedMap<'a, F>(&'a [F64x8], &'a mut [F64x8], F);
struct PackedMatrixMap<'a, F>(&'a [Mat<F64x8, 3>], &'a mut [F64x8], F);

/// A function of one number, or of one matrix, for every kind of pack.
trait Function {
    fn of<T: Real>(&self, x: T) -> T;
}
trait MatrixFunction {
    fn of<T: Real>(&self, F: &Mat<T, 3>) -> T;
}

impl<F: Function> PackedKernel for PackedMap<'_, F> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        for (x, y) in self.0.iter().zip(self.1.iter_mut()) {
            for part in 0..8 / V::WIDTH {
                let first = part * V::WIDTH;
                let value = self.2.of(V::load(&x.0, first));
                value.store(&mut y.0, first);
            }
        }
    }
}

impl<F: MatrixFunction> PackedKernel for PackedMatrixMap<'_, F> {
    type Output = ();
    const WAITS: bool = true;
    #[inline(always)]
    fn run<V: Pack>(self) {
        for (x, y) in self.0.iter().zip(self.1.iter_mut()) {
            for part in 0..8 / V::WIDTH {
                let first = part * V::WIDTH;
                let x = Mat::from_fn(|i, j| V::load(&x.0[i][j].0, first));
                self.2.of(&x).store(&mut y.0, first);
            }
        }
    }
}

/// The best of several rounds, per value.
fn time(values: usize, mut f: impl FnMut()) -> f64 {
    (0..15)
        .map(|_| {
            let start = Instant::now();
            for _ in 0..4 {
                f();
            }
            start.elapsed().as_secs_f64() * 1e9 / (4 * values) as f64
        })
        .fold(f64::INFINITY, f64::min)
}

macro_rules! scalar_function {
    ($name:expr, $x:expr, |$v:ident| $f:expr) => {{
        struct This;
        impl Function for This {
            #[inline(always)]
            fn of<T: Real>(&self, $v: T) -> T {
                $f
            }
        }
        let x: Vec<f64> = $x;
        let lanes: Vec<F64x8> = x
            .chunks_exact(8)
            .map(|c| Lanes(c.try_into().unwrap()))
            .collect();
        let (mut y, mut ys) = (vec![0.0; N], vec![F64x8::default(); N / 8]);
        let scalar = time(N, || {
            dispatch(Map(black_box(&x), &mut y, |x: f64| This.of(x)))
        });
        let arrays = time(N, || {
            dispatch(Map(black_box(&lanes), &mut ys, |x: F64x8| This.of(x)))
        });
        let packed = time(N, || {
            dispatch_packed(PackedMap(black_box(&lanes), &mut ys, This))
        });
        for (a, b) in y.iter().zip(ys.iter().flat_map(|v| v.0)) {
            assert_eq!(a.to_bits(), b.to_bits(), "{}", $name);
        }
        println!("{:<28}{scalar:>9.2}{arrays:>9.2}{packed:>9.2}", $name);
    }};
}

macro_rules! matrix_function {
    ($name:expr, $F:expr, |$v:ident| $f:expr) => {{
        struct This;
        impl MatrixFunction for This {
            #[inline(always)]
            fn of<T: Real>(&self, $v: &Mat<T, 3>) -> T {
                $f
            }
        }
        let F: Vec<Mat<f64, 3>> = $F;
        let lanes: Vec<Mat<F64x8, 3>> = F
            .chunks_exact(8)
            .map(|c| Mat::from_fn(|i, j| Lanes(std::array::from_fn(|k| c[k].0[i][j]))))
            .collect();
        let (mut y, mut ys) = (vec![0.0; N], vec![F64x8::default(); N / 8]);
        let scalar = time(N, || {
            dispatch(MapMatrix(black_box(&F), &mut y, |x: &Mat<f64, 3>| {
                This.of(x)
            }))
        });
        let arrays = time(N, || {
            dispatch(MapMatrix(
                black_box(&lanes),
                &mut ys,
                |x: &Mat<F64x8, 3>| This.of(x),
            ))
        });
        let packed = time(N, || {
            dispatch_packed(PackedMatrixMap(black_box(&lanes), &mut ys, This))
        });
        for (a, b) in y.iter().zip(ys.iter().flat_map(|v| v.0)) {
            assert_eq!(a.to_bits(), b.to_bits(), "{}", $name);
        }
        println!("{:<28}{scalar:>9.2}{arrays:>9.2}{packed:>9.2}", $name);
    }};
}

fn main() {
    let mut state = 1_u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let positive: Vec<f64> = (0..N).map(|_| 0.1 + 3.0 * random()).collect();
    let F: Vec<Mat<f64, 3>> = (0..N)
        .map(|_| Mat::identity() + Mat::from_fn(|_, _| 0.3 * (random() - 0.5)))
        .collect();
    println!(
        "{:<28}{:>9}{:>9}{:>9}   ns per value",
        "", "scalar", "F64x8", "packed"
    );
    scalar_function!("divide", positive.clone(), |x| Real::recip(x));
    scalar_function!("sqrt", positive.clone(), |x| Real::sqrt(x));
    scalar_function!("ln", positive.clone(), |x| Real::ln(x));
    scalar_function!("ln_1p", positive.clone(), |x| Real::ln_1p(x));
    scalar_function!("exp", positive.clone(), |x| Real::exp(x));
    scalar_function!("exp_m1", positive.clone(), |x| Real::exp_m1(x));
    scalar_function!("x^(-2/3)", positive.clone(), |x| Real::powf(x, -2.0 / 3.0));
    scalar_function!("x^1.7", positive.clone(), |x| Real::powf(x, 1.7));
    matrix_function!("det", F.clone(), |F| Mat::determinant(F));
    matrix_function!("ln det", F.clone(), |F| log_determinant(F));
    matrix_function!("signed_svd", F.clone(), |F| {
        let s = signed_svd(F);
        s.sigma[2] + s.U.0[2][1] + s.V.0[1][2]
    });
    matrix_function!("polar", F.clone(), |F| {
        let p = polar(F);
        p.R.0[1][2] + p.S.0[0][1]
    });
    matrix_function!("signed_qr", F.clone(), |F| {
        let q = signed_qr(F);
        q.Q.0[1][2] + q.R.0[0][1]
    });
}
