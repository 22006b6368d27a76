//! The suite itself: it passes what is right and names what is wrong.

use super::*;
use crate::NeoHookean;
use fem_kinematics::{Mat, Real, Tensor4};

const MATERIAL: NeoHookean = NeoHookean {
    mu: 1.0,
    lambda: 1.5,
};
const CLAIMS: &[Claim] = &[
    Claim::Objective,
    Claim::StressFreeRest,
    Claim::PositiveDeterminant,
];

/// Neo-Hookean with one mistake.
#[derive(Clone, Copy)]
enum Planted {
    /// The sign of the volumetric part of dP: still symmetric.
    Differential,
    /// A stress that is not the gradient of the energy.
    Stress,
    /// A tensor that disagrees with the differential.
    Tensor,
    /// An energy that sees the world's axes.
    Frame,
    /// A finite energy for inverted elements.
    Domain,
    /// A ∂P/∂F that jitters by 10⁻⁶ from one F to the next: its second differences are a kink's.
    Noise,
    /// dP is NaN in the first of the directions that are tried.
    FirstEntry,
}

/// A number in [0, 1] that has nothing in common with that of a neighbor: a tent folded 30 times.
fn jitter<T: Real, const D: usize>(F: &Mat<T, D>) -> T {
    let x = F.dot(&Mat::from_fn(|i, j| T::from_f64((2 + 3 * i + j) as f64)));
    let fold = |x: T| T::one() - (T::one() - x - x).abs();
    (0..30).fold(x.abs() * T::from_f64(0.001), |x, _| fold(x))
}

impl<const D: usize> Material<D> for Planted {
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        let psi = MATERIAL.energy(F);
        match self {
            Self::Frame => psi + T::from_f64(0.01) * F[(0, 0)] * F[(0, 0)],
            Self::Domain => T::select(psi.lt(T::from_f64(1e300)), psi, T::zero()),
            _ => psi,
        }
    }
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        let mut P = MATERIAL.stress(F);
        match self {
            Self::Stress => P = P.scale(T::from_f64(1.0 + 1e-9)),
            Self::Frame => P[(0, 0)] += T::from_f64(0.02) * F[(0, 0)],
            _ => {}
        }
        P
    }
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let mut dP = MATERIAL.stress_differential(F, dF);
        match self {
            Self::Differential => {
                let h = F.cofactor().scale(F.determinant().recip());
                dP -= h.scale(T::from_f64(2.0 * MATERIAL.lambda) * h.dot(dF));
            }
            Self::Stress => dP = dP.scale(T::from_f64(1.0 + 1e-9)),
            Self::Frame => dP[(0, 0)] += T::from_f64(0.02) * dF[(0, 0)],
            Self::Noise => dP += dP.scale(T::from_f64(1e-6) * jitter(F)),
            Self::FirstEntry => {
                let first = T::one().le(dF[(0, 0)]);
                dP[(0, 0)] += T::select(first, T::from_f64(f64::NAN), T::zero());
            }
            _ => {}
        }
        dP
    }
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        let mut tensor = Tensor4::from_linear_map(|dF| self.stress_differential(F, dF));
        if matches!(self, Self::Tensor) {
            *tensor.entry_mut(0, 1, 1, 0) += T::from_f64(1e-9);
        }
        tensor
    }
}

fn failed(mistake: Planted) -> Vec<Property> {
    let suite = Suite {
        claims: CLAIMS,
        rounds: 4,
        ..Suite::default()
    };
    let mut failed: Vec<_> = suite
        .check::<3, _>(&mistake)
        .failures()
        .map(|f| f.property)
        .collect();
    failed.sort();
    failed
}

#[test]
fn a_right_material_passes_in_both_dimensions() {
    let suite = Suite {
        claims: CLAIMS,
        ..Suite::default()
    };
    let report = suite.check::<3, _>(&MATERIAL);
    println!("{report}");
    report.assert();
    suite.check::<2, _>(&MATERIAL).assert();
    assert_eq!(report.material, "NeoHookean");
}

#[test]
fn each_planted_mistake_is_named() {
    use Property::*;
    assert_eq!(
        failed(Planted::Differential),
        [DifferentialIsStressDerivative, DerivativeByDifferences]
    );
    assert_eq!(failed(Planted::Stress), [StressIsEnergyGradient]);
    let tensor = failed(Planted::Tensor);
    assert!(tensor.contains(&DerivativeIsDifferential) && tensor.contains(&DerivativeIsSymmetric));
    let frame = failed(Planted::Frame);
    assert!(frame.contains(&Objectivity) && frame.contains(&RestIsStressFree));
    assert!(!frame.contains(&StressIsEnergyGradient));
    assert!(failed(Planted::Domain).contains(&InfiniteOutsideDomain));
    assert!(failed(Planted::FirstEntry).contains(&DifferentialIsStressDerivative));
}

#[test]
fn noise_cannot_pass_for_a_kink() {
    let report = check::<3, _>(&Planted::Noise);
    let left_out = report.finding(Property::DifferencesLeftOut);
    assert!(
        left_out.is_some_and(|f| f.reached > 0.5 && !f.passed()),
        "{report}"
    );
}

#[test]
fn the_worst_of_many_errors_is_nan_wherever_it_stands() {
    for errors in [
        [f64::NAN, 0.0, 1.0],
        [0.0, f64::NAN, 1.0],
        [0.0, 1.0, f64::NAN],
    ] {
        assert!(errors.into_iter().fold(0.0, report::worse).is_nan());
    }
    assert_eq!([1.0, 3.0, 2.0].into_iter().fold(0.0, report::worse), 3.0);
}

#[test]
fn the_same_seed_gives_the_same_report() {
    let suite = Suite {
        seed: 11,
        rounds: 2,
        claims: CLAIMS,
    };
    let (a, b) = (
        suite.check::<3, _>(&MATERIAL),
        suite.check::<3, _>(&MATERIAL),
    );
    assert_eq!(a.to_string(), b.to_string());
}

#[test]
#[should_panic(expected = "FAILED")]
fn assert_panics_with_the_report() {
    check::<3, _>(&Planted::Stress).assert();
}

/// An exponential of a large stretch overflows `f32` alone; where it does not, `f32` must agree.
#[test]
fn what_no_f32_can_hold_is_not_asked_of_it() {
    let artery = crate::HolzapfelGasserOgden {
        c: 3.0e3,
        K: 1.0e5,
        k1: 2.4e3,
        k2: 8.4,
        fibers: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    };
    let findings = |stretch: f64| {
        let mut report = Report {
            material: String::new(),
            dimension: 3,
            seed: 0,
            findings: Vec::new(),
        };
        let sample = sample::Sample {
            F: Mat::from_diagonal([stretch, 1.1, 0.9]),
            kind: sample::Kind::Large,
        };
        packs::single(&artery, &sample, &mut report);
        report.findings
    };
    assert!(findings(3.0).is_empty());
    let moderate = findings(1.2);
    assert!(!moderate.is_empty() && moderate.iter().all(Finding::passed));
}
