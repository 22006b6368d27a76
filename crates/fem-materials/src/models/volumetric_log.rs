//! The resistance to a change of volume, K/2 (ln J)² (document 000, 4.2).

use crate::material::{Material, Symmetry};
use crate::near_rest::{RestMeasures, infinite_unless_positive};
use crate::registry::{Entry, Parameter, Register};
use crate::tensor_terms::Terms;
use fem_kinematics::{Mat, Real, Tensor4};

/// ψ = K/2 (ln J)², finite only for J > 0. Add it to an isochoric model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumetricLog {
    /// Bulk modulus K, Pa.
    pub K: f64,
}

const PARAMETERS: [Parameter; 1] = [Parameter::pascals("K", "6e4", "bulk modulus")];

pub(crate) fn register(visitor: &mut impl Register) {
    let entry = Entry {
        name: "volumetric_log",
        aliases: &[],
        elastic: None,
        about: "the volume term for isochoric models (document 000)",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            Ok(VolumetricLog {
                K: p.non_negative("K")?,
            })
        },
    };
    visitor.plane(&entry);
    visitor.solid(&entry);
}

impl<const D: usize> Material<D> for VolumetricLog {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        let rest = RestMeasures::new(F);
        let log_J = rest.log_J();
        infinite_unless_positive(rest.J, T::from_f64(0.5 * self.K) * log_J * log_J)
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        let H = F.cofactor().scale(F.determinant().recip());
        H.scale(T::from_f64(self.K) * RestMeasures::new(F).log_J())
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let K = T::from_f64(self.K);
        let H = F.cofactor().scale(F.determinant().recip());
        let p = K * RestMeasures::new(F).log_J();
        H.scale(K * H.dot(dF)) - (H * dF.tr_mul(&H)).scale(p)
    }

    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        let K = T::from_f64(self.K);
        let H = F.cofactor().scale(F.determinant().recip());
        let p = K * RestMeasures::new(F).log_J();
        Terms::new().outer(K, &H, &H).transposed(-p, &H, &H).0
    }
}
