//! A pose with two shapes: the one whose skin does not pass through itself is taken.

use super::influence_tests::rig;
use super::*;
use crate::uncrossed::{ANOTHER, Ended, Fit, UNSETTLED};
use face_rig::anatomy::Bones;
use face_rig::fit::{
    CraniumModel, FitError, FitIteration, FitParams, FitReport, Goals, JawModel, Parametrization,
};
use face_rig::rig::Equilibrium;
use fem_assembly::FleshContactParams;
use fem_solvers::{GaussNewtonFailure, GaussNewtonStop};

/// How far the jaw brings the lower block up, and what lies between the blocks at rest, meters.
const RISE: f64 = 5e-3;
const SLIT: f64 = 2e-3;

/// A block on the cranium, and under it a narrower one on the jaw; they touch.
fn two_blocks() -> Scene {
    let mut scene = Files::new().load().expect("a sound scene");
    let upper = kuhn_grid(3, 3, 3, [0.024, 0.012, 0.024]).expect("a grid");
    let lower = kuhn_grid(2, 3, 2, [0.009, 0.012, 0.009]).expect("a grid");
    let above = upper.nodes().iter().map(|&[x, y, z]| [x, y + SLIT, z]);
    let below = |&[x, y, z]: &[f64; 3]| [x + 0.0075, y - 0.012, z + 0.0075];
    let nodes: Vec<[f64; 3]> = above.chain(lower.nodes().iter().map(below)).collect();
    let count = upper.num_nodes() as u32;
    let tets = upper
        .tets()
        .chain(lower.tets().map(|t| t.map(|n| n + count)));
    let tets: Vec<u32> = tets.flatten().collect();
    let holds = |&[_, y, _]: &[f64; 3]| match y {
        y if y > 0.0139 => Bone::Cranium,
        y if y < -0.0119 => Bone::Jaw,
        _ => Bone::Free,
    };
    scene.bones = Bones::new(nodes.iter().map(holds).collect());
    scene.region_of_tet = vec![0; tets.len() / 4];
    scene.mesh = SimplexMesh::new(nodes, tets).expect("two blocks");
    scene.muscles = Vec::new();
    scene.fiber_field = FiberField::default();
    scene.embedding = BTreeMap::new();
    scene.landmarks = Vec::new();
    scene.skin = Some(Skin::of_nodes(&scene.mesh, &scene.mesh.boundary().faces));
    scene.contact.flesh = Some(FleshContactParams {
        activation: 3e-4,
        pressure: 3e5,
        depth: 1e-3,
        margin: 5e-4,
        ..FleshContactParams::default()
    });
    scene
}

fn shut(scene: &Scene) -> Target {
    let goal = |&n: &u32| {
        let [x, y, z] = scene.mesh.node(n);
        face_rig::fit::Goal {
            point: EmbeddedPoint::node(n),
            position: [x, y + RISE, z],
            weight: 1.0,
        }
    };
    Target {
        name: "shut".into(),
        kind: TargetKind::Expression,
        landmarks: scene.bones.jaw.iter().map(goal).collect(),
        dense: None,
        jaw_truth: None,
        alignment: None,
    }
}

/// The jaw moves as a rigid body.
fn rigid(scene: &Scene) -> Parametrization {
    let point = scene.joint.hinge().point();
    Parametrization::of_all(0, CraniumModel::Fixed, JawModel::Rigid { point })
}

#[test]
fn a_fit_whose_shape_is_not_found_again_goes_on_from_the_one_that_is() {
    let scene = two_blocks();
    let (target, map, params) = (shut(&scene), rigid(&scene), FitParams::default());
    let goals: Goals = target.landmarks.iter().copied().collect();
    let mut rig = rig(&scene);
    let rest = rig.equilibrium().positions();
    // What a fit tells of its last step, and the distance of the shape that it leaves.
    let mut there = map.rest();
    there[map.jaw_start() + 4] = RISE;
    // The last stands where no step is left to take; that start is what it then tells of.
    for (share, goes_on, q) in [
        (1.0, false, map.rest()),
        (0.995, true, map.rest()),
        (0.9, true, map.rest()),
        (0.9, true, there),
    ] {
        let told = 1e3 * share * goals.rms(&rest);
        let stuck = FitIteration {
            iteration: 3,
            rms_mm: told,
            largest_mm: told,
            cost: 1.0,
            step: 1.0,
            damping: 1e5,
            activations_at_bounds: 0,
            seconds: 1.0,
        };
        let report = FitReport {
            parameters: map.parameters(&q).expect("a pose"),
            q,
            iterations: vec![stuck],
            stop: None,
            positions: rest.clone(),
        };
        let gave_up = GaussNewtonFailure::NoDecrease { lambda: 1e5 };
        let outcome = Outcome::NotConverged(Unfinished::Failed(Box::new(gave_up)));
        let ended = rig.lent(|rig| {
            let untold = FitReport {
                iterations: Vec::new(),
                ..report.clone()
            };
            let untold = Ended::of(rig, (untold, Outcome::Converged(None)));
            let first = Ended::of(rig, (report, outcome));
            let mut fit = Fit {
                fitter: goals.fitter(&map, &params),
                goals: &goals,
                observer: &mut |_| {},
            };
            assert!(fit.has_moved(&untold, UNSETTLED), "NaN is no distance");
            // By half a percent it is still what was fitted, but worth another look.
            assert_eq!(fit.has_moved(&first, ANOTHER), goes_on);
            assert_eq!(fit.has_moved(&first, UNSETTLED), share < 0.99);
            let ended = fit.taken_up_again(rig, first)?;
            assert!(!fit.has_moved(&ended, ANOTHER));
            Ok::<_, FitError>(ended)
        });
        let Ended {
            report, outcome, ..
        } = ended.expect("a fit");
        let converged = matches!(outcome, Outcome::Converged(_));
        assert_eq!(converged, goes_on, "{outcome:?}");
        assert_eq!(report.iterations[0], stuck);
        let numbers = report.iterations.iter().map(|step| step.iteration);
        assert!(numbers.eq(3..3 + report.iterations.len()));
        assert_eq!(goals.rms(&report.positions) < 1e-5, goes_on);
    }
}

