//! Tension curves: slopes, integrals, smoothness, and a user's table.

use fem_kinematics::{Dual, F64x8, Mat};
use fem_materials::curves::{
    Blemker, BuiltinCurve, CurveError, CurvePoint, Ends, PhysBam, Spline, SplineCurve, Tendon,
    TensionCurve,
};
use fem_materials::{FiberLaw, FiberTerm, Stretch};

fn table() -> SplineCurve {
    SplineCurve {
        active: Spline::new(
            &[0.4, 0.6, 0.85, 1.0, 1.2, 1.45, 1.6],
            &[0.0, 0.3, 0.9, 1.0, 0.85, 0.3, 0.0],
            Ends::Flat,
        )
        .unwrap(),
        passive: Spline::new(&[0.9, 1.1, 1.3, 1.6], &[0.0, 0.0, 0.2, 1.1], Ends::Linear).unwrap(),
    }
}

fn stretches() -> impl Iterator<Item = f64> {
    (0..400).map(|i| 0.003 + 0.005 * f64::from(i))
}

/// Value and slope are the derivatives of integral and value, by dual numbers.
fn consistent(curve: &impl TensionCurve) {
    for l in stretches() {
        let x = Dual::variable(l);
        for point in [curve.active(x), curve.passive(x)] {
            let CurvePoint {
                integral,
                value,
                slope,
            } = point;
            let scale = 1.0 + value.value.abs();
            assert!(
                (integral.derivative - value.value).abs() < 1e-13 * scale,
                "{l}: {point:?}"
            );
            assert!(
                (value.derivative - slope.value).abs() < 1e-12 * scale * 10.0,
                "{l}"
            );
        }
    }
    assert_eq!(curve.active(1.0_f64).integral, 0.0);
    assert_eq!(curve.passive(1.0_f64).integral, 0.0);
}

#[test]
fn slopes_and_integrals_belong_together() {
    consistent(&PhysBam::default());
    consistent(&Blemker::default());
    consistent(&table());
    consistent(&Tendon { toe: 0.05 });
    // the dispatch at run time changes nothing
    consistent(&BuiltinCurve::default());
}

/// The largest jump of the slope between neighbors a hair apart.
fn slope_jump(curve: impl Fn(f64) -> CurvePoint<f64>) -> f64 {
    [0.4, 0.6, 1.0, 1.4, 1.6]
        .map(|l| (curve(l + 1e-12).slope - curve(l - 1e-12).slope).abs())
        .into_iter()
        .fold(0.0, f64::max)
}

#[test]
fn physbam_is_c1_and_blemker_is_not() {
    let (physbam, blemker) = (PhysBam::default(), Blemker::default());
    assert!(slope_jump(|l| physbam.active(l)) < 1e-9);
    assert!(slope_jump(|l| physbam.passive(l)) < 1e-9);
    assert!((slope_jump(|l| blemker.active(l)) - 0.4).abs() < 1e-9);
    assert!((slope_jump(|l| blemker.passive(l)) - 0.33).abs() < 1e-9);
}

/// Slack, a parabola to the toe, a line of slope 1 that meets the axis at half the toe; no activation.
#[test]
fn a_tendon_is_slack_then_bends_then_straight() {
    let tendon = Tendon { toe: 0.04 };
    for (l, value) in [
        (0.7_f64, 0.0_f64),
        (1.0, 0.0),
        (1.02, 0.0004 / 0.08),
        (1.04, 0.02),
        (1.5, 0.48),
    ] {
        assert!((tendon.passive(l).value - value).abs() < 1e-15, "{l}");
        assert_eq!(tendon.active(l), CurvePoint::default());
    }
    assert!(slope_jump(|l| tendon.passive(l)) < 1e-9);
    assert!((tendon.passive(1.5_f64).slope - 1.0).abs() < 1e-15);
    assert!(tendon.passive(f64::NAN).value.is_nan());
}

