//! The anisotropic energy of document 001, section 3, whole and damaged.

use crate::damage::DamageField;
use crate::field::{At, Local1, MaterialField};
use crate::lame::{Lame, LameError, Space};
use crate::material::Material;
use crate::qr::Coefficients;
use crate::registry::{Entry, Parameter, Register, mu_and_lambda_plus_mu};
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Real, Tensor4};

/// ψ = μ/2 (Σ rᵢⱼ² − D) − μ (J − 1) + λ/2 (J − 1)² + k_x/2 (r₁₁ − 1)²
/// + k_y/2 (√(r₁₂² + r₂₂²) − 1)² with F = Q R, the last term in 3D only.
///
/// Fibers along the first two axes of the rest shape that resist both ways. Defined for every F;
/// the stress is bounded but jumps where a fiber has length 0 (F e = 0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QrAnisotropic {
    /// μ, Pa.
    pub mu: f64,
    /// λ, Pa. At rest Lamé's λ is this minus μ.
    // ERRATUM: document 001 reads as if both were Lamé's.
    pub lambda: f64,
    /// Stiffness along the first axis, Pa.
    pub kx: f64,
    /// Stiffness along the second axis, Pa; not used in 2D.
    pub ky: f64,
}

/// [`QrAnisotropic`] with a damage d of each element as its local parameter: ψ = g ψ⁺ + ψ⁻ + ψ_f,
/// g = (1 − r)(1 − d)² + r (document 001, section 3.6).
///
/// The μ terms are always degraded, the λ term where J ≥ 1, the fibers never. ψ and P are
/// continuous at J = 1; dP/dF jumps there by (1 − g) λ cof F ⊗ cof F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DegradableQr {
    /// The undamaged material.
    pub whole: QrAnisotropic,
    /// Residual r of the stiffness at d = 1, 0 to 1.
    pub residual: f64,
}

/// [`DegradableQr`] with one damage d everywhere: 0 whole, 1 broken.
pub type QrDamage = At<DegradableQr, Local1<f64>>;

const PARAMETERS: [Parameter; 6] = [
    Parameter::pascals("mu", "1e4", "μ of the model"),
    Parameter::pascals("lambda", "4e4", "λ of the model: Lamé's plus μ"),
    Parameter::pascals("kx", "5e4", "fiber stiffness along x"),
    Parameter::pascals(
        "ky",
        "2e4",
        "fiber stiffness along y; 3D only, 0 if not given",
    ),
    Parameter::plain("d", "0.4", "damage, 0 to 1"),
    Parameter::plain(
        "r",
        "0.01",
        "residual stiffness of a broken element, 0 to 1",
    ),
];
const WHOLE: &[Parameter] = PARAMETERS.first_chunk::<4>().expect("six are there");

fn whole_from(
    p: &crate::registry::Parameters,
) -> Result<QrAnisotropic, crate::registry::ParameterError> {
    Ok(QrAnisotropic {
        mu: p.non_negative("mu")?,
        lambda: p.number("lambda")?,
        kx: p.non_negative("kx")?,
        ky: p.non_negative_or("ky", 0.0)?,
    })
}

pub(crate) fn register(visitor: &mut impl Register) {
    let whole = Entry {
        name: "qr_aniso",
        aliases: &["qr"],
        elastic: Some(mu_and_lambda_plus_mu),
        about: "cloth and fibrous matter, fibers along the axes of the rest shape (document 001)",
        domain: "all F",
        parameters: WHOLE,
        from_parameters: whole_from,
    };
    visitor.plane(&whole);
    visitor.solid(&whole);
    let damaged = Entry {
        name: "qr_damage",
        aliases: &[],
        elastic: Some(mu_and_lambda_plus_mu),
        about: "cloth and fibrous matter that tears, partly broken (document 001)",
        domain: "all F",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            let unit = |x: f64| (0.0..=1.0).contains(&x);
            let damage = p.number_where("d", "between 0 and 1", unit)?;
            let residual = p.number_where("r", "between 0 and 1", unit)?;
            Ok(whole_from(p)?.degradable(residual).at(Local1(damage)))
        },
    };
    visitor.plane(&damaged);
    visitor.solid(&damaged);
}

