//! Numbers, covectors and observations of another face are refused.

use super::derivatives::{MUSCLES, rig};
use face_rig::anatomy::EmbeddedPoint;
use face_rig::fit::{
    CraniumModel, FitError, FitParams, Fitter, Goal, Goals, JawModel, Parametrization,
};
use face_rig::rig::{AllNodes, Direction, EmbeddedPoints, JacobianRoute, Observation, RigError};
use fem_assembly::AssemblyError;

const NODES: usize = 45;

fn map() -> Parametrization {
    Parametrization {
        muscles: MUSCLES,
        active: vec![0, 1],
        cranium: CraniumModel::Rigid,
        jaw: JawModel::Fixed,
        controls: Vec::new(),
    }
}

#[test]
fn numbers_of_another_parametrization_are_refused() {
    let (map, expected) = (map(), map().len());
    assert!(map.parameters(&map.rest()).is_ok() && map.directions(&map.rest()).is_ok());
    for found in [0, expected - 1, expected + 1] {
        let q = vec![0.0; found];
        let errors = [map.parameters(&q).err(), map.directions(&q).err()];
        for error in errors {
            let Some(RigError::WrongLength {
                found: f,
                expected: e,
                ..
            }) = error
            else {
                panic!("{error:?}");
            };
            assert_eq!((f, e), (found, expected));
        }
    }
}

#[test]
fn observations_of_other_nodes_are_refused_by_derivatives_and_fits() {
    let mut rig = rig();
    assert_eq!(rig.assembly().rest().len(), NODES);
    let stranger = EmbeddedPoints(vec![
        EmbeddedPoint::node(0),
        EmbeddedPoint::node(NODES as u32),
    ]);
    let others: [&dyn Observation; 3] = [
        &AllNodes { nodes: NODES - 1 },
        &AllNodes { nodes: NODES + 1 },
        &stranger,
    ];
    let directions = [Direction::Activation(0)];
    let (map, params) = (map(), FitParams::default());
    for other in others {
        let sensitivity = rig.sensitivity().unwrap();
        for route in [JacobianRoute::Columns, JacobianRoute::Adjoint] {
            let error = sensitivity.jacobian(other, &directions, route);
            assert!(matches!(error, Err(RigError::Assembly(_))), "{error:?}");
        }
        let fitter = Fitter {
            observation: other,
            target: &vec![0.0; other.dim()],
            weights: &[],
            parametrization: &map,
            params: &params,
        };
        let error = rig.fit(&fitter, &map.rest(), &mut |_| {}).err();
        assert!(
            matches!(&error, Some(FitError::Pose(e)) if matches!(**e, RigError::Assembly(_))),
            "{error:?}"
        );
    }
}

#[test]
fn a_covector_of_another_length_is_refused() {
    let mut rig = rig();
    let sensitivity = rig.sensitivity().unwrap();
    let directions = [Direction::Activation(0)];
    assert!(
        sensitivity
            .gradient(&[[1.0; 3]; NODES], &directions)
            .is_ok()
    );
    for found in [NODES - 1, NODES + 1] {
        let error = sensitivity.gradient(&vec![[1.0; 3]; found], &directions);
        let Err(RigError::Assembly(AssemblyError::WrongLength { found: f, .. })) = error else {
            panic!("{error:?}");
        };
        assert_eq!(f, found);
    }
}

#[test]
fn a_goal_of_another_mesh_is_no_distance_away() {
    let goal = |node| Goal {
        point: EmbeddedPoint::node(node),
        position: [0.0; 3],
        weight: 1.0,
    };
    let goals: Goals = [goal(3), goal(0)].into_iter().collect();
    let x = [[1.0, 0.0, 0.0]; 4];
    assert_eq!((goals.rms(&x), goals.largest(&x)), (1.0, 1.0));
    assert!(goals.rms(&x[..3]).is_nan() && goals.largest(&x[..3]).is_nan());
}