#[test]
fn a_table_is_hit_and_not_overshot() {
    let curve = table();
    for (l, value) in [
        (0.4_f64, 0.0_f64),
        (0.85, 0.9),
        (1.0, 1.0),
        (1.45, 0.3),
        (1.6, 0.0),
    ] {
        assert!((curve.active(l).value - value).abs() < 1e-15, "{l}");
    }
    for l in stretches() {
        let f = curve.active(l).value;
        assert!((-1e-15..=1.0 + 1e-15).contains(&f), "{l}: {f}");
        assert!(curve.passive(l).slope >= -1e-15);
        if (0.9..1.1).contains(&l) {
            assert_eq!(curve.passive(l).value, 0.0);
        }
    }
    assert_eq!(curve.active(0.1).value, 0.0);
    assert!(curve.passive(2.0).value > 1.1, "goes on straight");
    let lanes = curve.active(F64x8::from_value(1.33));
    assert_eq!(lanes.value.0[3], curve.active(1.33).value);
}

trait FromValue {
    fn from_value(value: f64) -> Self;
}
impl FromValue for F64x8 {
    fn from_value(value: f64) -> Self {
        <Self as fem_kinematics::Real>::from_f64(value)
    }
}

#[test]
fn integrals_keep_their_digits_next_to_1() {
    let p = PhysBam::default();
    let e = 1e-6_f64;
    let exact = p.P1 * p.P2 * p.P2 * e * e * e / 6.0;
    assert!((p.passive(1.0 + e).integral / exact - 1.0).abs() < 1e-5);
    assert!((table().active(1.0_f64 - 1e-9).integral / -1e-9 - 1.0).abs() < 1e-6);
}

#[test]
fn bad_tables_are_refused() {
    let refused = |x: &[f64], y: &[f64]| Spline::new(x, y, Ends::Flat).unwrap_err();
    assert!(matches!(
        refused(&[1.0], &[1.0]),
        CurveError::TooShort { rows: 1 }
    ));
    assert!(matches!(
        refused(&[0.5, 1.5], &[1.0]),
        CurveError::Lengths { .. }
    ));
    let error = refused(&[0.5, 1.0, 1.0], &[0.0; 3]);
    assert!(
        matches!(error, CurveError::NotIncreasing { row: 2, .. }),
        "{error}"
    );
    let error = refused(&[0.5, 1.5], &[0.0, f64::NAN]);
    assert!(
        matches!(error, CurveError::NotFinite { row: 1, .. }),
        "{error}"
    );
    let error = refused(&[1.1, 1.5], &[0.0, 0.0]);
    assert!(error.to_string().contains("must include 1"), "{error}");
}

#[test]
fn not_a_number_stays_one() {
    let (physbam, blemker, table) = (PhysBam::default(), Blemker::default(), table());
    for point in [
        physbam.active(f64::NAN),
        physbam.passive(f64::NAN),
        blemker.active(f64::NAN),
        blemker.passive(f64::NAN),
        table.active(f64::NAN),
        table.passive(f64::NAN),
    ] {
        assert!(point.integral.is_nan() && point.value.is_nan(), "{point:?}");
    }
}

#[test]
fn a_fiber_of_length_0_is_finite() {
    let term = FiberTerm {
        direction: [1.0_f64, 0.0, 0.0],
        max_isometric_stress: 3e5,
        activation: 1.0,
        optimal_stretch: 1.0,
    };
    let law = FiberLaw {
        curve: PhysBam::default(),
        stretch: Stretch::Total,
    };
    for F in [Mat::<f64, 3>::zeros(), Mat::from_diagonal([0.0, 1.0, 1.0])] {
        assert!(term.energy(&law, &F).is_finite());
        assert_eq!(term.stress(&law, &F).norm_squared(), 0.0);
        assert_eq!(
            term.stress_derivative(&law, &F)
                .apply(&Mat::identity())
                .norm_squared(),
            0.0
        );
    }
    let law = FiberLaw {
        curve: table(),
        stretch: Stretch::Total,
    };
    assert!(
        term.stress(&law, &Mat::<f64, 3>::zeros())
            .norm_squared()
            .is_finite()
    );
}

