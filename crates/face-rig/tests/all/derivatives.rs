//! dx/dθ against differences of full re-solves, adjoints against columns, and a fit that finds a
//! known pose, on a block of flesh between a fixed plate (cranium) and a moving one (jaw).

use super::promise::Rig;
use face_rig::anatomy::{CondylarPath, EmbeddedPoint, JawHinge, JawJoint, JointLimits};
use face_rig::fit::{
    CraniumModel, FitError, FitIteration, FitParams, Fitter, JawModel, Orthogonality,
    Parametrization,
};
use face_rig::rig::{
    AffineMap, AllNodes, Direction, EmbeddedPoints, JacobianRoute, MultigridUse, Observation,
    Parameters, PartError, RigError, RigParams,
};
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs, Fiber, ImplicitSurface, Penalty, Scaled, Springs};
use fem_materials::curves::PhysBam;
use fem_materials::{FiberLaw, StableNeoHookean, Stretch};
use fem_solvers::{Damping, StepMethod, Watch};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

pub(super) const MUSCLES: usize = 3;
/// What the flesh presses against: a half-space and a ball (document 000, 5.7).
const PLANE: ImplicitSurface<3> = ImplicitSurface::HalfSpace {
    point: [0.001, 0.0, 0.0],
    normal: [1.0, 0.0, 0.0],
};
const BALL: ImplicitSurface<3> = ImplicitSurface::Sphere {
    center: [0.06, 0.02, 0.04],
    radius: 0.022,
};

pub(super) fn rig() -> Rig {
    let mut params = RigParams::default();
    params.newton.gradient_tolerance = 1e-13;
    params.newton.relative_gradient_tolerance = 0.0;
    rig_with(params)
}

/// The same, solved otherwise.
pub(super) fn rig_with(params: RigParams) -> Rig {
    rig_of(params, 1.0, 1.0)
}

/// Lengths in another unit, and every stiffness and strength times `factor`.
pub(super) fn rig_of(params: RigParams, unit: f64, factor: f64) -> Rig {
    rig_pulled_by(PhysBam::default(), params, unit, factor)
}

/// The same with another tension curve.
pub(super) fn rig_pulled_by(curve: PhysBam, params: RigParams, unit: f64, factor: f64) -> Rig {
    let mesh = kuhn_grid(2, 2, 4, [0.04, 0.04, 0.08].map(|l| l * unit)).unwrap();
    let rest = mesh.nodes().to_vec();
    let at = |z: f64| {
        (0..rest.len())
            .filter(|&n| (rest[n][2] - z * unit).abs() < 1e-9 * unit)
            .collect()
    };
    let (cranium, jaw): (Vec<usize>, Vec<usize>) = (at(0.0), at(0.08));
    let prescribed: Vec<usize> = cranium.iter().chain(&jaw).copied().collect();
    let fibers: Vec<Fiber> = (0..mesh.elements().len())
        .map(|element| Fiber {
            element,
            control: element % MUSCLES,
            direction: [[0.0, 0.6, 0.8], [0.8, 0.0, 0.6], [0.6, 0.8, 0.0]][element % MUSCLES],
            max_isometric_stress: 2e4 * factor,
            optimal_stretch: 1.0,
        })
        .collect();
    let law = FiberLaw {
        curve,
        stretch: Stretch::Total,
    };
    let assembly = AssemblyBuilder::new(
        &mesh,
        Dofs::with_prescribed_nodes(&rest, &prescribed).unwrap(),
    )
    .unwrap()
    .material(StableNeoHookean {
        mu: 1e4 * factor,
        lambda: 9e4 * factor,
    })
    .unwrap()
    .fibers(law, MUSCLES, &fibers)
    .unwrap()
    .penalty(against(PLANE, unit, factor))
    .unwrap()
    .penalty(against(BALL, unit, factor))
    .unwrap()
    .build()
    .unwrap();
    Rig::new(assembly, &jaw, params).unwrap()
}

fn against(obstacle: ImplicitSurface<3>, unit: f64, factor: f64) -> Penalty<3> {
    let obstacle = match obstacle {
        ImplicitSurface::HalfSpace { point, normal } => ImplicitSurface::HalfSpace {
            point: point.map(|x| x * unit),
            normal,
        },
        ImplicitSurface::Sphere { center, radius } => ImplicitSurface::Sphere {
            center: center.map(|x| x * unit),
            radius: radius * unit,
        },
        other => other,
    };
    Penalty {
        nodes: (0..45).collect(),
        stiffness: 300.0 * unit * factor,
        obstacle,
    }
}

