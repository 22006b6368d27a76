//! Materials as a scene describes them.

use serde::{Deserialize, Serialize};

/// Passive flesh, in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PassiveMaterial {
    /// ψ = A I₁ + B I₂ + K/2 (ln J)² (doc 000, 4.2).
    MooneyRivlin {
        /// A, Pa.
        a: f64,
        /// B, Pa.
        b: f64,
        /// K, Pa.
        bulk: f64,
    },
    /// Stable neo-Hookean (Smith et al. 2018) that behaves like linear elasticity with these
    /// constants at small strains; finite for flat and inverted elements too.
    StableNeoHookean {
        /// Young's modulus, Pa.
        young: f64,
        /// Poisson's ratio, under ½.
        poisson: f64,
    },
    /// ψ = μ/2 (tr C − 3) − μ ln J + λ/2 (ln J)² with Lamé's μ and λ.
    NeoHookean {
        /// Young's modulus, Pa.
        young: f64,
        /// Poisson's ratio, under ½.
        poisson: f64,
    },
}

impl PassiveMaterial {
    /// Facial soft tissue as one material: stable neo-Hookean, E = 30 kPa, ν = 0.47, in the range
    /// of measured skin, fat and resting muscle (order 1 to 100 kPa); bears activations of 0.3 on
    /// the head data set.
    pub const SOFT_TISSUE: Self = Self::StableNeoHookean {
        young: 30e3,
        poisson: 0.47,
    };
    /// The same stiffness as a Mooney-Rivlin solid: μ = 2(A + B) = 10.2 kPa with A : B = 3 : 1 as
    /// in PhysBAM's face, K = λ + 2μ/3 = 166.7 kPa.
    pub const SOFT_MOONEY_RIVLIN: Self = Self::MooneyRivlin {
        a: 3.827e3,
        b: 1.275e3,
        bulk: 166.7e3,
    };
    /// The defaults of PhysBAM's face (A = 60 kPa, B = 20 kPa, K = 60 kPa): stiff in shear and soft in
    /// volume, Poisson's ratio −0.21 at rest.
    pub const PHYSBAM_FACE: Self = Self::MooneyRivlin {
        a: 60e3,
        b: 20e3,
        bulk: 60e3,
    };

    /// The names that a scene may use for a preset.
    pub const PRESETS: [(&'static str, Self); 3] = [
        ("soft_tissue", Self::SOFT_TISSUE),
        ("soft_mooney_rivlin", Self::SOFT_MOONEY_RIVLIN),
        ("physbam_face", Self::PHYSBAM_FACE),
    ];

    /// Lamé's constants at rest, (μ, λ) in Pa.
    pub fn lame(&self) -> (f64, f64) {
        match *self {
            Self::MooneyRivlin { a, b, bulk } => (2.0 * (a + b), bulk - 4.0 / 3.0 * (a + b)),
            Self::StableNeoHookean { young, poisson } | Self::NeoHookean { young, poisson } => (
                young / (2.0 * (1.0 + poisson)),
                young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
            ),
        }
    }

    /// What is wrong with the parameters, if anything.
    pub(super) fn defect(&self) -> Option<String> {
        match *self {
            Self::MooneyRivlin { a, b, bulk } => {
                let good = a >= 0.0 && b >= 0.0 && a + b > 0.0 && bulk > 0.0;
                let finite = (a + b + bulk).is_finite();
                (!(good && finite)).then(|| {
                    format!("a = {a}, b = {b}, bulk = {bulk}: moduli are pascals, a and b from 0 and not both 0, bulk above 0")
                })
            }
            Self::StableNeoHookean { young, poisson } | Self::NeoHookean { young, poisson } => {
                let good = young > 0.0 && young.is_finite() && poisson > -1.0 && poisson < 0.5;
                (!good).then(|| {
                    format!("young = {young}, poisson = {poisson}: young is pascals above 0, poisson above -1 and under 0.5")
                })
            }
        }
    }
}

/// A material of a scene file: a preset's name or the model with its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MaterialSpec {
    /// One of [`PassiveMaterial::PRESETS`].
    Preset(String),
    /// ψ = A I₁ + B I₂ + K/2 (ln J)².
    MooneyRivlin {
        /// A, Pa.
        a: f64,
        /// B, Pa.
        b: f64,
        /// K, Pa.
        bulk: f64,
    },
    /// Stable neo-Hookean.
    StableNeoHookean {
        /// Young's modulus, Pa.
        young: f64,
        /// Poisson's ratio.
        poisson: f64,
    },
    /// Neo-Hookean.
    NeoHookean {
        /// Young's modulus, Pa.
        young: f64,
        /// Poisson's ratio.
        poisson: f64,
    },
}

impl MaterialSpec {
    /// The material, or what is wrong with it.
    pub(super) fn resolve(&self) -> Result<PassiveMaterial, String> {
        let material = match *self {
            Self::Preset(ref name) => {
                let presets = PassiveMaterial::PRESETS;
                let found = presets.iter().find(|(n, _)| n == name);
                found.map(|&(_, m)| m).ok_or_else(|| {
                    let names = presets.map(|(n, _)| n).join(", ");
                    format!("there is no preset \"{name}\"; there are {names}")
                })?
            }
            Self::MooneyRivlin { a, b, bulk } => PassiveMaterial::MooneyRivlin { a, b, bulk },
            Self::StableNeoHookean { young, poisson } => {
                PassiveMaterial::StableNeoHookean { young, poisson }
            }
            Self::NeoHookean { young, poisson } => PassiveMaterial::NeoHookean { young, poisson },
        };
        material.defect().map_or(Ok(material), Err)
    }
}

