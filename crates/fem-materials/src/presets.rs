//! Parameter sets with units and sources.
//!
//! Soft tissue varies by a factor of ten between people, sites and methods of measurement: these
//! are starting points. With A I₁ + B I₂ + K/2 (ln J)² the Lamé parameters at rest are
//! μ = 2(A + B), λ = K − 4/3 (A + B).

use crate::curves::PhysBam;
use crate::fiber::{FiberLaw, Stretch};
use crate::models::Flesh;

/// A named parameter set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Its name in scene files.
    pub name: &'static str,
    /// A, B and K, Pa.
    pub flesh: Flesh,
    /// σ_max of the muscles in it, Pa; 0 for tissue without fibers.
    pub peak_tension: f64,
    /// Optimal stretch λ_ofl.
    pub optimal_stretch: f64,
    /// Where the numbers are from.
    pub source: &'static str,
}

/// The muscle of PhysBAM's quasistatic face.
///
/// Far from incompressible: Poisson's ratio at rest is −0.2. See
/// [`nearly_incompressible`] for a variant that keeps its volume.
pub const MUSCLE: Preset = Preset {
    name: "muscle",
    flesh: Flesh::new(6e4, 2e4, 6e4),
    peak_tension: 3e5,
    optimal_stretch: 1.0,
    source: "PhysBAM Create_Quasistatic_Face (mu_10 = 6e4, mu_01 = 2e4, kappa = 6e4) and FACE_3D.h \
             (fiber_max_stress = 3e5)",
};

/// The same flesh without fibers: what fills a face between its muscles.
pub const PASSIVE_FLESH: Preset = Preset {
    name: "passive_flesh",
    peak_tension: 0.0,
    source: "PhysBAM Create_Quasistatic_Face (mu_10 = 6e4, mu_01 = 2e4, kappa = 6e4)",
    ..MUSCLE
};

/// A softer muscle, half of [`MUSCLE`].
pub const SOFT_MUSCLE: Preset = Preset {
    name: "soft_muscle",
    flesh: Flesh::new(3e4, 1e4, 6e4),
    source: "attributed to Teran et al. 2005 (Robust quasistatic finite elements and flesh \
             simulation); not verified against the paper",
    ..MUSCLE
};

/// Subcutaneous fat: nearly incompressible, Young's modulus about 1 kPa.
pub const FAT: Preset = Preset {
    name: "fat",
    flesh: Flesh::new(130.0, 40.0, 1700.0),
    peak_tension: 0.0,
    optimal_stretch: 1.0,
    source: "order of magnitude of Comley and Fleck 2010 (A micromechanical model for the Young's \
             modulus of adipose tissue); K = 10 (A + B)",
};

/// Skin under small strains: nearly incompressible, Young's modulus about 6 kPa.
pub const SKIN: Preset = Preset {
    name: "skin",
    flesh: Flesh::new(750.0, 250.0, 1e4),
    peak_tension: 0.0,
    optimal_stretch: 1.0,
    source: "order of magnitude of Pailler-Mattei, Bec and Zahouani 2008 (in vivo indentation); \
             K = 10 (A + B)",
};

/// All of them.
pub const PRESETS: [Preset; 5] = [MUSCLE, PASSIVE_FLESH, SOFT_MUSCLE, FAT, SKIN];

/// The same A and B with K = `ratio` (A + B): 5 gives Poisson's ratio 0.32 at rest, 16 gives 0.44.
pub const fn nearly_incompressible(preset: Preset, ratio: f64) -> Preset {
    let deviatoric = preset.flesh.0;
    let (A, B) = (deviatoric.A, deviatoric.B);
    Preset {
        flesh: Flesh::new(A, B, ratio * (A + B)),
        ..preset
    }
}

/// The preset of that name.
pub fn preset(name: &str) -> Option<Preset> {
    PRESETS.into_iter().find(|p| p.name == name)
}

/// The fiber law that all presets are meant for: PhysBAM's curves and plain stretch.
pub fn default_fiber_law() -> FiberLaw<PhysBam> {
    FiberLaw {
        curve: PhysBam::default(),
        stretch: Stretch::Total,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Lame, Space};

    fn at_rest(preset: Preset) -> Lame {
        let (shear, volume) = (preset.flesh.0, preset.flesh.1);
        let sum = shear.A + shear.B;
        Lame {
            mu: 2.0 * sum,
            lambda: volume.K - 4.0 / 3.0 * sum,
        }
    }

    #[test]
    fn poisson_ratios_are_as_documented() {
        let nu = |p| at_rest(p).poisson(Space::Solid);
        assert!((nu(MUSCLE) + 0.206).abs() < 1e-2, "{}", nu(MUSCLE));
        assert!((nu(nearly_incompressible(MUSCLE, 5.0)) - 0.3235).abs() < 1e-3);
        assert!((nu(nearly_incompressible(MUSCLE, 16.0)) - 0.44).abs() < 1e-3);
    }
    #[test]
    fn young_moduli_are_as_documented() {
        assert!((at_rest(FAT).young(Space::Solid) - 970.0).abs() < 30.0);
        assert!((at_rest(SKIN).young(Space::Solid) - 5700.0).abs() < 300.0);
    }
    #[test]
    fn names_are_found() {
        assert_eq!(preset("fat"), Some(FAT));
        assert_eq!(preset("butter"), None);
    }
}