#[test]
fn a_pose_has_one_shape_in_every_unit_and_leaves_no_force() {
    let pose_in = |unit: f64| {
        let mut pose = pose();
        pose.jaw.translation = pose.jaw.translation.map(|t| t * unit);
        pose.cranium.translation = pose.cranium.translation.map(|t| t * unit);
        pose
    };
    let mut shapes: Vec<Vec<f64>> = Vec::new();
    for (unit, factor) in [
        (1.0, 1.0),
        (1e-9, 1.0),
        (1e3, 1.0),
        (1.0, 1e-10),
        (1.0, 1e3),
        (1.0, 1e6),
    ] {
        let mut rig = rig_of(RigParams::default(), unit, factor);
        let solved = rig.solve(&pose_in(unit)).unwrap().clone();
        let shape = solved.in_cranium_frame.as_flattened();
        shapes.push(shape.iter().map(|x| x / unit).collect());
        // Summed over all nodes instead of rows.
        let assembly = rig.assembly();
        let activations = &solved.parameters.activations;
        let at = assembly
            .configuration(&solved.in_cranium_frame, activations)
            .unwrap();
        let left = assembly
            .dofs()
            .gather(&assembly.forces_everywhere(at))
            .unwrap();
        let met = largest(assembly.absolute_forces(at));
        assert!(largest(left) <= 2e-9 * met, "{unit:e}, {factor:e}");
    }
    for shape in &shapes {
        let off = largest(shape.iter().zip(&shapes[0]).map(|(a, b)| a - b));
        assert!(off < 1e-8, "{off:e} m");
    }
}

#[test]
fn a_pose_without_equilibrium_leaves_the_last_good_one_and_flesh_without_bones_is_named() {
    let mut params = RigParams::default();
    params.newton.max_iterations = 0;
    let mut rig = rig_of(params, 1.0, 1.0);
    let error = rig.solve(&pose()).unwrap_err();
    let RigError::NoEquilibrium { last, source, .. } = error else {
        panic!("{error}");
    };
    assert_eq!(*last, *rig.equilibrium());
    assert!(matches!(*source, PartError::Newton(_)), "{source}");
    let mesh = kuhn_grid(2, 2, 4, [0.04, 0.04, 0.08]).unwrap();
    let flesh = StableNeoHookean {
        mu: 1e4,
        lambda: 9e4,
    };
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &[0]).unwrap();
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let assembly = builder.material(flesh).unwrap().build().unwrap();
    let error = Rig::new(assembly, &[], RigParams::default()).unwrap_err();
    assert!(
        matches!(&error, RigError::Free(part) if part.nodes == 44 && part.motions.len() == 3),
        "{error}"
    );
}

/// The jaw's plate goes through the cranium's: forces vanish with the flesh inside out.
#[test]
fn an_equilibrium_inside_out_is_none_where_the_rig_refuses_it() {
    let through = || {
        let mut pose = Parameters::rest(MUSCLES);
        pose.jaw.translation[2] = -0.12;
        pose
    };
    let mut allowed = rig_of(RigParams::default(), 1.0, 1.0);
    let shape = allowed.solve(&through()).unwrap().in_cranium_frame.clone();
    let assembly = allowed.assembly();
    let ratios = assembly
        .volume_ratios(assembly.positions(&shape).unwrap())
        .unwrap();
    assert!(ratios.iter().any(|ratio| *ratio < 0.0));
    let params = RigParams {
        refuses_inverted: true,
        ..RigParams::default()
    };
    let mut rig = rig_of(params, 1.0, 1.0);
    let error = rig.solve(&through()).unwrap_err();
    let RigError::NoEquilibrium {
        last,
        source,
        percent,
        ..
    } = error
    else {
        panic!("{error}");
    };
    // The last pose that was solved on the way, not the one that the rig came from.
    let way = last.parameters.jaw.translation[2] / -0.12;
    assert!(
        percent > 5.0 && (100.0 * way - percent).abs() < 1e-9,
        "{way} {percent}"
    );
    assert_eq!(rig.equilibrium().parameters.jaw.translation[2], 0.0);
    assert!(
        matches!(*source, PartError::Inverted { ratio, .. } if ratio <= 0.0),
        "{source}"
    );
    let ratios = assembly
        .volume_ratios(assembly.positions(&last.in_cranium_frame).unwrap())
        .unwrap();
    assert!(ratios.iter().all(|ratio| *ratio > 0.0));
}