/// A region of the flesh and what it is made of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Region {
    /// Its name.
    pub name: String,
    /// What it is made of.
    pub material: PassiveMaterial,
}

impl Region {
    /// The region of everything that no other region claims.
    pub(super) fn of_all(material: PassiveMaterial) -> Self {
        Self {
            name: "flesh".into(),
            material,
        }
    }
}

/// Tension of a fiber over its normalized stretch l = λ/λ_ofl.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FiberCurve {
    /// PhysBAM's, with a continuous slope.
    Physbam,
    /// Blemker et al. 2005, as published.
    Blemker,
    /// A monotone spline through a table of the user's own.
    Table {
        /// Rows [l, f] of the active tension; l = 1 must lie within.
        active: Vec<[f64; 2]>,
        /// Rows [l, f] of the passive tension; l = 1 must lie within.
        passive: Vec<[f64; 2]>,
    },
}

/// Which stretch a fiber feels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FiberStretch {
    /// λ = |F a₀| (what PhysBAM runs).
    #[serde(alias = "plain")]
    Total,
    /// λ = J^(−1/3) |F a₀| (doc 000, 4.2).
    #[serde(alias = "deviatoric")]
    Isochoric,
}

/// What all muscles share: σ = σ_max (α f_act(λ/λ_ofl) + f_pas(λ/λ_ofl)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Fibers {
    /// Tension curve.
    pub curve: FiberCurve,
    /// Which stretch.
    pub stretch: FiberStretch,
    /// σ_max, Pa.
    pub sigma_max: f64,
    /// λ_ofl, the stretch at which the active tension peaks.
    pub lambda_ofl: f64,
}

impl Default for Fibers {
    /// PhysBAM's curve on the plain stretch, σ_max = 200 kPa (the lower end of measured peak muscle
    /// stress, 0.2 to 0.3 MPa), λ_ofl = 1: strongest at rest.
    fn default() -> Self {
        Self {
            curve: FiberCurve::Physbam,
            stretch: FiberStretch::Total,
            sigma_max: 200e3,
            lambda_ofl: 1.0,
        }
    }
}

impl Fibers {
    pub(super) fn defect(&self) -> Option<String> {
        let positive = |v: f64| v > 0.0 && v.is_finite();
        if !positive(self.sigma_max) {
            return Some(format!(
                "sigma_max = {} must be pascals above 0",
                self.sigma_max
            ));
        }
        if !positive(self.lambda_ofl) {
            return Some(format!("lambda_ofl = {} must be above 0", self.lambda_ofl));
        }
        if let FiberCurve::Table { active, passive } = &self.curve {
            return table_defect("active", active).or_else(|| table_defect("passive", passive));
        }
        None
    }
}

fn table_defect(name: &str, rows: &[[f64; 2]]) -> Option<String> {
    let finite = rows.iter().flatten().all(|v| v.is_finite());
    let ascending = rows.windows(2).all(|w| w[0][0] < w[1][0]);
    let around_one =
        matches!((rows.first(), rows.last()), (Some(a), Some(b)) if a[0] <= 1.0 && 1.0 <= b[0]);
    let good = rows.len() >= 2 && finite && ascending && around_one;
    (!good).then(|| {
        format!("curve.table.{name} needs two or more rows [stretch, tension], stretches ascending and around 1")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_soft_presets_are_equally_stiff() {
        let (mu, lambda) = PassiveMaterial::SOFT_TISSUE.lame();
        let (mu_mr, lambda_mr) = PassiveMaterial::SOFT_MOONEY_RIVLIN.lame();
        assert!((mu_mr / mu - 1.0).abs() < 2e-3);
        assert!((lambda_mr / lambda - 1.0).abs() < 2e-3);
    }

    #[test]
    fn every_preset_and_the_default_fibers_are_sound() {
        for (name, material) in PassiveMaterial::PRESETS {
            assert_eq!(material.defect(), None, "{name}");
            assert_eq!(MaterialSpec::Preset(name.into()).resolve(), Ok(material));
        }
        assert_eq!(Fibers::default().defect(), None);
    }

    #[test]
    fn unsound_parameters_are_refused() {
        let poisson = MaterialSpec::NeoHookean {
            young: 1e4,
            poisson: 0.5,
        };
        assert!(poisson.resolve().is_err_and(|e| e.contains("under 0.5")));
        let nan = MaterialSpec::MooneyRivlin {
            a: f64::NAN,
            b: 1.0,
            bulk: 1.0,
        };
        assert!(nan.resolve().is_err());
        let none = MaterialSpec::Preset("steel".into());
        assert!(none.resolve().is_err_and(|e| e.contains("soft_tissue")));
        let mut fibers = Fibers {
            curve: FiberCurve::Table {
                active: vec![[0.5, 0.0], [0.9, 1.0]],
                passive: vec![],
            },
            ..Fibers::default()
        };
        assert!(
            fibers
                .defect()
                .is_some_and(|e| e.contains("curve.table.active"))
        );
        fibers.sigma_max = -1.0;
        assert!(fibers.defect().is_some_and(|e| e.contains("sigma_max")));
    }
}