impl QrAnisotropic {
    /// From Young's modulus (Pa) and Poisson's ratio of the matrix in 3D (plane strain in 2D) and
    /// the stiffness of the fibers, Pa.
    ///
    /// # Errors
    /// Unless E > 0 and −1 < ν < 1/2.
    pub fn from_young_poisson(
        young: f64,
        poisson: f64,
        kx: f64,
        ky: f64,
    ) -> Result<Self, LameError> {
        let Lame { mu, lambda } = Lame::from_young_poisson(young, poisson, Space::Solid)?;
        let lambda = lambda + mu;
        Ok(Self { mu, lambda, kx, ky })
    }

    /// The same with a damage of each element that leaves the share `residual` (0 to 1) of the
    /// stiffness at d = 1.
    pub const fn degradable(self, residual: f64) -> DegradableQr {
        DegradableQr {
            whole: self,
            residual,
        }
    }

    /// The coefficients in every lane.
    #[inline(always)]
    pub(crate) fn coefficients<T: Real>(&self) -> Coefficients<T> {
        Coefficients {
            mu: T::from_f64(self.mu),
            lambda: T::from_f64(self.lambda),
            kx: T::from_f64(self.kx),
            ky: T::from_f64(self.ky),
        }
    }
}

impl DegradableQr {
    /// With the same damage everywhere.
    pub const fn at(self, damage: Local1<f64>) -> QrDamage {
        At {
            field: self,
            local: damage,
        }
    }

    /// The coefficients at damage d.
    #[inline(always)]
    fn coefficients<T: Real, const D: usize>(
        &self,
        d: &Local1<T>,
        F: &Mat<T, D>,
    ) -> Coefficients<T> {
        let g = degradation(d.0, T::from_f64(self.residual));
        self.whole.coefficients::<T>().degraded(g, F)
    }
}

impl<const D: usize> DamageField<D> for DegradableQr {
    #[inline(always)]
    fn at_damage<T: Real>(d: T) -> Local1<T> {
        Local1(d)
    }
}

/// g(d) = (1 − r)(1 − d)² + r: 1 for a whole element, r for a broken one.
#[inline(always)]
pub fn degradation<T: Real>(damage: T, residual: T) -> T {
    let left = T::one() - damage;
    (T::one() - residual) * left * left + residual
}

impl<const D: usize> Material<D> for QrAnisotropic {
    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        self.coefficients::<T>().energy(F)
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        self.coefficients::<T>().stress(F)
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        self.coefficients::<T>().stress_differential(F, dF)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        self.coefficients::<T>().stress_derivative(F)
    }
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        self.coefficients::<T>().projected_derivative(F, projection)
    }
}

impl<const D: usize> MaterialField<D> for DegradableQr {
    type Local<T: Real> = Local1<T>;

    #[inline(always)]
    fn energy<T: Real>(&self, d: &Local1<T>, F: &Mat<T, D>) -> T {
        self.coefficients(d, F).energy(F)
    }
    #[inline(always)]
    fn stress<T: Real>(&self, d: &Local1<T>, F: &Mat<T, D>) -> Mat<T, D> {
        self.coefficients(d, F).stress(F)
    }
    #[inline(always)]
    fn stress_differential<T: Real>(
        &self,
        d: &Local1<T>,
        F: &Mat<T, D>,
        dF: &Mat<T, D>,
    ) -> Mat<T, D> {
        self.coefficients(d, F).stress_differential(F, dF)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, d: &Local1<T>, F: &Mat<T, D>) -> Tensor4<T, D> {
        self.coefficients(d, F).stress_derivative(F)
    }
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        d: &Local1<T>,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        self.coefficients(d, F).projected_derivative(F, projection)
    }
}