#[test]
fn stress_is_affine_in_the_activation() {
    let F = Mat([[1.15, 0.1, 0.0], [0.0, 0.9, 0.2], [0.1, 0.0, 1.1]]);
    for stretch in [Stretch::Total, Stretch::Isochoric] {
        let law = FiberLaw {
            curve: Blemker::default(),
            stretch,
        };
        let term = |activation| FiberTerm {
            direction: [0.6, 0.0, 0.8],
            max_isometric_stress: 3e5,
            activation,
            optimal_stretch: 1.1,
        };
        let slope = term(0.4).stress_by_activation(&law, &F);
        let difference = term(1.0).stress(&law, &F) - term(0.0).stress(&law, &F);
        assert!((slope - difference).norm_squared() < 1e-20 * slope.norm_squared());
    }
}

#[test]
fn eight_different_muscles_side_by_side() {
    let F = Mat([[1.15, 0.1, 0.0], [0.0, 0.9, 0.2], [0.1, 0.0, 1.1]]);
    let law = FiberLaw {
        curve: PhysBam::default(),
        stretch: Stretch::Isochoric,
    };
    let activation: [f64; 8] = core::array::from_fn(|i| i as f64 / 7.0);
    let splat = <F64x8 as fem_kinematics::Real>::from_f64;
    let pack = FiberTerm {
        direction: [splat(0.6), splat(0.0), splat(0.8)],
        max_isometric_stress: splat(3e5),
        activation: fem_kinematics::Lanes(activation),
        optimal_stretch: splat(1.0),
    };
    let P = pack.stress(&law, &Mat::from_f64(&F));
    for lane in 0..8 {
        let one = FiberTerm {
            direction: [0.6, 0.0, 0.8],
            max_isometric_stress: 3e5,
            activation: activation[lane],
            optimal_stretch: 1.0,
        };
        let exact = one.stress(&law, &F);
        for i in 0..3 {
            for j in 0..3 {
                assert!((P.0[i][j].0[lane] - exact.0[i][j]).abs() < 1e-9);
            }
        }
    }
}

/// Simpson's rule from 1 to l, cut at every kink that a curve here has.
fn integrated(f: impl Fn(f64) -> f64, l: f64) -> f64 {
    let kinks = [0.4, 0.6, 0.85, 0.9, 1.05, 1.1, 1.2, 1.3, 1.4, 1.45, 1.6];
    let (low, high) = (l.min(1.0), l.max(1.0));
    let mut ends = vec![low];
    ends.extend(kinks.iter().copied().filter(|k| low < *k && *k < high));
    ends.push(high);
    let piece = |w: &[f64]| {
        let (n, h) = (400, (w[1] - w[0]) / 400.0);
        let weight = |k: usize| [2.0, 4.0][k % 2] - f64::from(u8::from(k == 0 || k == n));
        // Just inside, where a value jumps.
        let at = |k: usize| (w[0] + h * k as f64).clamp(w[0] + 1e-14, w[1] - 1e-14);
        (0..=n).map(|k| weight(k) * f(at(k))).sum::<f64>() * h / 3.0
    };
    let sum: f64 = ends.windows(2).map(piece).sum();
    if l < 1.0 { -sum } else { sum }
}

/// Stored energies come from integrals: a constant that is wrong on one piece shows in no slope.
#[test]
fn integrals_are_those_from_rest_on_every_piece() {
    fn check(name: &str, curve: &impl TensionCurve) {
        for l in [
            0.2, 0.45, 0.5, 0.65, 0.9, 1.02, 1.2, 1.35, 1.5, 1.55, 1.7, 2.0,
        ] {
            let active = integrated(|l| curve.active(l).value, l);
            let passive = integrated(|l| curve.passive(l).value, l);
            for (found, expected) in [
                (curve.active(l).integral, active),
                (curve.passive(l).integral, passive),
            ] {
                let error = (found - expected).abs();
                assert!(
                    error < 1e-8 * (1.0 + expected.abs()),
                    "{name} at {l}: {found} {expected}"
                );
            }
        }
    }
    check("PhysBAM", &PhysBam::default());
    check("Blemker", &Blemker::default());
    check("tendon", &Tendon { toe: 0.05 });
    check("table", &table());
}

