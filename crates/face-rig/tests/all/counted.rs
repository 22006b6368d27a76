//! What a fit pays for.

use super::derivatives::{MUSCLES, pose, rig, rig_pulled_by, rig_with};
use super::promise::Rig;
use face_rig::anatomy::{EmbeddedPoint, JawHinge};
use face_rig::fit::{CraniumModel, FitParams, Fitter, JawModel, Parametrization};
use face_rig::rig::{
    AllNodes, EmbeddedPoints, MultigridUse, Observation, Parameters, RigParams, Work,
};
use fem_assembly::Passes;
use fem_materials::curves::PhysBam;

/// A fit of some muscles and the jaw's opening to some points, and what it took.
fn fitted_by(observation: &dyn Observation, active: Vec<usize>) -> (usize, Work) {
    fitted_with(rig(), observation, active)
}

fn fitted_with(mut rig: Rig, observation: &dyn Observation, active: Vec<usize>) -> (usize, Work) {
    let hinge = JawHinge::sideways([0.02, 0.0, 0.05]);
    let map = Parametrization {
        muscles: MUSCLES,
        active,
        cranium: CraniumModel::Rigid,
        jaw: JawModel::Hinge(hinge),
        controls: Vec::new(),
    };
    let mut truth = map.rest();
    truth[0] = 0.3;
    rig.solve(&map.parameters(&truth).unwrap()).unwrap();
    let shape = rig.equilibrium().positions();
    let mut target = vec![0.0; observation.dim()];
    observation.value(&shape, &mut target);
    let params = FitParams::default();
    let fitter = Fitter {
        observation,
        target: &target,
        weights: &[],
        parametrization: &map,
        params: &params,
    };
    rig.solve(&Parameters::rest(MUSCLES)).unwrap();
    let before = rig.work();
    let report = rig.fit(&fitter, &map.rest(), &mut |_| {}).unwrap();
    (report.iterations.len(), rig.work() - before)
}

#[test]
fn a_fit_solves_for_what_varies_or_for_what_is_seen_whichever_is_less() {
    // The head's six numbers turn the whole face and need no solve; one muscle and an opening do.
    let all = AllNodes { nodes: 45 };
    let (steps, work) = fitted_by(&all, vec![1]);
    assert!(steps > 1 && work.right_hand_sides.is_multiple_of(2));
    assert!(work.right_hand_sides / 2 <= steps);
    let (steps, more) = fitted_by(&all, vec![0, 1, 2]);
    assert!(steps > 1 && more.right_hand_sides.is_multiple_of(4));
    // One coordinate triple is seen, four directions vary.
    let point = EmbeddedPoints(vec![EmbeddedPoint::node(20)]);
    let (steps, seen) = fitted_by(&point, vec![0, 1, 2]);
    assert!(steps > 1 && seen.right_hand_sides.is_multiple_of(3));
    assert!(seen.right_hand_sides / 3 <= steps);
    // No model here decomposes, and nothing was projected.
    assert_eq!(
        (
            work.evaluations.decompositions,
            work.evaluations.projections
        ),
        (0, 0)
    );
    assert!(work.evaluations.elements.gradients > 0 && work.factorizations > 0);
}

/// Each muscle has 32 of the 96 tetrahedra.
#[test]
fn a_muscle_without_a_parameter_in_the_fit_has_no_column_and_without_passive_tension_no_work() {
    let all = AllNodes { nodes: 45 };
    let pulled_by = |p1: f64| {
        let curve = PhysBam {
            P1: p1,
            ..PhysBam::default()
        };
        rig_pulled_by(curve, RigParams::default(), 1.0, 1.0)
    };
    let of = |p1, active| fitted_with(pulled_by(p1), &all, active).1.evaluations;
    // A path and a derivative for each change of the one muscle, whatever the others' fibers resist.
    for p1 in [0.05, 0.0] {
        let (one, three) = (of(p1, vec![1]).fibers, of(p1, vec![0, 1, 2]).fibers);
        assert!(one.by_control > 0 && one.by_control.is_multiple_of(32));
        assert!(2 * one.by_control < three.by_control, "{one:?} {three:?}");
    }
    // With passive tension relaxed fibers resist and are evaluated; without, the active ones alone.
    let shares = |p1, active| {
        let done = of(p1, active);
        let Passes {
            energies,
            gradients,
            hessians,
            products,
            ..
        } = done.fibers;
        let elements = done.elements;
        let all = elements.energies + elements.gradients + elements.hessians + elements.products;
        (energies + gradients + hessians + products, all)
    };
    let (fibers, elements) = shares(0.05, vec![1]);
    assert_eq!(fibers, elements);
    let (fibers, elements) = shares(0.0, vec![1]);
    assert!(fibers > 0 && 3 * fibers <= elements, "{fibers} {elements}");
}

#[test]
fn rigs_for_fits_find_the_same_with_fewer_newton_steps() {
    let solved = |params| {
        let mut rig = rig_with(params);
        let poses = (1..6).map(|k| {
            let mut pose = Parameters::rest(MUSCLES);
            pose.activations[k % MUSCLES] = 0.2 * k as f64;
            rig.solve(&pose).unwrap().positions()
        });
        let poses: Vec<_> = poses.collect();
        (poses, rig.work().newton_steps)
    };
    let (exact, all) = solved(RigParams::default());
    let (near, fewer) = solved(RigParams::for_fits());
    assert!(fewer < all, "{fewer} of {all}");
    // A tenth of a micrometer in a block of eight centimeters.
    for (a, b) in exact.iter().flatten().zip(near.iter().flatten()) {
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-7), "{a:?} {b:?}");
    }
}

/// Factors and hierarchies serve later poses as long as they are good enough; a pose that is started from
/// another one takes the same steps, iterations and bits whatever was solved or derived before.
#[test]
fn what_starts_from_a_pose_depends_on_nothing_done_before() {
    let kept = RigParams {
        keeps_factor_above: 0.0,
        ..RigParams::default()
    };
    let hierarchies = RigParams {
        multigrid: MultigridUse::Always,
        ..RigParams::default()
    };
    for params in [RigParams::default(), kept, hierarchies] {
        let mut rig = rig_with(params);
        let rest = rig.solve(&Parameters::rest(MUSCLES)).unwrap().clone();
        let mut runs = Vec::new();
        for other in [0.0, 0.3, 0.0, 0.9] {
            let mut elsewhere = Parameters::rest(MUSCLES);
            elsewhere.activations[1] = other;
            rig.start_from(rest.clone()).unwrap();
            rig.solve(&elsewhere).unwrap();
            let _ = rig.sensitivity().unwrap();
            rig.start_from(rest.clone()).unwrap();
            let before = rig.work();
            let shape = rig.solve(&pose()).unwrap().positions();
            let _ = rig.sensitivity().unwrap();
            let done = rig.work() - before;
            let counts = [done.newton_steps, done.factorizations];
            runs.push((shape, counts, done.linear_iterations));
        }
        for run in &runs[1..] {
            assert!(
                *run == runs[0],
                "{:?} {:?}",
                (run.1, run.2),
                (runs[0].1, runs[0].2)
            );
        }
    }
}
