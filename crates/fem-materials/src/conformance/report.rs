//! What the suite found: the worst error of each property, with the place where it was reached.

use core::fmt;
use fem_kinematics::Mat;

/// One thing that a correct material does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Property {
    /// P = ∂ψ/∂F, the derivative taken with dual numbers.
    StressIsEnergyGradient,
    /// dP = ∂P/∂F : dF, the derivative taken with dual numbers.
    DifferentialIsStressDerivative,
    /// The tensor ∂P/∂F contracted with dF is the differential.
    DerivativeIsDifferential,
    /// ∂P/∂F is symmetric, being a second derivative of ψ.
    DerivativeIsSymmetric,
    /// P against central differences of ψ.
    StressByDifferences,
    /// ∂P/∂F against central differences of P.
    DerivativeByDifferences,
    /// The share of directions that the differences could not judge, because ∂P/∂F bends within
    /// the smallest step. A kink is met rarely; noise is met everywhere.
    DifferencesLeftOut,
    /// `projected_derivative` is what the numeric eigenvalue projection makes of ∂P/∂F; for a material
    /// that projects its terms one by one, see [`Claim::ProjectedByTerms`](super::Claim).
    ProjectionIsNumeric,
    /// `projected_derivative` with clamping or absolute values has no negative eigenvalue, and is
    /// no softer than ∂P/∂F in any direction.
    ProjectedIsDefinite,
    /// ψ(QF) = ψ(F) and P(QF) = Q P(F) for every rotation Q.
    Objectivity,
    /// ψ(QFQᵀ) = ψ(F) and P(QFQᵀ) = Q P(F) Qᵀ for every rotation Q.
    Isotropy,
    /// SIMD lanes give what the scalar gives.
    LanesAgree,
    /// A lane outside of the domain, or NaN, leaves its neighbors alone.
    LanesAreIndependent,
    /// `f32` gives what `f64` gives, to the rounding of `f32`.
    SingleAgrees,
    /// P(I) = 0.
    RestIsStressFree,
    /// ψ = +∞ wherever det F ≤ 0.
    InfiniteOutsideDomain,
    /// ψ is finite or +∞, never NaN or −∞; where it is finite, P is finite.
    NeverNan,
    /// A deformation gradient with a NaN in it has no finite energy.
    NanIsNotHidden,
}

impl Property {
    /// The largest error that passes. Errors are relative to the size of the quantity and to what
    /// one rounding of F changes in it.
    pub fn bound(self) -> f64 {
        match self {
            Self::StressIsEnergyGradient
            | Self::DifferentialIsStressDerivative
            | Self::DerivativeIsDifferential
            | Self::DerivativeIsSymmetric
            | Self::ProjectionIsNumeric
            | Self::ProjectedIsDefinite
            | Self::Objectivity
            | Self::Isotropy => 1e-12,
            // The best step of the ladder leaves about ε^(4/5) = 3e-13 times the condition.
            Self::StressByDifferences | Self::DerivativeByDifferences => 1e-8,
            Self::DifferencesLeftOut => 0.1,
            Self::LanesAgree => 32.0 * f64::EPSILON,
            Self::SingleAgrees => 64.0 * f32::EPSILON as f64,
            Self::RestIsStressFree => 1e-12,
            Self::LanesAreIndependent
            | Self::InfiniteOutsideDomain
            | Self::NeverNan
            | Self::NanIsNotHidden => 0.0,
        }
    }