/// The same pose as above, at the end of a way that can be walked in parts up to somewhere.
#[test]
fn a_pose_is_reached_whole_or_not_at_all_where_that_is_asked() {
    let params = RigParams {
        refuses_inverted: true,
        ..RigParams::default()
    };
    let mut pose = Parameters::rest(MUSCLES);
    pose.jaw.translation[2] = -0.12;
    let mut rig = rig_of(params, 1.0, 1.0);
    let error = rig.lent(|rig| rig.solve_whole(&pose).cloned()).unwrap_err();
    assert!(
        matches!(error, RigError::NoEquilibrium { percent: 0.0, .. }),
        "{error}"
    );
    assert_eq!(rig.work().equilibria, 1);
    assert_eq!(rig.equilibrium().parameters.jaw.translation[2], 0.0);
    pose.jaw.translation[2] = 0.005;
    let whole = rig.lent(|rig| rig.solve_whole(&pose).cloned()).unwrap();
    let mut other = rig_of(params, 1.0, 1.0);
    assert_eq!(whole, *other.solve(&pose).unwrap());
}

#[test]
fn flesh_that_springs_of_a_control_hold_is_no_free_flesh() {
    let mesh = kuhn_grid(2, 2, 4, [0.04, 0.04, 0.08]).unwrap();
    let flesh = StableNeoHookean {
        mu: 1e4,
        lambda: 9e4,
    };
    let rig = |held: usize| {
        let ends = (0..held).map(|n| (n, mesh.nodes()[n]));
        let springs = Springs::at_nodes(ends, 50.0).unwrap();
        let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &[0]).unwrap();
        let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
        let builder = builder.material(flesh).unwrap();
        let builder = builder.term(Scaled::new(springs, 0).unwrap()).unwrap();
        Rig::new(builder.build().unwrap(), &[], RigParams::default())
    };
    rig(9).expect("springs hold it at 1");
    assert!(matches!(rig(1), Err(RigError::Free(_))));
}

/// A watch that ends the solve at its `limit`-th question, counted over all solves.
fn ends_at(limit: usize) -> (Watch, Arc<AtomicUsize>) {
    let asked = Arc::new(AtomicUsize::new(0));
    let count = asked.clone();
    let watch = Watch::new(
        move |_| match count.fetch_add(1, Ordering::Relaxed) + 1 < limit {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        },
    );
    (watch, asked)
}

#[test]
fn a_cancelled_pose_or_fit_ends_at_once_and_the_rig_goes_on() {
    let wanted = rig().solve(&pose()).unwrap().clone();
    let (watch, asked) = ends_at(3);
    let mut watched = rig().watched_by(watch);
    let before = watched.equilibrium().clone();
    let error = watched.solve(&pose()).unwrap_err();
    assert!(error.is_cancelled(), "{error}");
    // No smaller step is tried.
    assert_eq!(asked.load(Ordering::Relaxed), 3);
    assert_eq!(*watched.equilibrium(), before);

    let go_on = Watch::new(|_| ControlFlow::Continue(()));
    let mut watched = watched.watched_by(go_on);
    assert_eq!(*watched.solve(&pose()).unwrap(), wanted);

    let map = Parametrization::of_all(MUSCLES, CraniumModel::Rigid, JawModel::Fixed);
    let target = wanted.positions();
    let fitter = Fitter {
        observation: &AllNodes {
            nodes: target.len(),
        },
        target: target.as_flattened(),
        weights: &[],
        parametrization: &map,
        params: &FitParams::default(),
    };
    let (watch, all) = ends_at(usize::MAX);
    let mut whole = Vec::new();
    let mut start = |_: &FitIteration| whole.push(all.load(Ordering::Relaxed));
    let _ = rig()
        .watched_by(watch)
        .fit(&fitter, &map.rest(), &mut start);
    // In the trial after the first accepted step.
    let (watch, asked) = ends_at(whole[1] + 1);
    let end = rig()
        .watched_by(watch)
        .fit(&fitter, &map.rest(), &mut |_| {});
    let Err(FitError::Cancelled { q, iterations }) = end else {
        panic!("{end:?}");
    };
    assert_eq!(iterations.len(), 2);
    assert_ne!(q, map.rest());
    assert_eq!(asked.load(Ordering::Relaxed), whole[1] + 1);
}

/// A pose with a cranium that is no rotation and a jaw that is turned, sheared and shifted.
pub(super) fn pose() -> Parameters {
    let mut pose = Parameters::rest(MUSCLES);
    pose.activations = vec![0.7, 0.25, 0.4];
    pose.cranium.matrix = [[1.1, 0.2, 0.0], [-0.1, 0.9, 0.1], [0.05, 0.0, 1.05]];
    pose.cranium.translation = [0.3, -0.2, 0.1];
    pose.jaw.matrix = [[1.0, 0.05, 0.0], [0.0, 0.98, -0.12], [0.0, 0.12, 1.01]];
    pose.jaw.translation = [0.001, 0.004, -0.003];
    pose
}

