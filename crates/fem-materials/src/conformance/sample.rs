//! The deformation gradients that a material is tried at.

use super::random::Random;
use fem_kinematics::Mat;

/// What is special about a deformation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A rotation times I + small.
    NearRest,
    /// Well separated principal stretches in [0.6, 1.6].
    Moderate,
    /// Well separated principal stretches in [0.25, 4].
    Large,
    /// The first two singular values are equal.
    Repeated,
    /// det F < 0.
    Inverted,
}

/// A deformation gradient, and what is special about it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample<const D: usize> {
    pub(crate) F: Mat<f64, D>,
    pub(crate) kind: Kind,
}

/// `rounds` samples of each kind.
pub(crate) fn samples<const D: usize>(random: &mut Random, rounds: usize) -> Vec<Sample<D>> {
    let mut all = Vec::new();
    for _ in 0..rounds {
        for kind in [
            Kind::NearRest,
            Kind::Moderate,
            Kind::Large,
            Kind::Repeated,
            Kind::Inverted,
        ] {
            all.push(Sample {
                F: draw(random, kind),
                kind,
            });
        }
    }
    all
}

fn draw<const D: usize>(random: &mut Random, kind: Kind) -> Mat<f64, D> {
    let (U, V) = (random.rotation::<D>(), random.rotation::<D>());
    let sigma = match kind {
        Kind::NearRest => {
            let size = 10f64.powf(random.uniform(-4.0, -2.0));
            return U * (Mat::identity() + random.matrix().scale(size));
        }
        Kind::Repeated => {
            let mut sigma = [random.uniform(0.9, 1.4); D];
            if D == 3 {
                sigma[2] = random.uniform(0.6, 0.8);
            }
            sigma
        }
        Kind::Moderate => separated(random, 0.6, 1.6),
        Kind::Large => separated(random, 0.25, 4.0),
        Kind::Inverted => {
            let mut sigma = separated(random, 0.4, 2.0);
            sigma[D - 1] = -sigma[D - 1];
            sigma
        }
    };
    U * Mat::from_diagonal(sigma).mul_tr(&V)
}

/// Descending numbers in [low, high], each at least 8 % above the next: a dual number pushed
/// through a decomposition loses digits like 1/gap, which says nothing about the material.
fn separated<const D: usize>(random: &mut Random, low: f64, high: f64) -> [f64; D] {
    loop {
        let mut s: [f64; D] = core::array::from_fn(|_| random.uniform(low.ln(), high.ln()).exp());
        s.sort_by(|a, b| b.total_cmp(a));
        if s.windows(2).all(|w| w[0] > 1.08 * w[1]) {
            return s;
        }
    }
}
