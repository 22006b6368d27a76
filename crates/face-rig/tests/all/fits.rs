//! What bounds and priors of a fit mean, and what it does not depend on.

use super::derivatives::{MUSCLES, rig, rig_of};
use super::promise::Rig;
use face_rig::anatomy::JawHinge;
use face_rig::fit::{
    CraniumModel, FitError, FitParams, FitReport, Fitter, JawModel, Parametrization,
};
use face_rig::rig::{AllNodes, Parameters, RigParams};

fn fitted(
    rig: &mut Rig,
    target: &[[f64; 3]],
    map: &Parametrization,
    params: &FitParams,
) -> FitReport {
    let fitter = Fitter {
        observation: &AllNodes {
            nodes: target.len(),
        },
        target: target.as_flattened(),
        weights: &[],
        parametrization: map,
        params,
    };
    rig.solve(&Parameters::rest(MUSCLES)).unwrap();
    rig.fit(&fitter, &map.rest(), &mut |_| {}).unwrap()
}

/// The bound belongs to the jaw's angle, wherever that stands among the numbers.
#[test]
fn a_hinge_stops_at_its_bound_however_the_head_moves() {
    let hinge = JawModel::Hinge(JawHinge::sideways([0.02, 0.0, 0.05]));
    let exact = FitParams {
        activation_weight: 0.0,
        rms_tolerance: 1e-12,
        rms_change: 0.0,
        step_tolerance: 1e-10,
        ..FitParams::default()
    };
    for cranium in [CraniumModel::Fixed, CraniumModel::Rigid] {
        let map = Parametrization::of_all(MUSCLES, cranium, hinge);
        let mut rig = rig();
        let mut truth = map.rest();
        let jaw = map.jaw_start();
        truth[0] = 0.5;
        // A turn of the head beyond what the jaw may open by: only the jaw's own number is bounded.
        if map.cranium_numbers() > 0 {
            truth[MUSCLES..jaw].copy_from_slice(&[-0.4, 0.3, 0.2, 0.01, -0.02, 0.03]);
        }
        truth[jaw] = 0.2;
        let target = rig
            .solve(&map.parameters(&truth).unwrap())
            .unwrap()
            .positions();
        let free = FitParams {
            jaw_angle_bounds: Some([-0.1, 0.7]),
            ..exact.clone()
        };
        let found = fitted(&mut rig, &target, &map, &free).q;
        for (found, truth) in found.iter().zip(&truth) {
            assert!(
                (found - truth).abs() < 1e-6,
                "{cranium:?}: {found} for {truth}"
            );
        }
        let held = FitParams {
            jaw_angle_bounds: Some([-0.1, 0.12]),
            ..exact.clone()
        };
        let report = fitted(&mut rig, &target, &map, &held);
        assert_eq!(report.q[jaw], 0.12, "{cranium:?}");
    }
}

/// Σ |x − target|²/2 of a pose.
fn misfit(rig: &mut Rig, map: &Parametrization, q: &[f64], target: &[[f64; 3]]) -> f64 {
    let x = rig.solve(&map.parameters(q).unwrap()).unwrap().positions();
    let pairs = x.as_flattened().iter().zip(target.as_flattened());
    0.5 * pairs.map(|(x, t)| (x - t).powi(2)).sum::<f64>()
}

/// A pose that cannot be reached exactly: what is left is decided by the prior.
fn beside(rig: &mut Rig, map: &Parametrization) -> Vec<[f64; 3]> {
    let pose = map.parameters(&[0.6, 0.2, 0.3]).unwrap();
    let mut target = rig.solve(&pose).unwrap().positions();
    for (k, x) in target.iter_mut().enumerate() {
        x[k % 3] += 1e-4 * f64::from(k as u32 % 7);
    }
    target
}

