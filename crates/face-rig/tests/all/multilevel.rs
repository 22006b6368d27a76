//! dx/dθ by conjugate gradients on a multigrid hierarchy, against a factor and against re-solves.

use super::derivatives::{MUSCLES, largest, pose, rig_with};
use super::promise::Rig;
use face_rig::anatomy::EmbeddedPoint;
use face_rig::fit::{CraniumModel, FitParams, Fitter, JawModel, Parametrization};
use face_rig::rig::{
    AllNodes, Direction, EmbeddedPoints, JacobianRoute, MultigridUse, Observation, RigError,
    RigParams,
};
use fem_solvers::PcgError;

fn rig(multigrid: MultigridUse, derivative_tolerance: f64) -> Rig {
    let mut params = RigParams {
        multigrid,
        derivative_tolerance,
        ..RigParams::default()
    };
    params.newton.gradient_tolerance = 1e-13;
    params.newton.relative_gradient_tolerance = 0.0;
    rig_with(params)
}

fn solved(multigrid: MultigridUse, derivative_tolerance: f64) -> Rig {
    let mut rig = rig(multigrid, derivative_tolerance);
    rig.solve(&pose()).unwrap();
    rig
}

/// The largest difference over the largest number.
fn off(found: &[f64], exact: &[f64]) -> f64 {
    let pairs = found.iter().zip(exact);
    largest(pairs.map(|(a, b)| a - b)) / largest(exact.iter().copied())
}

/// Columns, one after the other.
fn columns(rig: &mut Rig) -> Vec<f64> {
    let columns = rig.sensitivity().unwrap();
    let columns = columns.columns(&Direction::all(MUSCLES)).unwrap();
    columns.iter().flatten().flatten().copied().collect()
}

#[test]
fn columns_adjoints_and_gradients_are_those_of_a_factor() {
    let tolerance = RigParams::default().derivative_tolerance;
    let mut factored = solved(MultigridUse::Never, tolerance);
    let mut iterated = solved(MultigridUse::Always, tolerance);
    // The same pose to the last bit: what differs is the derivative's alone.
    let at = factored.equilibrium().clone();
    iterated.start_from(at).unwrap();
    let before = (factored.work(), iterated.work());
    assert!(off(&columns(&mut iterated), &columns(&mut factored)) < 1e-8);
    let directions = Direction::all(MUSCLES);
    let points = EmbeddedPoints(vec![EmbeddedPoint::node(20), EmbeddedPoint::node(24)]);
    let wanted = AllNodes { nodes: 45 };
    let all = |rig: &mut Rig| {
        let derivative = rig.sensitivity().unwrap();
        let seen = JacobianRoute::Adjoint;
        let seen = derivative.jacobian(&points, &directions, seen).unwrap();
        let shape = derivative.positions();
        let mut loss = vec![[0.0; 3]; shape.len()];
        wanted.add_row(shape, 31, &mut loss);
        (seen, derivative.gradient(&loss, &directions).unwrap())
    };
    let (exact, found) = (all(&mut factored), all(&mut iterated));
    assert!(off(&found.0, &exact.0) < 1e-8 && off(&found.1, &exact.1) < 1e-8);
    let (exact, found) = (factored.work() - before.0, iterated.work() - before.1);
    assert_eq!((exact.factorizations, exact.linear_iterations), (1, 0));
    assert_eq!(found.factorizations, 0);
    // 15 columns, 6 adjoints and a gradient.
    assert_eq!((exact.right_hand_sides, found.right_hand_sides), (22, 22));
    assert!((5 * 22..40 * 22).contains(&found.linear_iterations));
}

#[test]
fn the_tolerance_governs_the_error() {
    let mut factored = solved(MultigridUse::Never, 0.0);
    let exact = columns(&mut factored);
    let mut before = (f64::INFINITY, 0);
    for tolerance in [1e-2, 1e-5, 1e-8, 1e-11] {
        let mut rig = rig(MultigridUse::Always, tolerance);
        rig.start_from(factored.equilibrium().clone()).unwrap();
        let error = off(&columns(&mut rig), &exact);
        let iterations = rig.work().linear_iterations;
        assert!(
            error < 3.0 * tolerance && error > 1e-4 * tolerance,
            "{error:e} of {tolerance:e}"
        );
        assert!(error < before.0 && iterations > before.1);
        before = (error, iterations);
    }
}

