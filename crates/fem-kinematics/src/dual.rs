//! Dual numbers: exact derivatives of any kernel, to rounding.

use crate::scalar::Real;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// a + b ε with ε² = 0: a value and its derivative in one direction.
///
/// Nest it (`Dual<Dual<f64>>`) for second derivatives.
///
/// ```
/// use fem_kinematics::{Dual, Real};
/// let x = Dual::variable(2.0_f64);
/// assert_eq!((x * x * x).derivative, 12.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dual<T> {
    /// The value a.
    pub value: T,
    /// The derivative b.
    pub derivative: T,
}

impl<T: Real> Dual<T> {
    /// A value with the given derivative.
    #[inline(always)]
    pub fn new(value: T, derivative: T) -> Self {
        Self { value, derivative }
    }
    /// The variable itself: derivative 1.
    #[inline(always)]
    pub fn variable(value: T) -> Self {
        Self::new(value, T::one())
    }
    #[inline(always)]
    fn chain(self, value: T, slope: T) -> Self {
        Self::new(value, slope * self.derivative)
    }
}

impl<T: Real> Add for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.value + o.value, self.derivative + o.derivative)
    }
}
impl<T: Real> Sub for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.value - o.value, self.derivative - o.derivative)
    }
}
impl<T: Real> Mul for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self::new(
            self.value * o.value,
            self.derivative * o.value + self.value * o.derivative,
        )
    }
}
impl<T: Real> Div for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let q = self.value / o.value;
        Self::new(q, (self.derivative - q * o.derivative) / o.value)
    }
}
impl<T: Real> Neg for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.value, -self.derivative)
    }
}
impl<T: Real> AddAssign for Dual<T> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl<T: Real> SubAssign for Dual<T> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
impl<T: Real> MulAssign for Dual<T> {
    #[inline(always)]
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}

impl<T: Real> Real for Dual<T> {
    type Mask = T::Mask;
    const EPSILON: f64 = T::EPSILON;
    const DERIVATIVES: usize = T::DERIVATIVES + 1;
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self::new(T::from_f64(value), T::zero())
    }
    #[inline(always)]
    fn constant(self) -> Self {
        Self::new(self.value.constant(), T::zero())
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, T::from_f64(0.5) / root)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::select(self.value.lt(T::zero()), -self, self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.chain(self.value.ln(), self.value.recip())
    }
    #[inline(always)]
    fn ln_1p(self) -> Self {
        self.chain(self.value.ln_1p(), (T::one() + self.value).recip())
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }
    #[inline(always)]
    fn exp_m1(self) -> Self {
        self.chain(self.value.exp_m1(), self.value.exp())
    }
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        let slope = T::from_f64(exponent) * self.value.powf(exponent - 1.0);
        self.chain(self.value.powf(exponent), slope)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> T::Mask {
        self.value.lt(other.value)
    }
    #[inline(always)]
    fn le(self, other: Self) -> T::Mask {
        self.value.le(other.value)
    }
    #[inline(always)]
    fn select(mask: T::Mask, a: Self, b: Self) -> Self {
        Self::new(
            T::select(mask, a.value, b.value),
            T::select(mask, a.derivative, b.derivative),
        )
    }
    #[inline(always)]
    fn any(mask: T::Mask) -> bool {
        T::any(mask)
    }
}