#[test]
fn a_shape_beside_the_one_that_was_fitted_converged_with_it_up_to_a_hundredth() {
    let scene = two_blocks();
    let (target, map, params) = (shut(&scene), rigid(&scene), FitParams::default());
    let goals: Goals = target.landmarks.iter().copied().collect();
    let mut rig = rig(&scene);
    let q = map.rest();
    let fitted = FitReport {
        parameters: map.parameters(&q).expect("a pose"),
        q,
        iterations: Vec::new(),
        stop: Some(GaussNewtonStop::ResidualChange),
        positions: rig.equilibrium().positions(),
    };
    // The distance is the jaw's: the same pose with the jaw a share nearer to its goal.
    let end = Outcome::Converged(fitted.stop);
    let gave_up = Outcome::NotConverged(Unfinished::Steps(1));
    for (share, end, converged) in [
        (0.0, &end, true),
        (0.005, &end, true),
        (0.02, &end, false),
        (f64::NAN, &end, false),
        (0.005, &gave_up, false),
        (0.02, &gave_up, false),
    ] {
        let mut at = rig.equilibrium().clone();
        for &node in &scene.bones.jaw {
            at.in_cranium_frame[node as usize][1] += share * RISE;
        }
        let outcome = rig.lent(|rig| {
            let step = FitIteration {
                iteration: 1,
                rms_mm: 1e3 * goals.rms(&fitted.positions),
                largest_mm: 1e3 * RISE,
                cost: 1.0,
                step: 1.0,
                damping: 0.0,
                activations_at_bounds: 0,
                seconds: 1.0,
            };
            let report = FitReport {
                iterations: vec![step],
                ..fitted.clone()
            };
            let fit = Fit {
                fitter: goals.fitter(&map, &params),
                goals: &goals,
                observer: &mut |_| {},
            };
            let first = Ended::of(rig, (report, end.clone()));
            let left = fit.settled(first.at_another(at, &goals));
            Ok::<_, FitError>(left.outcome)
        });
        let outcome = outcome.expect("no solve");
        let has = matches!(outcome, Outcome::Converged(_));
        assert_eq!(has, converged, "{share}: {outcome:?}");
        let told = matches!(
            outcome,
            Outcome::NotConverged(Unfinished::AnotherShape { .. })
        );
        assert_eq!(told, !converged, "{share}: {outcome:?}");
    }
}

#[test]
fn lips_that_have_passed_through_each_other_are_brought_back() {
    let scene = two_blocks();
    let (target, map) = (shut(&scene), rigid(&scene));
    let mut start = map.rest();
    let up = map.jaw_start() + 4;
    start[up] = RISE;
    let parameters = map.parameters(&start).expect("a pose");
    assert_eq!(parameters.jaw.translation, [0.0, RISE, 0.0]);

    // The lower block inside the upper one, deeper than anything pushes.
    let mut passed = scene.mesh.nodes().to_vec();
    let lower = passed.iter_mut().filter(|x| x[1] < 0.5 * SLIT);
    lower.for_each(|x| x[1] += RISE);
    let skin = scene.skin.as_ref().expect("a skin");
    assert!(skin.crossings(&passed) > 10, "{}", skin.crossings(&passed));
    let mut rig = rig(&scene);
    let wrong = Equilibrium {
        parameters: parameters.clone(),
        in_cranium_frame: passed.clone(),
    };
    rig.start_from(wrong).expect("a shape");
    let stays = rig.solve(&parameters).expect("an equilibrium").positions();
    assert_eq!(skin.crossings(&stays), skin.crossings(&passed));

    let params = FitParams::default();
    let fit = rig
        .lent(|rig| {
            fit_expression(
                &scene,
                rig,
                &target,
                Observed::Landmarks,
                &map,
                &params,
                &start,
                &mut |_| {},
            )
        })
        .expect("a fit");
    // The blocks have no joint, of which the jaw is taken to have left it.
    assert!(
        matches!(fit.outcome, Outcome::Impossible(_)),
        "{:?}",
        fit.outcome
    );
    assert!(fit.rms_after_mm < 1e-3, "{}", fit.rms_after_mm);
    assert_eq!(fit.crossing_triangles, Some(0));
    let deepest = fit.deepest_contact_mm.expect("contact");
    assert!(deepest < 0.3, "{deepest}");
    assert_eq!(rig.equilibrium().positions(), fit.positions);
    // A start that is taken again is no step.
    let numbers = fit.history.iter().map(|step| step.iteration);
    assert!(numbers.eq(0..fit.history.len()), "{:?}", fit.history);
}