#[test]
fn columns_are_what_solves_beside_the_pose_find() {
    let mut rig = solved(MultigridUse::Always, 1e-10);
    let columns = columns(&mut rig);
    let n = columns.len() / Direction::all(MUSCLES).len();
    for (muscle, column) in columns.chunks(n).take(MUSCLES).enumerate() {
        let h = 1e-4;
        let mut at = |step: f64| {
            let mut beside = pose();
            beside.activations[muscle] += step;
            let solved = rig.solve(&beside).unwrap();
            solved.positions().concat()
        };
        let (high, low) = (at(h), at(-h));
        let difference: Vec<f64> = high
            .iter()
            .zip(low)
            .map(|(a, b)| (a - b) / (2.0 * h))
            .collect();
        assert!(
            off(column, &difference) < 1e-6,
            "{muscle}: {:e}",
            off(column, &difference)
        );
    }
}

#[test]
fn a_derivative_that_does_not_converge_is_an_error() {
    for tolerance in [1e-17, f64::NAN, -1.0] {
        let mut rig = solved(MultigridUse::Always, tolerance);
        let derivative = rig.sensitivity().unwrap();
        let directions = Direction::all(MUSCLES);
        let error = derivative.columns(&directions).unwrap_err();
        let expected = match tolerance {
            1e-17 => matches!(&error, RigError::Derivative(PcgError::NotConverged { .. })),
            _ => matches!(&error, RigError::Derivative(PcgError::Tolerance { .. })),
        };
        assert!(expected, "{tolerance:e}: {error}");
        let loss = vec![[1.0; 3]; derivative.positions().len()];
        let error = derivative.gradient(&loss, &directions).unwrap_err();
        assert!(matches!(error, RigError::Derivative(_)), "{error}");
    }
}

/// Flesh that is pressed between the plates and has not buckled yet.
#[test]
fn a_pose_that_is_not_stable_has_no_derivative_either_way() {
    for multigrid in [MultigridUse::Never, MultigridUse::Always] {
        let mut rig = rig(multigrid, 1e-10);
        let mut at = rig.equilibrium().clone();
        // No equilibrium, but a place where the stiffness is indefinite: flesh to a third of its length.
        at.parameters.jaw.translation[2] = -0.055;
        for z in &mut at.in_cranium_frame {
            z[2] *= 0.025 / 0.08;
        }
        rig.start_from(at).unwrap();
        let derivative = rig.sensitivity();
        let error = match derivative {
            Ok(derivative) => derivative.columns(&Direction::all(MUSCLES)).unwrap_err(),
            Err(error) => error,
        };
        let surely = matches!(error, RigError::Unstable(_));
        let by_levels = matches!(error, RigError::Hierarchy(_));
        let always = multigrid == MultigridUse::Always;
        assert_eq!(
            (surely, by_levels),
            (!always, always),
            "{multigrid:?}: {error}"
        );
    }
}

#[test]
fn a_fit_by_multigrid_finds_what_one_by_factors_finds() {
    let fitted = |multigrid| {
        let mut rig = rig_with(RigParams {
            multigrid,
            ..RigParams::for_fits()
        });
        let map = Parametrization::of_all(MUSCLES, CraniumModel::Rigid, JawModel::Fixed);
        let mut truth = map.rest();
        truth[..MUSCLES].copy_from_slice(&[0.3, 0.1, 0.2]);
        let target = rig
            .solve(&map.parameters(&truth).unwrap())
            .unwrap()
            .positions();
        let fitter = Fitter {
            observation: &AllNodes {
                nodes: target.len(),
            },
            target: target.as_flattened(),
            weights: &[],
            parametrization: &map,
            params: &FitParams::default(),
        };
        let before = rig.work();
        let fit = rig.fit(&fitter, &map.rest(), &mut |_| {}).unwrap();
        (fit.q, fit.iterations.len(), rig.work() - before)
    };
    let (exact, found) = (fitted(MultigridUse::Never), fitted(MultigridUse::Always));
    assert!(largest(exact.0.iter().zip(&found.0).map(|(a, b)| a - b)) < 1e-6);
    assert_eq!(exact.1, found.1);
    assert!(found.2.factorizations == 0 && exact.2.factorizations > 0);
    assert_eq!(exact.2.right_hand_sides, found.2.right_hand_sides);
    // Predictions lead as near with either; a step by conjugate gradients may leave one more to take.
    assert!(found.2.newton_steps <= exact.2.newton_steps + exact.2.equilibria);
}