/// Beyond λ* = 1.4 a passive curve is its tangent there: P₁ (exp(P₂ e) − P₂ e − 1) with e = 0.4, or
/// without its linear part.
#[test]
fn passive_curves_are_straight_where_they_should_be() {
    let x: f64 = 6.6 * 0.4;
    let physbam = [0.05 * (x.exp() - x - 1.0), 0.05 * 6.6 * (x.exp() - 1.0)];
    let blemker = [0.05 * (x.exp() - 1.0), 0.05 * 6.6 * x.exp()];
    for l in [1.4, 1.5, 2.5, 4.0] {
        for (point, [value, slope]) in [
            (PhysBam::default().passive(l), physbam),
            (Blemker::default().passive(l), blemker),
        ] {
            assert!(
                (point.value / (value + slope * (l - 1.4)) - 1.0).abs() < 1e-13,
                "{l}"
            );
            assert!((point.slope / slope - 1.0).abs() < 1e-13, "{l}");
        }
    }
}

/// Slopes at the knots by hand: weighted harmonic means of the secants inside (Fritsch and Butland
/// 1984), three-point formulas at the ends, at most three times a secant where the next one turns.
#[test]
fn slopes_of_uneven_tables_are_those_of_the_formulas() {
    let spline = |x: &[f64], y: &[f64]| Spline::new(x, y, Ends::Linear).unwrap();
    let curve = SplineCurve {
        active: spline(&[0.6, 0.8, 1.0, 1.5], &[0.0, 1.0, 1.5, 1.7]),
        passive: spline(&[0.5, 1.0, 1.5], &[0.0, 0.5, -4.5]),
    };
    // Secants 5, 2.5 and 0.4; 1.2/(0.6/5 + 0.6/2.5) and 2.1/(1.2/2.5 + 0.9/0.4).
    for (l, slope) in [
        (0.6, 6.25_f64),
        (0.8, 1.2 / 0.36),
        (1.0, 2.1 / 2.73),
        (1.5, 0.0),
    ] {
        let found = curve.active(l).slope;
        assert!((found - slope).abs() < 1e-12, "{l}: {found} {slope}");
    }
    // Secants 1 and −10: 6.5 is more than three times 1, −15.5 is not more than three times −10.
    for (l, slope) in [(0.5, 3.0_f64), (1.0, 0.0), (1.5, -15.5)] {
        let found = curve.passive(l).slope;
        assert!((found - slope).abs() < 1e-12, "{l}: {found} {slope}");
    }
}

#[test]
fn a_curve_knows_which_of_its_tensions_are_always_zero() {
    let flat = |values: [f64; 3]| Spline::new(&[0.5, 1.0, 1.5], &values, Ends::Linear).unwrap();
    let spline = |active, passive| SplineCurve {
        active: flat(active),
        passive: flat(passive),
    };
    let (zero, some) = ([0.0; 3], [0.0, 0.0, 0.3]);
    /// What the curve says, and whether any stretch has a tension.
    fn seen(curve: &impl TensionCurve) -> [(bool, bool); 2] {
        let any =
            |f: &dyn Fn(f64) -> CurvePoint<f64>| stretches().any(|l| f(l) != CurvePoint::default());
        let active = (curve.has_active(), any(&|l| curve.active(l)));
        [active, (curve.has_passive(), any(&|l| curve.passive(l)))]
    }
    let (yes, no) = ((true, true), (false, false));
    let (physbam, blemker) = (PhysBam::default(), Blemker::default());
    assert_eq!(seen(&physbam), [yes, yes]);
    assert_eq!(seen(&blemker), [yes, yes]);
    assert_eq!(seen(&&PhysBam { P1: 0.0, ..physbam }), [yes, no]);
    let blemker = Blemker { P1: 0.0, ..blemker };
    assert_eq!(seen(&BuiltinCurve::Blemker(blemker)), [yes, no]);
    assert_eq!(seen(&Tendon { toe: 0.05 }), [no, yes]);
    assert_eq!(seen(&spline(some, zero)), [yes, no]);
    assert_eq!(seen(&spline(zero, some)), [no, yes]);
}
