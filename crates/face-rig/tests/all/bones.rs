//! Elements that the bones alone move.

use super::promise::Rig;
use face_rig::rig::{Parameters, RigError, RigParams};
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{Assembly, AssemblyBuilder, Dofs};
use fem_materials::{NeoHookean, StableNeoHookean};

/// Three layers, 1 cm each: the cranium below the first, the jaw above it, free flesh on the jaw.
fn mesh() -> SimplexMesh<3> {
    kuhn_grid(1, 1, 3, [0.01, 0.01, 0.03]).unwrap()
}

fn layer(mesh: &SimplexMesh<3>, z: f64) -> Vec<usize> {
    let nodes = mesh.nodes().iter().enumerate();
    nodes
        .filter(|(_, x)| (x[2] - z).abs() < 1e-9)
        .map(|(n, _)| n)
        .collect()
}

/// The jaw pushed through the cranium.
fn pushed() -> Parameters {
    let mut pose = Parameters::rest(0);
    pose.jaw.translation = [0.0, 0.0, -0.015];
    pose
}

#[test]
fn an_infinite_energy_that_no_flesh_can_mend_names_element_and_bones() {
    let mesh = mesh();
    let (cranium, jaw) = (layer(&mesh, 0.0), layer(&mesh, 0.01));
    let prescribed = [cranium.clone(), jaw.clone()].concat();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 4e4,
    };
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let flesh = builder.material(flesh).unwrap().build().unwrap();
    let mut rig = Rig::new(flesh, &jaw, RigParams::default()).unwrap();
    let error = rig.solve(&pushed()).unwrap_err();
    let RigError::MovedOutOfDomain {
        element,
        ratio,
        jaw: on_jaw,
        cranium: on_cranium,
    } = error
    else {
        panic!("{error}");
    };
    // The first tetrahedron of the first layer, squeezed from 1 cm to −0.5 cm.
    assert_eq!(element, 0);
    assert!((ratio + 0.5).abs() < 1e-12, "{ratio}");
    assert_eq!(on_jaw.len() + on_cranium.len(), 4);
    assert!(on_jaw.iter().all(|n| jaw.contains(&(*n as usize))));
    assert!(on_cranium.iter().all(|n| cranium.contains(&(*n as usize))));
    // The last pose stays, and one that the layer bears is found.
    assert_eq!(rig.equilibrium().parameters, Parameters::rest(0));
    let mut pressed = pushed();
    pressed.jaw.translation[2] = -0.005;
    let solved = rig.solve(&pressed).unwrap().clone();
    let quiet = &solved.parameters.activations;
    let at = rig
        .assembly()
        .configuration(&solved.in_cranium_frame, quiet);
    assert!(rig.assembly().energy(at.unwrap()).is_finite());
}

/// The body of the next tests, and its jaw.
fn flesh() -> (Assembly<3>, Vec<usize>) {
    let mesh = mesh();
    let (cranium, jaw) = (layer(&mesh, 0.0), layer(&mesh, 0.01));
    let prescribed = [cranium, jaw.clone()].concat();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed).unwrap();
    let flesh = StableNeoHookean {
        mu: 1e4,
        lambda: 4e4,
    };
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let flesh = builder.material(flesh).unwrap().build().unwrap();
    (flesh, jaw)
}

#[test]
fn a_model_with_an_energy_there_is_solved() {
    let (flesh, jaw) = flesh();
    let mut rig = Rig::new(flesh, &jaw, RigParams::default()).unwrap();
    rig.solve(&pushed()).unwrap();
}

/// What checks the rigs of these tests sees one that stopped early.
#[test]
#[should_panic = "N promised by Rounding"]
fn a_rig_that_claims_too_much_is_caught() {
    let (flesh, jaw) = flesh();
    let params = RigParams::default();
    let mut loose = params;
    loose.newton.relative_gradient_tolerance = 0.5;
    let mut rig = Rig::of(face_rig::rig::Rig::new(flesh, &jaw, loose).unwrap(), params);
    let mut pose = Parameters::rest(0);
    // A plate that is stretched, and flesh on it that is not.
    pose.jaw.matrix[0][0] = 1.5;
    let _ = rig.solve(&pose);
}
