//! Nobody pays for what a model does not need, counted by a scalar that counts.

use core::cell::Cell;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};
use fem_kinematics::{Mat, Real, signed_svd};
use fem_materials::field::MaterialField;
use fem_materials::registry::{Entry, ModelVisitor, for_each_model};
use fem_materials::{HessianProjection, Material};

thread_local! {
    static ROOTS: Cell<usize> = const { Cell::new(0) };
}

/// An `f64` whose square roots are counted: 24 and more in a singular value decomposition.
#[derive(Clone, Copy, Debug, Default)]
struct Counted(f64);

/// The roots that `work` takes.
fn roots<R>(work: impl FnOnce() -> R) -> usize {
    ROOTS.set(0);
    let _ = work();
    ROOTS.get()
}

macro_rules! binary {
    ($($trait:ident $method:ident $assign:ident $assign_method:ident $op:tt;)*) => {$(
        impl $trait for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(self.0 $op other.0)
            }
        }
        impl $assign for Counted {
            fn $assign_method(&mut self, other: Self) {
                self.0 = self.0 $op other.0;
            }
        }
    )*};
}
binary! {
    Add add AddAssign add_assign +;
    Sub sub SubAssign sub_assign -;
    Mul mul MulAssign mul_assign *;
}
impl Div for Counted {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }
}
impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Real for Counted {
    type Mask = bool;
    const EPSILON: f64 = f64::EPSILON;
    fn from_f64(value: f64) -> Self {
        Self(value)
    }
    fn sqrt(self) -> Self {
        ROOTS.set(ROOTS.get() + 1);
        Self(self.0.sqrt())
    }
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    fn ln(self) -> Self {
        Self(self.0.ln())
    }
    fn ln_1p(self) -> Self {
        Self(self.0.ln_1p())
    }
    fn exp(self) -> Self {
        Self(self.0.exp())
    }
    fn exp_m1(self) -> Self {
        Self(self.0.exp_m1())
    }
    fn powf(self, exponent: f64) -> Self {
        Self(self.0.powf(exponent))
    }
    fn lt(self, other: Self) -> bool {
        self.0 < other.0
    }
    fn le(self, other: Self) -> bool {
        self.0 <= other.0
    }
    fn select(mask: bool, if_true: Self, if_false: Self) -> Self {
        if mask { if_true } else { if_false }
    }
    fn any(mask: bool) -> bool {
        mask
    }
}

/// How many models were visited, and which decompose.
struct Visitor(usize, Vec<&'static str>);

impl ModelVisitor for Visitor {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        if D != 3 {
            return;
        }
        let material = entry.build(&entry.defaults()).unwrap();
        let F = Mat::<Counted, D>::from_fn(|i, j| {
            Counted(f64::from(i == j) + 0.1 * ((3 * i + j) as f64).sin())
        });
        let of_svd = roots(|| signed_svd(&F));
        assert!(of_svd >= 24, "{of_svd}");
        let counts = [
            roots(|| material.energy(&F)),
            roots(|| material.stress(&F)),
            roots(|| material.stress_differential(&F, &F)),
            roots(|| material.stress_derivative(&F)),
            roots(|| material.evaluate(&F, HessianProjection::None)),
        ];
        let projected = roots(|| material.projected_derivative(&F, HessianProjection::Clamp));
        if <M as MaterialField<D>>::PROJECTION_DECOMPOSES {
            assert!(projected >= of_svd, "{}: {projected} roots", entry.name);
        }
        for count in counts {
            // One decomposition, and never two, for everything together.
            let right = if M::DECOMPOSES {
                count >= of_svd && count < 2 * of_svd
            } else {
                count <= 8
            };
            assert!(
                right,
                "{}: {counts:?} roots, {of_svd} in an SVD",
                entry.name
            );
        }
        self.0 += 1;
        self.1.extend(M::DECOMPOSES.then_some(entry.name));
    }
}

#[test]
fn only_models_of_the_stretches_decompose_and_only_once() {
    let mut visitor = Visitor(0, Vec::new());
    for_each_model(&mut visitor);
    assert!(visitor.0 > 15);
    // "SVD" in `docs/models.md`, which is written from `DECOMPOSES`.
    visitor.1.sort_unstable();
    assert_eq!(visitor.1, ["arap", "corotated", "fixed_corotated", "ogden"]);
}
