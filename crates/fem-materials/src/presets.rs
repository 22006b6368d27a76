//! Materials with numbers, units and sources: a model's name and its parameters.
//!
//! Soft tissue varies by a factor of ten between people, sites and methods of measurement: these
//! are starting points. With A I₁ + B I₂ + K/2 (ln J)² the Lamé parameters at rest are
//! μ = 2(A + B), λ = K − 4/3 (A + B); K = 5 (A + B) gives Poisson's ratio 0.32 at rest, 16 (A + B)
//! gives 0.44.

use crate::registry::{ModelError, Parameters, UseSolid, with_solid};

/// A model of the registry with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Its name in scene files.
    pub name: &'static str,
    /// The model's name in the registry.
    pub model: &'static str,
    /// Its parameters, SI units.
    pub parameters: &'static [(&'static str, &'static str)],
    /// Where the numbers are from.
    pub source: &'static str,
}

/// Facial soft tissue as one material.
pub const SOFT_TISSUE: Preset = Preset {
    name: "soft_tissue",
    model: "stable_neo_hookean",
    parameters: &[("young", "30000"), ("poisson", "0.47")],
    source: "in the range of measured skin, fat and resting muscle (order 1 to 100 kPa); bears \
             activations of 0.3 on the head data set",
};

/// [`SOFT_TISSUE`] as a Mooney-Rivlin solid.
pub const SOFT_MOONEY_RIVLIN: Preset = Preset {
    name: "soft_mooney_rivlin",
    model: "mooney_rivlin",
    parameters: &[("A", "3827"), ("B", "1275"), ("K", "166700")],
    source: "as stiff as soft_tissue: μ = 2(A + B) = 10.2 kPa with A : B = 3 : 1 as in PhysBAM's \
             face, K = λ + 2μ/3 = 166.7 kPa",
};

/// The flesh of PhysBAM's quasistatic face: stiff in shear and soft in volume, Poisson's ratio
/// −0.21 at rest. Its muscles have σ_max = 3e5 Pa.
pub const PHYSBAM_FACE: Preset = Preset {
    name: "physbam_face",
    model: "mooney_rivlin",
    parameters: &[("A", "60000"), ("B", "20000"), ("K", "60000")],
    source: "PhysBAM Create_Quasistatic_Face (mu_10 = 6e4, mu_01 = 2e4, kappa = 6e4)",
};

/// Softer flesh, half of [`PHYSBAM_FACE`] in shear.
pub const SOFT_MUSCLE: Preset = Preset {
    name: "soft_muscle",
    model: "mooney_rivlin",
    parameters: &[("A", "30000"), ("B", "10000"), ("K", "60000")],
    source: "attributed to Teran et al. 2005 (Robust quasistatic finite elements and flesh \
             simulation); not verified against the paper",
};

/// Subcutaneous fat: nearly incompressible, Young's modulus about 1 kPa.
pub const FAT: Preset = Preset {
    name: "fat",
    model: "mooney_rivlin",
    parameters: &[("A", "130"), ("B", "40"), ("K", "1700")],
    source: "order of magnitude of Comley and Fleck 2010 (A micromechanical model for the Young's \
             modulus of adipose tissue); K = 10 (A + B)",
};

/// Skin under small strains: nearly incompressible, Young's modulus about 6 kPa.
pub const SKIN: Preset = Preset {
    name: "skin",
    model: "mooney_rivlin",
    parameters: &[("A", "750"), ("B", "250"), ("K", "10000")],
    source: "order of magnitude of Pailler-Mattei, Bec and Zahouani 2008 (in vivo indentation); \
             K = 10 (A + B)",
};

/// All of them.
pub const PRESETS: [Preset; 6] = [
    SOFT_TISSUE,
    SOFT_MOONEY_RIVLIN,
    PHYSBAM_FACE,
    SOFT_MUSCLE,
    FAT,
    SKIN,
];

impl Preset {
    /// The parameters for the registry.
    pub fn parameters(&self) -> Parameters {
        self.parameters.iter().copied().collect()
    }
    /// Builds the model and hands it to `user`.
    ///
    /// # Errors
    /// None for the presets of this crate.
    pub fn with<U: UseSolid>(&self, user: U) -> Result<U::Output, ModelError> {
        with_solid(self.model, &self.parameters(), user)
    }
}

/// The preset of that name.
pub fn preset(name: &str) -> Option<Preset> {
    PRESETS.into_iter().find(|p| p.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::at_rest;
    use crate::{Lame, Material, Space};

    struct AtRest;
    impl UseSolid for AtRest {
        type Output = Lame;
        fn call<M: Material<3> + 'static>(self, model: M) -> Lame {
            at_rest(&model)
        }
    }
    fn rest(preset: Preset) -> Lame {
        preset.with(AtRest).expect("a model with these parameters")
    }

    #[test]
    fn every_preset_is_a_stable_solid() {
        for preset in PRESETS {
            let Lame { mu, lambda } = rest(preset);
            assert!(Lame::new(mu, lambda, Space::Solid).is_ok(), "{preset:?}");
            assert!(!preset.source.is_empty());
        }
    }
    #[test]
    fn elastic_constants_are_as_documented() {
        let poisson = |p| rest(p).poisson(Space::Solid);
        assert!((poisson(PHYSBAM_FACE) + 0.206).abs() < 1e-2);
        assert!((poisson(SOFT_TISSUE) - 0.47).abs() < 1e-12);
        assert!((rest(FAT).young(Space::Solid) - 970.0).abs() < 30.0);
        assert!((rest(SKIN).young(Space::Solid) - 5700.0).abs() < 300.0);
    }
    #[test]
    fn the_two_soft_presets_are_equally_stiff() {
        let (one, other) = (rest(SOFT_TISSUE), rest(SOFT_MOONEY_RIVLIN));
        assert!((other.mu / one.mu - 1.0).abs() < 2e-3);
        assert!((other.lambda / one.lambda - 1.0).abs() < 2e-3);
    }
    #[test]
    fn names_are_found() {
        assert_eq!(preset("fat"), Some(FAT));
        assert_eq!(preset("butter"), None);
    }
}
