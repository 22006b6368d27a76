//! Claims of curves.

use bench::{Axis, Claim, Curve, Point};

fn curve(claim: Claim, errors: &[f64]) -> Curve {
    let mut curve = Curve::new("c", Axis::Mesh, claim);
    curve.points.extend(errors.iter().map(|&error| Point {
        error,
        ..Point::default()
    }));
    curve
}

#[test]
fn a_claim_is_broken_by_a_rise_above_the_floor_and_by_nan() {
    let falls = Claim::FallsTo(1e-9);
    assert!(curve(falls, &[1.0, 0.5, 1e-9, 1e-9]).broken().is_none());
    assert!(curve(falls, &[1.0, 0.5, 0.5]).broken().is_some());
    assert!(curve(falls, &[1.0, f64::NAN]).broken().is_some());
    assert!(curve(Claim::AtMost(0.1), &[0.1, 0.0]).broken().is_none());
    assert!(curve(Claim::AtMost(0.1), &[0.0, 0.11]).broken().is_some());
    assert!(curve(Claim::Nothing, &[0.0, f64::NAN]).broken().is_some());
}

#[test]
fn an_error_may_be_a_share_of_its_tolerance_or_rounding() {
    let mut curve = curve(Claim::PerTolerance(2.0, 1e-9), &[0.19, 2e-4, 1e-9]);
    for (point, setting) in curve.points.iter_mut().zip(["1e-1", "1e-4", "1e-12"]) {
        point.setting = setting.to_owned();
    }
    assert!(curve.broken().is_none());
    curve.points[2].error = 2e-9;
    assert!(curve.broken().is_some());
    curve.points[2].error = 0.0;
    // Looser tolerances than those that are claimed are only shown.
    curve.points[0].error = 5.0;
    assert!(curve.broken().is_some());
    curve.claim = Claim::PerToleranceUpTo(2.0, 1e-9, 1e-4);
    assert!(curve.broken().is_none());
    curve.points[1].error = 3e-4;
    assert!(curve.broken().is_some());
    curve.points[1].error = 2e-4;
    curve.points[1].setting = "auto".to_owned();
    assert!(curve.broken().is_some());
}