pub(super) fn largest(v: impl IntoIterator<Item = f64>) -> f64 {
    v.into_iter().fold(0.0, |m, x| m.max(x.abs()))
}

#[test]
fn the_pose_of_these_tests_presses_on_both_obstacles() {
    let mut rig = rig();
    rig.solve(&pose()).unwrap();
    let z = &rig.equilibrium().in_cranium_frame;
    let free = |n: &usize| rig.assembly().dofs().row(*n).is_some();
    let behind = (0..z.len()).filter(free).filter(|&n| z[n][0] < 0.001);
    let distance = |x: [f64; 3]| {
        let c = [0.06, 0.02, 0.04];
        (0..3).map(|i| (x[i] - c[i]).powi(2)).sum::<f64>().sqrt()
    };
    let inside = (0..z.len())
        .filter(free)
        .filter(|&n| distance(z[n]) < 0.022);
    let (behind, inside) = (behind.count(), inside.count());
    assert!(behind > 0 && inside > 0, "{behind} and {inside} nodes");
}

#[test]
fn every_column_agrees_with_differences_of_full_solves() {
    let mut rig = rig();
    let theta = pose().to_vec();
    rig.solve(&pose()).unwrap();
    let columns = rig
        .sensitivity()
        .unwrap()
        .columns(&Direction::all(MUSCLES))
        .unwrap();
    assert_eq!(columns.len(), theta.len());
    for (k, column) in columns.iter().enumerate() {
        let mut at = |t: f64| {
            let mut moved = theta.clone();
            moved[k] += t;
            rig.solve(&Parameters::from_slice(&moved).unwrap())
                .unwrap()
                .positions()
        };
        let h = 2e-5;
        let (p1, m1, p2, m2) = (at(h), at(-h), at(2.0 * h), at(-2.0 * h));
        let scale = largest(column.iter().flatten().copied());
        for n in 0..column.len() {
            for i in 0..3 {
                let near = (p1[n][i] - m1[n][i]) * 8.0;
                let difference = (near - (p2[n][i] - m2[n][i])) / (12.0 * h);
                let error = (difference - column[n][i]).abs();
                assert!(
                    error < 2e-8 * scale,
                    "column {k}, node {n}: {error:e} of {scale:e}"
                );
            }
        }
    }
}

#[test]
fn adjoints_agree_with_columns() {
    let mut rig = rig();
    rig.solve(&pose()).unwrap();
    let sensitivity = rig.sensitivity().unwrap();
    let directions = Direction::all(MUSCLES);
    let points = EmbeddedPoints(vec![
        EmbeddedPoint {
            nodes: [9, 10, 12, 30],
            weights: [0.4, 0.3, 0.2, 0.1],
        },
        EmbeddedPoint {
            nodes: [20, 21, 40, 41],
            weights: [0.7, 0.3, -0.2, 0.2],
        },
        EmbeddedPoint::node(13),
        EmbeddedPoint::node(44),
    ]);
    let all = AllNodes {
        nodes: sensitivity.positions().len(),
    };
    for observation in [&points as &dyn Observation, &all] {
        let one = sensitivity
            .jacobian(observation, &directions, JacobianRoute::Columns)
            .unwrap();
        let other = sensitivity
            .jacobian(observation, &directions, JacobianRoute::Adjoint)
            .unwrap();
        let scale = largest(one.iter().copied());
        for (a, b) in one.iter().zip(&other) {
            assert!((a - b).abs() < 1e-11 * scale, "{a} against {b}");
        }
    }
    assert_eq!(
        sensitivity.cheaper_route(&points, &directions),
        JacobianRoute::Adjoint
    );
    assert_eq!(
        sensitivity.cheaper_route(&all, &directions),
        JacobianRoute::Columns
    );

    let loss: Vec<[f64; 3]> = (0..all.nodes)
        .map(|n| std::array::from_fn(|i| (n as f64 + 0.3 * i as f64).sin()))
        .collect();
    let gradient = sensitivity.gradient(&loss, &directions).unwrap();
    for (column, value) in sensitivity
        .columns(&directions)
        .unwrap()
        .iter()
        .zip(gradient)
    {
        let exact: f64 = column
            .as_flattened()
            .iter()
            .zip(loss.as_flattened())
            .map(|(a, b)| a * b)
            .sum();
        assert!((exact - value).abs() < 1e-11 * exact.abs().max(1.0));
    }
}

