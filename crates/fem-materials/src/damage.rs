//! Materials that a damage may weaken.

use crate::field::MaterialField;
use crate::material::Material;
use fem_kinematics::Real;

/// A [`MaterialField`] whose local parameters are known from a damage d: 0 whole, 1 broken.
///
/// What simulates fracture keeps one d for each element or particle and asks this trait for the
/// rest. A [`Material`] has no local parameters and ignores damage.
pub trait DamageField<const D: usize>: MaterialField<D> {
    /// The local parameters at damage d, 0 to 1.
    fn at_damage<T: Real>(d: T) -> Self::Local<T>;
}

impl<const D: usize, M: Material<D>> DamageField<D> for M {
    #[inline(always)]
    fn at_damage<T: Real>(_: T) {}
}
