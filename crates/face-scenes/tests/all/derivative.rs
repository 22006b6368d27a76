//! dx/dθ of the built-in face by multigrid and by a factor.

use crate::motion::parameters;
use crate::promise::Rig;
use face_rig::rig::{Direction, JacobianRoute, MultigridUse, RigParams};
use face_scenes::{Contact, Scene};

const TETS: usize = 4_000;

fn off(found: &[f64], exact: &[f64]) -> f64 {
    let largest =
        |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |m: f64, v| m.max(v.abs()));
    largest(&mut found.iter().zip(exact).map(|(a, b)| a - b)) / largest(&mut exact.iter().copied())
}

/// Columns of some directions at all nodes, and the adjoints of two landmarks in all directions.
fn derivatives(scene: &Scene, rig: &mut Rig) -> [Vec<f64>; 2] {
    let all = Direction::all(scene.muscles.len());
    let some: Vec<Direction> = all.iter().step_by(7).copied().collect();
    let points = scene.landmark_points([48, 57]);
    let derivative = rig.sensitivity().unwrap();
    let columns = derivative.columns(&some).unwrap();
    let adjoints = derivative.jacobian(&points, &all, JacobianRoute::Adjoint);
    [columns.concat().concat(), adjoints.unwrap()]
}

#[test]
fn multigrid_and_a_factor_give_one_derivative_with_lips_that_press_and_without() {
    let mut shapes = Vec::new();
    for touches in [true, false] {
        let mut scene = Scene::builtin(TETS).expect("a face");
        if !touches {
            scene.contact = Contact::default();
        }
        let muscles = ["orbicularis_oris_upper", "orbicularis_oris_lower"];
        let pose = parameters(&scene, &muscles, &["L", "R"], 0.3);
        let rig = |multigrid| {
            let params = RigParams {
                multigrid,
                ..RigParams::default()
            };
            Rig::of(scene.rig(params).unwrap(), params)
        };
        let (mut factored, mut iterated) = (rig(MultigridUse::Never), rig(MultigridUse::Always));
        factored.solve(&pose).unwrap();
        iterated.start_from(factored.equilibrium().clone()).unwrap();
        let exact = derivatives(&scene, &mut factored);
        let found = derivatives(&scene, &mut iterated);
        for (found, exact) in found.iter().zip(&exact) {
            assert!(
                off(found, exact) < 1e-8,
                "{touches}: {:e}",
                off(found, exact)
            );
        }
        let (factors, iterations) = (factored.work(), iterated.work());
        assert!(factors.linear_iterations == 0 && iterations.factorizations == 0);
        assert_eq!(factors.right_hand_sides, iterations.right_hand_sides);
        shapes.push(factored.equilibrium().positions().concat());
    }
    // The lips do press.
    assert!(off(&shapes[0], &shapes[1]) > 1e-4);
}