#[test]
fn a_reachable_pose_is_found_again_by_qr_and_by_normal_equations() {
    for method in [StepMethod::Qr, StepMethod::NormalEquations] {
        let mut rig = rig();
        let hinge = JawHinge::sideways([0.02, 0.0, 0.05]);
        let joint = JawJoint::new(hinge, CondylarPath::ADULT, JointLimits::ADULT).unwrap();
        let jaw = JawModel::Joint(joint);
        let cranium = CraniumModel::Rigid;
        let map = Parametrization {
            muscles: MUSCLES,
            active: vec![0, 1, 2],
            cranium,
            jaw,
            controls: Vec::new(),
        };
        let truth = [
            0.6, 0.0, 0.3, 0.1, -0.2, 0.3, 0.01, 0.02, -0.03, 0.15, 0.002, -0.001, 0.03,
        ];
        let target = rig
            .solve(&map.parameters(&truth).unwrap())
            .unwrap()
            .positions();
        let params = FitParams {
            method,
            activation_weight: 0.0,
            joint_weight: 0.0,
            rms_tolerance: 1e-11,
            rms_change: 0.0,
            step_tolerance: 0.0,
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
        let mut beyond = map.rest();
        beyond[1] = 1.5;
        let refused = rig.fit(&fitter, &beyond, &mut |_| {}).unwrap_err();
        assert!(
            matches!(
                refused,
                FitError::StartOutOfBounds {
                    index: 1,
                    upper: 1.0,
                    ..
                }
            ),
            "{refused}"
        );
        let report = rig.fit(&fitter, &map.rest(), &mut |_| {}).unwrap();
        for (found, truth) in report.q.iter().zip(truth) {
            assert!(
                (found - truth).abs() < 1e-6,
                "{found} for {truth} by {method:?}"
            );
        }
        assert!(report.iterations.len() < 20);
    }
}

#[test]
fn full_steps_on_the_affine_maps_find_a_rigid_pose() {
    let mut rig = rig();
    let map = Parametrization::affine(MUSCLES);
    let mut truth = Parameters::rest(MUSCLES);
    truth.activations = vec![0.2, 0.5, 0.1];
    truth.jaw.matrix = [[1.0, 0.0, 0.0], [0.0, 0.8, -0.6], [0.0, 0.6, 0.8]];
    truth.jaw.translation = [0.0, 0.045, 0.02];
    let target = rig.solve(&truth).unwrap().positions();
    let params = FitParams {
        damping: Damping::None,
        activation_bounds: None,
        activation_weight: 0.0,
        orthogonality: Orthogonality {
            cranium: 1.0,
            jaw: 1.0,
        },
        rms_tolerance: 1e-11,
        rms_change: 0.0,
        step_tolerance: 0.0,
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
    let report = rig.fit(&fitter, &map.rest(), &mut |_| {}).unwrap();
    let found = report.parameters.to_vec();
    assert!(largest(found.iter().zip(truth.to_vec()).map(|(a, b)| a - b)) < 1e-6);
    let map: AffineMap = report.parameters.jaw;
    assert!(largest(map.orthogonality()) < 1e-6);
}

#[test]
fn the_guess_for_a_pose_close_by_is_its_solution() {
    let mut rig = rig_of(RigParams::default(), 1.0, 1.0);
    let mut pose = pose();
    rig.solve(&pose).unwrap();
    let _ = rig.sensitivity().unwrap();
    // The tangent is off by the square of the change: far below the tolerance, twice the change is not.
    pose.activations[0] += 1e-7;
    pose.jaw.translation[1] += 1e-9;
    let before = rig.work().newton_steps;
    rig.solve(&pose).unwrap();
    assert_eq!(rig.work().newton_steps, before);
}

#[test]
fn multigrid_finds_the_pose_that_factors_find() {
    let pose = pose();
    let solved = |multigrid| {
        let mut rig = rig_with(RigParams {
            multigrid,
            ..RigParams::default()
        });
        rig.solve(&pose).unwrap();
        (rig.equilibrium().positions(), rig.work())
    };
    let (never, always) = (solved(MultigridUse::Never), solved(MultigridUse::Always));
    assert!(never.1.factorizations > 0 && never.1.linear_iterations == 0);
    assert!(always.1.factorizations == 0 && always.1.linear_iterations > 0);
    for (a, b) in never.0.iter().zip(&always.0) {
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-9));
    }
    // So small a body is cheaper to factor.
    let (counted, work) = solved(MultigridUse::WhereCheaper);
    assert!(counted == never.0 && work.linear_iterations == 0);
}