/// Where a fit ends the slope of the misfit is that of −½ w |α|², by differences of whole poses.
#[test]
fn the_weight_of_activations_is_that_of_half_their_squares() {
    let map = Parametrization::of_all(MUSCLES, CraniumModel::Fixed, JawModel::Fixed);
    let mut rig = rig();
    let target = beside(&mut rig, &map);
    let mut free = Vec::new();
    for weight in [0.0, 1e-6, 1e-5] {
        let params = FitParams {
            activation_weight: weight,
            rms_change: 0.0,
            step_tolerance: 1e-10,
            ..FitParams::default()
        };
        let q = fitted(&mut rig, &target, &map, &params).q;
        assert!(q.iter().all(|a| *a > 0.01 && *a < 0.99), "{q:?}");
        for k in 0..MUSCLES {
            let mut at = |step: f64| {
                let mut q = q.clone();
                q[k] += step;
                misfit(&mut rig, &map, &q, &target)
            };
            let slope = (at(1e-4) - at(-1e-4)) / 2e-4;
            let pull = weight * q[k];
            assert!(
                (slope + pull).abs() < 1e-9,
                "{weight:e}: {slope:e} {pull:e}"
            );
        }
        if weight == 0.0 {
            free = q;
        } else {
            let sum = |q: &[f64]| q.iter().map(|a| a * a).sum::<f64>();
            assert!(sum(&q) < sum(&free), "{weight:e}");
        }
    }
}

/// Flesh and muscles stiffer by a common factor take the same shapes.
#[test]
fn a_common_factor_of_stiffness_and_strength_changes_no_fit() {
    let map = Parametrization::of_all(MUSCLES, CraniumModel::Fixed, JawModel::Fixed);
    let mut target = Vec::new();
    let mut expected = Vec::new();
    for factor in [1.0, 1e-6, 1e3, 1e6] {
        let mut rig = rig_of(RigParams::default(), 1.0, factor);
        if target.is_empty() {
            target = beside(&mut rig, &map);
        }
        let q = fitted(&mut rig, &target, &map, &FitParams::default()).q;
        if expected.is_empty() {
            expected.clone_from(&q);
        }
        let apart = q.iter().zip(&expected).map(|(a, b)| (a - b).abs());
        let apart = apart.fold(0.0, f64::max);
        assert!(apart < 1e-5, "{factor:e}: {q:?} for {expected:?}");
    }
    assert!(expected.iter().any(|a| *a > 0.1), "{expected:?}");
}

/// The jaw of the target has gone through the cranium: no step leads there, and a trial that is turned down
/// is one equilibrium, not the parts of a walk.
#[test]
fn a_trial_that_flesh_cannot_come_to_is_not_walked_to() {
    let mut through = Parameters::rest(MUSCLES);
    through.jaw.translation[2] = -0.12;
    let mut allowed = rig_of(RigParams::default(), 1.0, 1.0);
    let target = allowed.solve(&through).unwrap().positions();
    let refusing = RigParams {
        refuses_inverted: true,
        ..RigParams::default()
    };
    let mut rig = rig_of(refusing, 1.0, 1.0);
    let jaw = JawModel::Rigid { point: [0.0; 3] };
    let map = Parametrization::of_all(MUSCLES, CraniumModel::Fixed, jaw);
    let params = FitParams {
        max_iterations: 3,
        ..FitParams::default()
    };
    let fitter = Fitter {
        observation: &AllNodes {
            nodes: target.len(),
        },
        target: target.as_flattened(),
        weights: &[],
        parametrization: &map,
        params: &params,
    };
    rig.solve(&Parameters::rest(MUSCLES)).unwrap();
    let mut accepted = Vec::new();
    let end = rig.lent(|rig| {
        let end = fitter.fit(rig, &map.rest(), &mut |i| accepted.push(i.rms_mm));
        Ok::<_, ()>(end.err())
    });
    assert!(matches!(end, Ok(Some(FitError::NotConverged { .. }))));
    // Three steps after the start, and ten trials that were turned down; walked in parts they were 97.
    assert_eq!(accepted.len(), 4);
    let equilibria = rig.work().equilibria;
    assert!((5..30).contains(&equilibria), "{equilibria}");
}
