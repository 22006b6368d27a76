//! Lamé's parameters from whatever pair of elastic constants is known.

/// Lamé's parameters of an isotropic material: μ = G (shear modulus) and λ, both in Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    /// Shear modulus μ, Pa.
    pub mu: f64,
    /// First Lamé parameter λ, Pa.
    pub lambda: f64,
}

/// The space that a material lives in.
///
/// A triangle can stand for a truly two-dimensional material, or for a thin slice of a solid
/// that keeps its thickness; these differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// A solid; also its plane-strain slice in 2D. λ = E ν/((1 + ν)(1 − 2ν)), −1 < ν < 1/2.
    Solid,
    /// An intrinsically two-dimensional material (document 002); also the plane-stress slice of
    /// a solid. λ = E ν/((1 + ν)(1 − ν)), −1 < ν < 1.
    Plane,
}

impl Space {
    /// d, as in K = λ + 2μ/d.
    fn dimension(self) -> f64 {
        match self {
            Self::Solid => 3.0,
            Self::Plane => 2.0,
        }
    }
}

/// Constants that no stable material has.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{first_name} = {first} and {second_name} = {second} belong to no stable material: {reason}"
)]
pub struct LameError {
    /// Name of the first constant.
    pub first_name: &'static str,
    /// Its value.
    pub first: f64,
    /// Name of the second constant.
    pub second_name: &'static str,
    /// Its value.
    pub second: f64,
    /// What is wrong.
    pub reason: LameDefect,
}

/// What keeps two elastic constants from belonging to a stable material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LameDefect {
    /// ν is out of range.
    #[error("Poisson's ratio must lie above -1 and below 1/2 (below 1 in the plane)")]
    PoissonOutOfRange,
    /// μ is 0, negative or not finite.
    #[error("the shear modulus must be positive and finite")]
    Shear,
    /// λ is not finite.
    #[error("the material would be incompressible, use a finite bulk modulus")]
    Incompressible,
    /// K is 0, negative or not a number.
    #[error("the bulk modulus must be positive")]
    Bulk,
}

