//! The artery wall of Holzapfel, Gasser and Ogden (2000): two families of stiffening fibers.

use crate::isotropic::{FirstInvariant, FirstInvariantEnergy, Volume};
use crate::lame::Space;
use crate::material::Material;
use crate::registry::{Entry, Parameter, Register};
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Real, Tensor4, dot, vector};

/// ψ = c/2 (J^(−2/3) tr C − 3) + K/2 (ln J)² + Σ k₁/(2k₂) (exp(k₂ e²) − 1), e = max(|F a|² − 1, 0).
///
/// The fibers pull only when stretched. They feel |F a| itself, not its isochoric part: with the
/// latter a pressure would change the shape of an anisotropic solid (Nolan, Gower, Destrade,
/// Ogden and McGarry 2014). Finite only for J > 0; the stiffness jumps at |F a| = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HolzapfelGasserOgden {
    /// Shear modulus of the ground substance c, Pa.
    pub c: f64,
    /// Bulk modulus K, Pa.
    pub K: f64,
    /// Stiffness of the fibers k₁, Pa.
    pub k1: f64,
    /// Growth of their stiffness k₂ > 0, without unit.
    pub k2: f64,
    /// Directions of the two families in the rest shape, of length 1.
    pub fibers: [[f64; 3]; 2],
}

/// W = c/2 i.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ground {
    c: f64,
}

impl FirstInvariantEnergy for Ground {
    #[inline(always)]
    fn energy_and_slopes<T: Real>(&self, i: T) -> [T; 3] {
        let half = T::from_f64(0.5 * self.c);
        [half * i, half, T::zero()]
    }
}

const PARAMETERS: [Parameter; 6] = [
    Parameter::pascals("c", "3e3", "shear modulus of the ground substance"),
    Parameter::pascals("K", "1e5", "bulk modulus"),
    Parameter::pascals("k1", "2.4e3", "stiffness of the fibers"),
    Parameter::plain("k2", "0.84", "growth of the fibers' stiffness"),
    Parameter::plain(
        "a1",
        "0.8 0.6 0",
        "direction of the first family, of length 1",
    ),
    Parameter::plain(
        "a2",
        "0.8 -0.6 0",
        "direction of the second family, of length 1",
    ),
];

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "hgo",
        aliases: &[],
        elastic: Some(|lame| vec![("c", lame.mu), ("K", lame.bulk(Space::Solid))]),
        about: "arteries, skin: two families of fibers that stiffen",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            Ok(HolzapfelGasserOgden {
                c: p.non_negative("c")?,
                K: p.non_negative("K")?,
                k1: p.non_negative("k1")?,
                k2: p.positive("k2")?,
                fibers: [p.direction("a1")?, p.direction("a2")?],
            })
        },
    });
}

/// One family at one F, as a function of q = |F a|²: ψ = h(q).
struct Family<T> {
    a: [T; 3],
    /// F a.
    v: [T; 3],
    energy: T,
    /// 2 h′, ≥ 0.
    pull: T,
    /// 4 h″, ≥ 0.
    stiffening: T,
}

impl HolzapfelGasserOgden {
    #[inline(always)]
    fn ground(&self) -> FirstInvariant<Ground> {
        FirstInvariant {
            shape: Ground { c: self.c },
            volume: Volume { K: self.K },
        }
    }

    #[inline(always)]
    fn families<T: Real>(&self, F: &Mat<T, 3>) -> [Family<T>; 2] {
        [self.family(F, 0), self.family(F, 1)]
    }

    #[inline(always)]
    fn family<T: Real>(&self, F: &Mat<T, 3>, which: usize) -> Family<T> {
        let (k1, k2) = (T::from_f64(self.k1), T::from_f64(self.k2));
        let G = *F - Mat::identity();
        let a = vector(|i| T::from_f64(self.fibers[which][i]));
        let (v, w) = (F.mul_vec(a), G.mul_vec(a));
        // |F a|² − 1 = w·(2a + w) + (|a|² − 1)
        let excess = T::from_f64(2.0) * dot(w, a) + dot(w, w) + (dot(a, a) - T::one());
        let slack = excess.le(T::zero());
        let e = T::select(slack, T::zero(), excess);
        let x = k2 * e * e;
        let grown = x.exp_m1();
        let factor = k1 * (grown + T::one());
        let two = T::from_f64(2.0);
        let stiffening = two * two * factor * (T::one() + two * x);
        Family {
            a,
            v,
            energy: T::from_f64(0.5) * k1 / k2 * grown,
            pull: two * factor * e,
            stiffening: T::select(slack, T::zero(), stiffening),
        }
    }

    /// pull I + stiffening v vᵀ, the matrix k of dP = (k dF a) aᵀ.
    #[inline(always)]
    fn add_fibers<T: Real>(&self, mut derivative: Tensor4<T, 3>, F: &Mat<T, 3>) -> Tensor4<T, 3> {
        for family in self.families(F) {
            let mut k = Mat::outer(family.v, family.v).scale(family.stiffening);
            for i in 0..3 {
                k.0[i][i] += family.pull;
            }
            for j in 0..3 {
                for l in 0..3 {
                    derivative.0[j][l] += k.scale(family.a[j] * family.a[l]);
                }
            }
        }
        derivative
    }
}

impl Material<3> for HolzapfelGasserOgden {
    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, 3>) -> T {
        let [first, second] = self.families(F);
        self.ground().energy(F) + (first.energy + second.energy)
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, 3>) -> Mat<T, 3> {
        let mut P = self.ground().stress(F);
        for family in self.families(F) {
            P += Mat::outer(family.v, family.a).scale(family.pull);
        }
        P
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, 3>, dF: &Mat<T, 3>) -> Mat<T, 3> {
        let mut dP = self.ground().stress_differential(F, dF);
        for family in self.families(F) {
            let w = dF.mul_vec(family.a);
            let along = family.stiffening * dot(family.v, w);
            let change: [T; 3] = vector(|i| family.pull * w[i] + along * family.v[i]);
            dP += Mat::outer(change, family.a);
        }
        dP
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, 3>) -> Tensor4<T, 3> {
        self.add_fibers(self.ground().stress_derivative(F), F)
    }
    /// The fibers are never indefinite, so only the ground substance is projected.
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        F: &Mat<T, 3>,
        projection: HessianProjection,
    ) -> Tensor4<T, 3> {
        self.add_fibers(self.ground().projected_derivative(F, projection), F)
    }
}