    /// One or two words, for the head of a column.
    pub fn short(self) -> &'static str {
        match self {
            Self::StressIsEnergyGradient => "P",
            Self::DifferentialIsStressDerivative => "dP",
            Self::DerivativeIsDifferential => "dP/dF",
            Self::DerivativeIsSymmetric => "symmetric",
            Self::StressByDifferences => "P diff",
            Self::DerivativeByDifferences => "dP diff",
            Self::DifferencesLeftOut => "no diff",
            Self::ProjectionIsNumeric => "projection",
            Self::ProjectedIsDefinite => "definite",
            Self::Objectivity => "objective",
            Self::Isotropy => "isotropic",
            Self::LanesAgree => "lanes",
            Self::LanesAreIndependent => "neighbor",
            Self::SingleAgrees => "f32",
            Self::RestIsStressFree => "rest",
            Self::InfiniteOutsideDomain => "domain",
            Self::NeverNan => "no NaN",
            Self::NanIsNotHidden => "NaN seen",
        }
    }

    /// A short description, as it stands in the printed report.
    pub fn label(self) -> &'static str {
        match self {
            Self::StressIsEnergyGradient => "P = dψ/dF (dual numbers)",
            Self::DifferentialIsStressDerivative => "dP = dP/dF : dF (dual numbers)",
            Self::DerivativeIsDifferential => "tensor dP/dF = differential",
            Self::DerivativeIsSymmetric => "dP/dF symmetric",
            Self::StressByDifferences => "P by differences",
            Self::DerivativeByDifferences => "dP/dF by differences",
            Self::DifferencesLeftOut => "share without differences",
            Self::ProjectionIsNumeric => "projection = numeric one",
            Self::ProjectedIsDefinite => "projected dP/dF definite",
            Self::Objectivity => "objectivity",
            Self::Isotropy => "isotropy",
            Self::LanesAgree => "lanes = scalar",
            Self::LanesAreIndependent => "lanes independent",
            Self::SingleAgrees => "f32 = f64 to rounding",
            Self::RestIsStressFree => "rest state stress-free",
            Self::InfiniteOutsideDomain => "+∞ outside the domain",
            Self::NeverNan => "finite or +∞, never NaN",
            Self::NanIsNotHidden => "NaN is not hidden",
        }
    }
}

/// The worst that was seen of one property.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The property.
    pub property: Property,
    /// The largest error; NaN where the material returned NaN.
    pub reached: f64,
    /// The error that is allowed, [`Property::bound`].
    pub bound: f64,
    /// The deformation gradient where it was reached, by rows.
    pub deformation_gradient: Vec<f64>,
}

impl Finding {
    /// Is the error within the bound? A NaN is not.
    pub fn passed(&self) -> bool {
        self.reached <= self.bound
    }
}

/// The findings for one material.
#[derive(Clone, Debug)]
#[must_use = "a report that nobody reads proves nothing: call `assert` or look at `failures`"]
pub struct Report {
    /// Name of the material's type.
    pub material: String,
    /// 2 or 3.
    pub dimension: usize,
    /// The seed that draws the same deformations again.
    pub seed: u64,
    /// One for each property that was tried.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Did every property hold?
    pub fn passed(&self) -> bool {
        self.failures().next().is_none()
    }

    /// The properties that did not hold.
    pub fn failures(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|f| !f.passed())
    }

    /// The finding for a property, where it was tried.
    pub fn finding(&self, property: Property) -> Option<&Finding> {
        self.findings.iter().find(|f| f.property == property)
    }

    /// For use in a test.
    ///
    /// # Panics
    /// With the whole report, when a property did not hold.
    pub fn assert(&self) {
        assert!(self.passed(), "\n{self}");
    }

    pub(crate) fn record<const D: usize>(
        &mut self,
        property: Property,
        reached: f64,
        F: &Mat<f64, D>,
    ) {
        let place = || F.0.iter().flatten().copied().collect();
        match self.findings.iter_mut().find(|f| f.property == property) {
            Some(finding) => {
                let worse = reached.is_nan() || reached > finding.reached;
                if worse && !finding.reached.is_nan() {
                    finding.reached = reached;
                    finding.deformation_gradient = place();
                }
            }
            None => self.findings.push(Finding {
                property,
                reached,
                bound: property.bound(),
                deformation_gradient: place(),
            }),
        }
    }
}

/// The larger error; NaN, once seen, stays.
pub(crate) fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}

/// The error of a property that holds or does not.
pub(crate) fn zero_if(holds: bool) -> f64 {
    if holds { 0.0 } else { f64::INFINITY }
}

impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            out,
            "{} in {}D, seed {:#x}",
            self.material, self.dimension, self.seed
        )?;
        for f in &self.findings {
            let verdict = if f.passed() { "ok" } else { "FAILED" };
            writeln!(
                out,
                "  {:<32} {:>9.1e} of {:>8.1e}  {verdict}",
                f.property.label(),
                f.reached,
                f.bound
            )?;
            if !f.passed() {
                writeln!(out, "    at F = {:?} (by rows)", f.deformation_gradient)?;
            }
        }
        Ok(())
    }
}