impl Lame {
    /// From μ and λ themselves, checked.
    ///
    /// # Errors
    /// Unless μ > 0 and K = λ + 2μ/d > 0, both finite.
    pub fn new(mu: f64, lambda: f64, space: Space) -> Result<Self, LameError> {
        Self { mu, lambda }.checked(("mu", mu), ("lambda", lambda), space)
    }
    /// From Young's modulus E (Pa) and Poisson's ratio ν.
    ///
    /// # Errors
    /// Unless E > 0 and −1 < ν < 1/2 (in [`Space::Plane`]: < 1).
    pub fn from_young_poisson(E: f64, nu: f64, space: Space) -> Result<Self, LameError> {
        let d = space.dimension();
        let lame = Self {
            mu: E / (2.0 * (1.0 + nu)),
            lambda: E * nu / ((1.0 + nu) * (1.0 - (d - 1.0) * nu)),
        };
        // E and ν both out of range can give a μ and λ in range.
        if !(nu > -1.0 && nu < 1.0 / (d - 1.0)) {
            return Err(LameError {
                first_name: "E",
                first: E,
                second_name: "nu",
                second: nu,
                reason: LameDefect::PoissonOutOfRange,
            });
        }
        lame.checked(("E", E), ("nu", nu), space)
    }
    /// From the bulk modulus K and the shear modulus μ, Pa.
    ///
    /// # Errors
    /// Unless both are positive.
    pub fn from_bulk_shear(K: f64, mu: f64, space: Space) -> Result<Self, LameError> {
        let lambda = K - 2.0 * mu / space.dimension();
        Self { mu, lambda }.checked(("K", K), ("mu", mu), space)
    }
    /// From Young's modulus E and the shear modulus μ, Pa.
    ///
    /// # Errors
    /// Unless both are positive and E < 3μ (in [`Space::Plane`]: < 4μ).
    pub fn from_young_shear(E: f64, mu: f64, space: Space) -> Result<Self, LameError> {
        let d = space.dimension();
        // ν = E/(2μ) − 1 in λ = 2μν/(1 − (d − 1)ν)
        let lambda = mu * (E - 2.0 * mu) / (d * mu - 0.5 * (d - 1.0) * E);
        Self { mu, lambda }.checked(("E", E), ("mu", mu), space)
    }
    /// From λ (Pa) and Poisson's ratio ν.
    ///
    /// # Errors
    /// Unless both have the same sign (not 0) and ν lies in its range.
    pub fn from_lambda_poisson(lambda: f64, nu: f64, space: Space) -> Result<Self, LameError> {
        let d = space.dimension();
        let mu = lambda * (1.0 - (d - 1.0) * nu) / (2.0 * nu);
        Self { mu, lambda }.checked(("lambda", lambda), ("nu", nu), space)
    }
    /// From the bulk modulus K (Pa) and Poisson's ratio ν.
    ///
    /// # Errors
    /// Unless K > 0 and ν lies in its range.
    pub fn from_bulk_poisson(K: f64, nu: f64, space: Space) -> Result<Self, LameError> {
        let d = space.dimension();
        let lambda = d * K * nu / (1.0 + nu);
        let mu = d * K * (1.0 - (d - 1.0) * nu) / (2.0 * (1.0 + nu));
        Self { mu, lambda }.checked(("K", K), ("nu", nu), space)
    }
    /// From Young's modulus E and the bulk modulus K, Pa.
    ///
    /// # Errors
    /// Unless both are positive and E < 9K (in [`Space::Plane`]: < 4K).
    pub fn from_young_bulk(E: f64, K: f64, space: Space) -> Result<Self, LameError> {
        let d = space.dimension();
        let nu = (d * K - E) / (d * (d - 1.0) * K);
        let mu = E / (2.0 * (1.0 + nu));
        Self {
            mu,
            lambda: K - 2.0 * mu / d,
        }
        .checked(("E", E), ("K", K), space)
    }
    /// From the P-wave modulus M = λ + 2μ and the shear modulus μ, Pa.
    ///
    /// # Errors
    /// Unless μ > 0 and M > 4/3 μ (in [`Space::Plane`]: > μ).
    pub fn from_p_wave_shear(M: f64, mu: f64, space: Space) -> Result<Self, LameError> {
        Self {
            mu,
            lambda: M - 2.0 * mu,
        }
        .checked(("M", M), ("mu", mu), space)
    }
    /// From the P-wave modulus M = λ + 2μ (Pa) and Poisson's ratio ν.
    ///
    /// # Errors
    /// Unless M > 0 and ν lies in its range.
    pub fn from_p_wave_poisson(M: f64, nu: f64, space: Space) -> Result<Self, LameError> {
        let d = space.dimension();
        let lambda = M * nu / (1.0 - (d - 2.0) * nu);
        Self {
            mu: 0.5 * (M - lambda),
            lambda,
        }
        .checked(("M", M), ("nu", nu), space)
    }

    /// Young's modulus E, Pa.
    pub fn young(&self, space: Space) -> f64 {
        2.0 * self.mu * (1.0 + self.poisson(space))
    }
    /// Poisson's ratio ν.
    pub fn poisson(&self, space: Space) -> f64 {
        self.lambda / (2.0 * self.mu + (space.dimension() - 1.0) * self.lambda)
    }
    /// Bulk modulus K, Pa.
    pub fn bulk(&self, space: Space) -> f64 {
        self.lambda + 2.0 * self.mu / space.dimension()
    }
    /// P-wave modulus M = λ + 2μ, Pa.
    pub fn p_wave(&self) -> f64 {
        self.lambda + 2.0 * self.mu
    }

    fn checked(
        self,
        (first_name, first): (&'static str, f64),
        (second_name, second): (&'static str, f64),
        space: Space,
    ) -> Result<Self, LameError> {
        let fail = |reason| {
            Err(LameError {
                first_name,
                first,
                second_name,
                second,
                reason,
            })
        };
        if !(self.mu > 0.0 && self.mu.is_finite()) {
            return fail(LameDefect::Shear);
        }
        if !self.lambda.is_finite() {
            return fail(LameDefect::Incompressible);
        }
        if self.bulk(space).is_nan() || self.bulk(space) <= 0.0 {
            return fail(LameDefect::Bulk);
        }
        Ok(self)
    }
}
