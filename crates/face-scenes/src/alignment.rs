//! Lays targets of other places, units and axes over the face at rest.

use super::defect::TargetDefect;
use face_rig::fit::Similarity;

/// A target's landmarks and the same ones of the face at rest.
#[derive(Clone, Debug, Default)]
pub(super) struct Pairs {
    pub target: Vec<[f64; 3]>,
    pub rest: Vec<[f64; 3]>,
}

impl Pairs {
    /// What is left of a distance counts as none from this share of the spread on down.
    const CLOSE: f64 = 0.1;

    /// Root-mean-square distance of the face's landmarks from their middle, meters.
    pub fn spread(&self) -> f64 {
        let count = self.rest.len() as f64;
        let mean = |i: usize| self.rest.iter().map(|p| p[i]).sum::<f64>() / count;
        let mean: [f64; 3] = std::array::from_fn(mean);
        let square = |p: &[f64; 3]| (0..3).map(|i| (p[i] - mean[i]).powi(2)).sum::<f64>();
        (self.rest.iter().map(square).sum::<f64>() / count).sqrt()
    }

    /// What lays the target over the face.
    ///
    /// # Errors
    /// For landmarks that determine no motion, and for a mirrored face.
    pub fn alignment(&self, target: &str) -> Result<Similarity, TargetDefect> {
        let target = || target.to_owned();
        let found = Similarity::robustly_between(&self.target, &self.rest);
        let found = found.ok_or_else(|| TargetDefect::NotAlignable {
            target: target(),
            landmarks: self.target.len(),
        })?;
        match self.is_mirrored(&found) {
            true => Err(TargetDefect::Mirrored { target: target() }),
            false => Ok(found),
        }
    }

    /// Does a mirror image fit far better?
    fn is_mirrored(&self, found: &Similarity) -> bool {
        let left = found.rms(&self.target, &self.rest);
        let mirror = |p: &[f64; 3]| [-p[0], p[1], p[2]];
        let mirrored: Vec<[f64; 3]> = self.target.iter().map(mirror).collect();
        let other = Similarity::robustly_between(&mirrored, &self.rest);
        let other = other.map_or(f64::INFINITY, |other| other.rms(&mirrored, &self.rest));
        left > Self::CLOSE * self.spread() && other < 0.5 * left
    }
}

/// Why a fit that ends far from its target may have been given the wrong one.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Suspicion {
    /// A motion with scale lays the target near the face.
    Unaligned {
        /// Which.
        alignment: Similarity,
        /// The root-mean-square distance that it leaves, meters.
        leaves: f64,
    },
    /// The target is a mirror image.
    Mirrored,
    /// Neither: another person, or landmarks in another order.
    Foreign,
}

impl std::fmt::Display for Suspicion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unaligned { alignment, leaves } => write!(
                f,
                "turned by {:.1} degrees, scaled by {:.4} and shifted it would lie {:.1} mm off: \
                 --align does that",
                alignment.angle().to_degrees(),
                alignment.scale,
                1e3 * leaves
            ),
            Self::Mirrored => f.write_str("it is a mirror image: negate one axis of its positions"),
            Self::Foreign => f.write_str(
                "another person, or landmarks in another order, and no motion of the whole mends that",
            ),
        }
    }
}

/// A fit that ends this far off, as a share of the landmarks' spread, was given a target that this
/// face cannot have meant: 7 mm on a head, twice what its hardest expression leaves.
pub(super) const FAR: f64 = 0.1;

impl Suspicion {
    /// Of a target that a fit has missed by `rms`, meters.
    pub(super) fn of(pairs: &Pairs, rms: f64) -> Self {
        match pairs.alignment("") {
            Err(TargetDefect::Mirrored { .. }) => Self::Mirrored,
            Ok(alignment) => {
                let leaves = alignment.rms(&pairs.target, &pairs.rest);
                match leaves < 0.7 * rms {
                    true => Self::Unaligned { alignment, leaves },
                    false => Self::Foreign,
                }
            }
            Err(_) => Self::Foreign,
        }
    }
}
